# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the answer stays when nothing that matters changes.

    python -m bench.metamorphic --campaigns 10 --json metamorphic.jsonl

Each campaign of the truth generator is diagnosed as it is and then recorded otherwise: fewer rows,
lost rows, scattered time stamps, logs in another order or cut in two, another log held out or
none, noisier sensors, other units, as bags. Told is how often verdict and names stay. Results go
to the file line by line: the same command goes on where it was interrupted.
"""
from __future__ import annotations

import argparse
from collections.abc import Callable
import json
from pathlib import Path
import tempfile
from test.truth import make_campaign
from test.truth.sensors import noise_of
import time

from bench.campaigns import HOLDOUT, run_of
from bench.score import wilson
from hst_drive.bag import read_log
from hst_drive.bag.writer import write_run
from hst_drive.diagnose.decide import diagnose
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
from hst_drive.units import from_si, parse_header, to_si
import numpy as np

Columns = dict[str, np.ndarray]
Logs = dict[str, Columns]
SECONDS = 40.0
_FIRST = 930_000    # seed
#: What is hidden in turn, relative to typical.
HIDDEN = ({}, {'motor_leakage': 1.0}, {'bearing_friction': 0.8}, {'pump_lag': 1.0},
          {'entrained_air': 1.0}, {'line_loss': 1.0}, {'leakage_temperature': 1.0},
          {'pump_hysteresis': 1.0}, {'viscous_drag': 1.2}, {'motor_leakage': 0.7, 'pump_lag': 0.8})
_OTHER = {'bar': 'psi', 'rpm': 'rad/s', 'L/min': 'm^3/s', 'degC': 'K'}


def _rows(columns: Columns, chosen: np.ndarray | slice) -> Columns:
    return {name: np.asarray(values)[chosen] for name, values in columns.items()}


def every(step: int) -> Callable[[Logs], Logs]:
    """Return what keeps each so-manieth row."""
    return lambda logs: {name: _rows(columns, slice(None, None, step))
                         for name, columns in logs.items()}


def lost(logs: Logs) -> Logs:
    """Lose 30 % of the rows."""
    rng = np.random.default_rng(1)
    return {name: _rows(columns, np.sort(rng.permutation(len(columns['time[s]']))[
        :int(0.7 * len(columns['time[s]']))])) for name, columns in logs.items()}


def scattered(logs: Logs) -> Logs:
    """Scatter the time stamps by 1 ms."""
    rng = np.random.default_rng(2)
    return {name: {**columns, 'time[s]': columns['time[s]'] + 1e-3 * rng.uniform(
        -1, 1, len(columns['time[s]']))} for name, columns in logs.items()}


def cut(logs: Logs) -> Logs:
    """Cut each log that is fitted in two."""
    found = {}
    for name, columns in logs.items():
        half = len(columns['time[s]']) // 2
        if name == HOLDOUT:
            found[name] = columns
        else:
            found |= {f'{name} 1': _rows(columns, slice(half)),
                      f'{name} 2': _rows(columns, slice(half, None))}
    return found


def turned(logs: Logs) -> Logs:
    """Give the logs in the opposite order."""
    return dict(reversed(logs.items()))


def other_units(logs: Logs) -> Logs:
    """Write pressures in psi, speeds in rad/s, flows in m^3/s and temperatures in K."""
    def renamed(header: str, values: np.ndarray) -> tuple[str, np.ndarray]:
        name, unit = parse_header(header)
        other = _OTHER.get(unit, unit)
        return f'{name}[{other}]', values if other == unit else from_si(
            to_si(np.asarray(values, dtype=float), unit), other)

    return {name: dict(renamed(*item) for item in columns.items())
            for name, columns in logs.items()}


def noisier(sheet: dict) -> Callable[[Logs], Logs]:
    """Return what adds half of each sensor's noise."""
    def add(logs: Logs) -> Logs:
        rng = np.random.default_rng(3)
        found: Logs = {}
        for name, columns in logs.items():
            found[name] = dict(columns)
            for header in columns:
                channel, _ = parse_header(header)
                if channel in sheet['sensors']:
                    values = np.asarray(columns[header], dtype=float)
                    found[name][header] = values + 0.5 * noise_of(sheet, channel)[
                        0] * rng.standard_normal(len(values))
        return found

    return add


