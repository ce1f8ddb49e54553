# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
All nodes for a long time: does memory grow, is a step late or lost, do clock and data part.

    python -m bench.soak --minutes 20                  # real time
    python -m bench.soak --minutes 20 --first          # the nodes go before all other work
    python -m bench.soak --hours 24                    # simulated time, as fast as it goes
    python -m bench.soak --hours 24 --rate 10          # a tenth of the steps
    python -m bench.soak --minutes 60 --respawn 10     # a node is killed every 10 min (respawn.py)

The processes are watched from outside and the bag is read afterwards. Prints a table and OK, or
what is out (exit code 1). Ctrl-C ends a run early; what there is by then is judged.
"""
from __future__ import annotations

import argparse
import os
from pathlib import Path
import platform
import signal
import subprocess
import sys
import tempfile
from test.nodes.processes import children
import time
from typing import NamedTuple

from hst_drive.bag import read_log
from mcap.reader import make_reader
import numpy as np

SCENARIO = """
title: Soak
duration_s: {seconds}
seed: 4
speed_setpoint: {{kind: random_steps, low_speed_rpm: 60, high_speed_rpm: 130, shortest_s: 20, longest_s: 60}}
load: {{kind: random_steps, low_torque_N_m: 40, high_torque_N_m: 220, shortest_s: 3, longest_s: 15}}
oil_temperature: {{kind: ramps, time_s: [0, {seconds}], temperature_degC: [40, 60]}}
"""  # noqa: E501
_EVERY = 5.0            # s between two looks at the processes
_WARM = 0.25            # of the time, until all has been allocated that is ever needed
_STARTED = 2.0          # s after which the drive turns
_ENOUGH = 2.0           # MB: less is not called growth
_INTERRUPTED = 130      # exit code of a run that was ended early


class Memory(NamedTuple):
    """A process: resident memory at start and end (MB), its slope (MB/h), and its CPU (%)."""

    start: float
    end: float
    slope: float
    cpu: float


def main(arguments: list[str] | None = None) -> int:
    """Run the nodes and say how it went."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument('--minutes', type=float, help='of real time')
    length.add_argument('--hours', type=float, help='of simulated time')
    parser.add_argument('--rate', type=float, default=100.0,
                        help='samples per second (default: 100; with --respawn always)')
    parser.add_argument('--jitter', type=float, default=10.0,
                        help='ms by which a reading may come late (default: a period)')
    parser.add_argument('--late', type=float, default=0.1,
                        help='%% of the readings that may come later (default: 0.1)')
    parser.add_argument('--growth', type=float, default=5.0,
                        help='MB by which a process may grow in an hour of drilling (default: 5)')
    parser.add_argument('--first', action='store_true',
                        help='nodes have real-time priority: on a machine that others use')
    parser.add_argument('--respawn', type=float, metavar='MINUTES',
                        help='with --minutes: kill a node so often; it is started again')
    parser.add_argument('--output', help='keep the bag in this folder')
    args = parser.parse_args(arguments)
    real = args.minutes is not None
    if args.respawn is not None and not (real and args.respawn > 0.0):
        parser.error('--respawn takes a number of minutes above 0, and needs --minutes')
    seconds = 60.0 * args.minutes if real else 3600.0 * args.hours
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(args.output or Path(folder) / 'bag')
        scenario = Path(folder) / 'soak.yaml'
        scenario.write_text(SCENARIO.format(seconds=seconds), encoding='utf-8')
        if args.respawn is not None:
            from bench.respawn import soak      # needs rclpy
            return tell(soak(scenario, bag, seconds, 60.0 * args.respawn, args.first))
        process = subprocess.Popen(
            [sys.executable, '-m', 'hst_drive', 'run', str(scenario), '-o', str(bag),
             '--rate', str(args.rate),
             *(['--realtime'] if real else []), *(['--priority', '10'] if args.first else [])],
            stderr=subprocess.PIPE, text=True, stdout=subprocess.PIPE)
        began = time.monotonic()
        memory = watch(process)
        wall = time.monotonic() - began
        out, err = process.communicate()
        if process.returncode == _INTERRUPTED:
            seconds = lasted(bag)
        elif process.returncode:
            print(err.strip().splitlines()[-1])
            return 1
        # By the hour of drilling: in simulated time a day passes within one by the clock.
        pace = 1.0 if real else wall / seconds
        memory = {name: entry._replace(slope=pace * entry.slope)
                  for name, entry in memory.items()}
        print(f'{machine()}; load average {os.getloadavg()[1]:.1f} in the last 5 minutes')
        print(f'{seconds / 60:g} min in {"real" if real else "simulated"} time, {args.rate:g} Hz, '
              f'{wall:.0f} s by the clock on the wall'
              f'{", nodes before all other work" * args.first}\n')
        wrong = judge_memory(memory, args.growth)
        wrong += judge_data(bag, seconds, real, args)
        wrong += judge_drive(bag) if real else []
    return tell(wrong)


def tell(wrong: list[str]) -> int:
    """Print what is out, if anything; return the exit code."""
    print('\nOK' if not wrong else '\nOUT: ' + '; '.join(wrong))
    return 1 if wrong else 0


def machine() -> str:
    """Return what this ran on."""
    model = next((line.partition(':')[2].strip() for line in open('/proc/cpuinfo')
                  if line.startswith('model name')), platform.machine())
    return f'{model}, {os.cpu_count()} cores, Python {platform.python_version()}'


