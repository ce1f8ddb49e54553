# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How fast it is: one table with the machine, medians of several runs, and ratios.

    python -m bench.speed [simulation diagnosis compare bags start nodes nodes_first] [--runs 3]

Times are CPU seconds, so that other work on the machine counts little; its load is printed. The
part 'nodes' needs rclpy; late is how long after its time the plant took a sample. 'nodes_first' is
the same with a real-time priority for the nodes: on a busy machine, the nearest to an idle one;
needs root.
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
import os
from pathlib import Path
import platform
from statistics import median
import subprocess
import sys
import tempfile
from typing import NamedTuple

from bench import live, speed_cases as cases
from hst_drive.cli import verbs
from hst_drive.cli.output import table


class Row(NamedTuple):
    """A line of the table: CPU and wall seconds, a ratio and of what, and a remark."""

    what: str
    cpu: float
    wall: float
    ratio: str = ''
    remark: str = ''


def machine() -> str:
    """Return what this ran on, and how busy it was."""
    from importlib.metadata import version

    name = platform.processor() or platform.machine()
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
        name = next(line.partition(':')[2].strip() for line in lines if 'model name' in line)
    except (OSError, StopIteration):
        pass
    packages = ', '.join(f'{key} {version(key)}' for key in ('numpy', 'scipy', 'numba'))
    return (f'{name}, {os.cpu_count()} cores, Python {platform.python_version()}, {packages}; '
            f'load average {os.getloadavg()[0]:.1f} (1 min) at the start')


def timed(work: Callable[[], object], runs: int) -> tuple[float, float]:
    """Return the medians of CPU and wall seconds."""
    found = [cases.clocked(work) for _ in range(runs)]
    return median(entry[0] for entry in found), median(entry[1] for entry in found)


def simulation(runs: int) -> Iterator[Row]:
    """100 s at 1 ms against SciPy's solvers at the accuracy that ours has."""
    problem = cases.Simulation()
    error = problem.error(problem.ours()['all'])
    base = timed(problem.baseline, runs * 3)
    yield Row('baseline, 100,001 rows', *base, f'{100 / base[0]:.0f} x real time',
              f'error {error:.1e} of range')
    circuit = cases.Closed()
    error_there = circuit.error()
    closed = timed(circuit.simulate, runs * 3)
    yield Row('closed circuit, 100,001 rows', *closed, f'{closed[0] / base[0]:.2f} x baseline',
              f'error {error_there:.1e} of range')
    every = timed(problem.every_effect, runs * 3)
    yield Row(f'all {problem.count} effects', *every, f'{every[0] / base[0]:.2f} x baseline')
    for share in (0.25, 0.5):
        part = timed(lambda share=share: problem.effects(share), runs * 3)
        yield Row(f'{round(share * problem.count)} effects', *part,
                  f'{part[0] / base[0]:.2f} x baseline')
    for factor in (2, 4):
        longer = timed(lambda factor=factor: problem.longer(factor), runs)
        yield Row(f'baseline, {100 * factor} s', *longer, f'{longer[0] / base[0]:.2f} x baseline')
    plain = timed(problem.plain, 1)
    yield Row('baseline in plain Python, 10 s', *plain,
              f'{10 * plain[0] / base[0]:.0f} x baseline, by length', 'without numba')
    for method in ('LSODA', 'Radau'):
        tolerance, reached, calls = problem.as_accurate(method, max(error, 1e-5))
        peer = timed(lambda m=method, t=tolerance: problem.scipy(m, t), 1)
        yield Row(f'{method}, Python equations, 100 s', *peer,
                  f'{peer[0] / base[0]:.0f} x baseline',
                  f'rtol {tolerance:.0e}, error {reached:.1e}, {calls} evaluations')


def diagnosis(runs: int) -> Iterator[Row]:
    """Diagnosis time against length, channels (so candidates) and what is missing."""
    first = 0.0
    for seconds, effects, channels in cases.DIAGNOSES:
        logs = cases.campaign(seconds, effects, channels)
        count = cases.candidates(logs)
        found = timed(lambda logs=logs: cases.diagnosed(logs), runs)
        first = first or found[0]
        without = f', without {" and ".join(channels)}' if channels else ''
        yield Row(f'4 logs x {seconds:g} s, {len(effects)} effects, {count} candidates{without}',
                  *found, f'{found[0] / first:.2f} x the first')