def same(logs: Logs) -> Logs:
    """Change nothing."""
    return logs


#: Name: what it does to the logs, and the log that is held out ('' for none).
CHANGES: dict[str, tuple[Callable[[Logs], Logs], str]] = {
    'as it is': (same, HOLDOUT), '50 Hz': (every(2), HOLDOUT), '25 Hz': (every(4), HOLDOUT),
    '30 % of rows lost': (lost, HOLDOUT), 'stamps scatter by 1 ms': (scattered, HOLDOUT),
    'other order': (turned, HOLDOUT), 'cut in two': (cut, HOLDOUT),
    'another log held out': (same, 'drilling'), 'none held out': (same, ''),
    'half a noise more': (same, HOLDOUT), 'other units': (other_units, HOLDOUT),
    'bags': (same, HOLDOUT)}


def as_bags(runs: list[Run]) -> list[Run]:
    """Return recordings as they are read back from bags."""
    with tempfile.TemporaryDirectory() as folder:
        for number, run in enumerate(runs):
            write_run(Path(folder) / str(number), run)
        return [read_log(Path(folder) / str(number)) for number in range(len(runs))]


def answer(number: int, change: str) -> dict:
    """Diagnose a campaign under a change; return what was told."""
    made = make_campaign(_FIRST + number, HIDDEN[number % len(HIDDEN)], duration=SECONDS,
                         keep_exact=False)
    change_logs, held = CHANGES[change]
    if change == 'half a noise more':
        change_logs = noisier(made.sheet)
    logs = change_logs(made.logs)
    runs = {name: run_of(name, columns) for name, columns in logs.items()}
    if change == 'bags':
        runs = dict(zip(runs, as_bags(list(runs.values()))))
    start = time.perf_counter()
    found = diagnose(parse_rig(made.sheet), [run for name, run in runs.items() if name != held],
                     [run for name, run in runs.items() if name == held])
    return {'campaign': number, 'change': change, 'hidden': list(made.truth['forms']),
            'verdict': found.verdict, 'named': sorted(entry.id for entry in found.effects),
            'sets': [sorted({entry.id, *entry.indistinguishable_from})
                     for entry in found.effects],
            'seconds': time.perf_counter() - start}


def agrees(usual: dict, row: dict) -> bool:
    """Say whether two answers are the same: nothing that one names is ruled out by the other."""
    def within(named: list[str], sets: list[list[str]]) -> bool:
        return len(named) == len(sets) and all(
            any(name in entry for entry in sets) for name in named)

    return (usual['verdict'] == 'unknown') == (row['verdict'] == 'unknown') and (
        usual['named'] == row['named'] or within(usual['named'], row['sets'])
        or within(row['named'], usual['sets']))


def main() -> None:
    """Run the benchmark, or what is left of it, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--campaigns', type=int, default=10)
    parser.add_argument('--json', type=Path, required=True)
    args = parser.parse_args()
    rows = [json.loads(line) for line in args.json.read_text(encoding='utf-8').splitlines()
            ] if args.json.exists() else []
    done = {(row['campaign'], row['change']) for row in rows}
    for number in range(args.campaigns):
        for change in CHANGES:
            if (number, change) not in done:
                rows.append(answer(number, change))
                with args.json.open('a', encoding='utf-8') as file:
                    file.write(json.dumps(rows[-1]) + '\n')
                print({key: value for key, value in rows[-1].items() if key != 'sets'}, flush=True)
    usual = {row['campaign']: row for row in rows if row['change'] == 'as it is'}
    for change in CHANGES:
        own = [row for row in rows if row['change'] == change]
        alike = sum(agrees(usual[row['campaign']], row) for row in own)
        print(f'{change}: the same answer in {wilson(alike, len(own))} of {len(own)}')


if __name__ == '__main__':
    main()