def watch(process: subprocess.Popen) -> dict[str, Memory]:
    """Look at the nodes until the run ends; return what each used."""
    page, tick = os.sysconf('SC_PAGE_SIZE') / 1e6, os.sysconf('SC_CLK_TCK')
    rows: dict[str, list[tuple[float, float, float]]] = {}
    known: dict[str, int] = {}
    while process.poll() is None:
        try:
            time.sleep(_EVERY if len(known) >= 5 else 0.5)
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
        if len(known) < 5:
            known = children(process.pid)
            continue
        for name, pid in known.items():
            try:
                resident = int(Path(f'/proc/{pid}/statm').read_text().split()[1]) * page
                words = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
            except (OSError, IndexError):
                continue        # it has just ended
            if resident:
                used = (int(words[11]) + int(words[12])) / tick
                rows.setdefault(name, []).append((time.monotonic(), resident, used))
    return {name: memory_of(np.array(entry)) for name, entry in rows.items() if len(entry) >= 8}


def memory_of(rows: np.ndarray) -> Memory:
    """Return what looks at a process tell: rows of time (s), memory (MB) and CPU time (s)."""
    at, size, used = rows.T
    warm = at >= at[0] + _WARM * (at[-1] - at[0])
    t, y = at[warm], size[warm]
    i, j = np.triu_indices(len(t), 1)
    thin = slice(None, None, max(len(i) // 200_000, 1))
    # Theil and Sen's slope: a single step up or down does not tilt it.
    slope = float(np.median((y[j] - y[i])[thin] / (t[j] - t[i])[thin])) * 3600.0
    return Memory(float(size[0]), float(size[-1]), slope,
                  100.0 * float(used[-1] - used[0]) / float(at[-1] - at[0]))


def judge_memory(memory: dict[str, Memory], growth: float) -> list[str]:
    """Print memory by node; return which grow."""
    if not memory:
        return ['too short to see the memory (take a minute at least)']
    print(f'{"node":14}{"start MB":>10}{"end MB":>10}{"MB/h":>10}{"CPU %":>8}')
    for name, entry in sorted(memory.items()):
        print(f'{name:14}{entry.start:10.1f}{entry.end:10.1f}{entry.slope:+10.2f}{entry.cpu:8.1f}')
    return [f'{name} grows by {entry.slope:.1f} MB/h' for name, entry in memory.items()
            if entry.slope > growth and entry.end - entry.start > _ENOUGH]


def judge_data(bag: Path, seconds: float, real: bool, args: argparse.Namespace) -> list[str]:
    """Print how the bag's messages lie in time; return what is out."""
    wrong, period = [], 1e3 / args.rate     # ms
    steps = round(seconds * args.rate)
    print()
    for name in ('motor', 'pump_command'):
        logged, stamps = times(bag, name)
        if len(stamps) < 2:
            return [f'{name}: no messages']
        gaps = np.diff(np.sort(stamps)) / 1e6
        print(f'{name}: {len(stamps)} messages of {steps} steps, at most {gaps.max():.1f} ms '
              'apart')
        # Readings lie on the grid of the steps; a command has the time at which it was formed.
        if len(stamps) < steps or name == 'motor' and gaps.max() > 1.5 * period:
            wrong.append(f'{name}: steps are missing')
        if not real:
            continue
        late = (logged - stamps) / 1e6
        tail = ', '.join(f'{label} {value:.2f}' for label, value in zip(
            ('p50', 'p99', 'p99.9', 'max'), np.percentile(late, [50, 99, 99.9, 100])))
        share = 100.0 * float(np.mean(late > args.jitter))
        print(f'  recorded after its stamp [ms]: {tail}; {share:.3f} % later than '
              f'{args.jitter:g} ms')
        if share > args.late:
            wrong.append(f'{name}: {share:.2f} % come later than {args.jitter:g} ms')
        tenth = max(len(late) // 10, 1)
        drift = float(np.median(late[-tenth:]) - np.median(late[:tenth]))
        print(f'  clock against data, last tenth less first [ms]: {drift:+.3f}')
        if abs(drift) > args.jitter / 10:
            wrong.append(f'{name}: clock and data part by {drift:.2f} ms')
    return wrong


def judge_drive(bag: Path) -> list[str]:
    """Return when the controller stopped, if it did: a drive at rest is no soak."""
    run = read_log(bag)
    stopped = np.flatnonzero((run['pump_command'] == 0.0) & (run.time > _STARTED))
    if not len(stopped):
        return []
    return [f'the controller was at 0 V for {len(stopped) * run.sample_time:.0f} s, first at '
            f'{run.time[stopped[0]]:.0f} s (a stop: see /diagnostics)']


def lasted(bag: Path) -> float:
    """Return for how many seconds of the run there are readings."""
    _, stamps = times(bag, 'motor')
    return float(np.ptp(stamps)) / 1e9


def times(bag: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return when the messages of a topic were recorded and stamped, ns."""
    rows = []
    for path in sorted(bag.glob('*.mcap')):
        with open(path, 'rb') as stream:
            rows += [(message.log_time, message.publish_time)
                     for _, _, message in make_reader(stream).iter_messages(
                         topics=[f'/drive/{name}'], log_time_order=False)]
    found = np.array(rows, dtype=np.int64).reshape(-1, 2)
    return found[:, 0], found[:, 1]


if __name__ == '__main__':
    sys.exit(main())