def compare(runs: int) -> Iterator[Row]:
    """Compare and report of long logs, as a user calls them, with the peak of memory."""
    with tempfile.TemporaryDirectory() as folder:
        for minutes in (10, 60):
            log = cases.long_log(Path(folder) / f'{minutes}min.csv', minutes)
            for verb, more in (('compare', []), ('report', ['-o', f'{folder}/page.html',
                                                            '--no-diagnosis'])):
                found = [cases.called([verb, log, *more]) for _ in range(runs)]
                cpu, wall = (median(entry[place] for entry in found) for place in (0, 1))
                yield Row(f'{verb} {minutes} min at 100 Hz, from CSV', cpu, wall,
                          f'{60 * minutes / cpu:.0f} x real time',
                          f'peak {max(entry[2] for entry in found):.0f} MB')


def bags(runs: int) -> Iterator[Row]:
    """Write and read a bag against the package rosbags, the same messages."""
    with tempfile.TemporaryDirectory() as folder:
        bench = cases.Bags(Path(folder))
        for what in ('write', 'read'):
            ours = timed(getattr(bench, what), runs)
            other = timed(getattr(bench, f'{what}_with_rosbags'), runs)
            rate = bench.messages / ours[0]
            yield Row(f'{what} {bench.messages} messages', *ours, f'{rate:.0f} messages/s',
                      'numbers, not objects' if what == 'read' else 'zstd, as Jazzy writes them')
            yield Row('  the same with rosbags', *other, f'{other[0] / ours[0]:.1f} x ours')


def start(runs: int) -> Iterator[Row]:
    """Start-up of each verb: its help, in a process of its own."""
    for verb in ('', *verbs()):
        found = [cases.called([verb, '--help'] if verb else ['--help']) for _ in range(runs)]
        cpu, wall = (median(entry[place] for entry in found) for place in (0, 1))
        yield Row(f'hst-drive {verb} --help'.replace('  ', ' '), cpu, wall, '',
                  f'peak {max(entry[2] for entry in found):.0f} MB')


def nodes(runs: int) -> Iterator[Row]:
    """All nodes at once: lockstep as fast as it goes, and real time at 100 Hz and 1 kHz."""
    yield from _nodes(runs, False)


def nodes_first(runs: int) -> Iterator[Row]:
    """As ``nodes``, before all other work: nearly as on an idle machine; needs root."""
    yield from _nodes(runs, True)


def _nodes(runs: int, first: bool) -> Iterator[Row]:
    found = [live.run(60.0, first=first) for _ in range(runs)]
    factor = median(entry.factor for entry in found)
    yield _live_row('lockstep, 100 Hz, 60 s', found, f'{factor:.1f} x real time',
                    live.cpu_text(found, 1e3, 'ms CPU per simulated s'))
    for rate in (100.0, 1000.0):
        found = [live.run(12.0, realtime=True, rate=rate, first=first) for _ in range(runs)]
        late = [1e3 * median(entry.late[place] for entry in found) for place in range(3)]
        yield _live_row(f'real time, plant at {rate:g} Hz, 10 s', found,
                        'late p50 {:.2f}, p99 {:.2f}, max {:.2f} ms'.format(*late),
                        live.cpu_text(found, 100, '% CPU'))


def _live_row(what: str, found: list[live.Found], ratio: str, remark: str) -> Row:
    return Row(what, median(sum(entry.cpu.values()) for entry in found),
               median(entry.wall for entry in found), ratio, remark)


PARTS = {'simulation': simulation, 'diagnosis': diagnosis, 'compare': compare, 'bags': bags,
         'start': start, 'nodes': nodes, 'nodes_first': nodes_first}


def main() -> int:
    """Run the parts that were asked for, and print a table each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('parts', nargs='*', metavar='PART', choices=[*PARTS, []],
                        help=f'{", ".join(PARTS)} (default: all but the last)')
    parser.add_argument('--runs', type=int, default=3)
    args = parser.parse_args()
    print(machine())
    commit = subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], capture_output=True,
                            text=True, check=False).stdout.strip()
    print(f'median of {args.runs} runs or more; commit {commit}', flush=True)
    for name in args.parts or [name for name in PARTS if name != 'nodes_first']:
        rows = []
        for row in PARTS[name](args.runs):
            print(f'{name}: {row.what}: {row.cpu:.4g} s', file=sys.stderr, flush=True)
            rows.append([row.what, f'{row.cpu:.4g}', f'{row.wall:.4g}', row.ratio, row.remark])
        print(f'\n{name}', table(['', 'CPU s', 'wall s', 'ratio', ''], rows), sep='\n',
              flush=True)
    print(f'\nload average at the end: {os.getloadavg()[0]:.1f}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
