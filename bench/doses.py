# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
From which size on wear is found, with and without a machine's own file; false alarms.

    python -m bench.doses --machines 20 --json doses.jsonl
    python -m bench.doses --generator frozen --machines 5 --json frozen_doses.jsonl

A machine is commissioned on two healthy days. Then healthy days (another day; warmer or colder
oil, in which its leakages follow the viscosity; rougher rock) must be told as healthy. Each effect
is given to it in doubling doses, until one is found and the one below is not: by the machine's own
file, and by the datasheet alone. Results go to the file line by line: the same command goes on
where it was interrupted.
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from itertools import product
import json
from pathlib import Path
import random
from test.truth import make_campaign
import time

from bench import doses_frozen
from bench.campaigns import run_of
from bench.score import wilson
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np

DOSES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)     # of what is typical today
START = {True: 0.2, False: 0.4}             # with and without the machine's own file
# The forms are drawn from these; dry friction alone is Coulomb's.
EFFECTS = {'motor_leakage': ('laminar', 'speed_dependent', 'mixed'),
           'pump_leakage': ('laminar', 'orifice', 'mixed'),
           'bearing_friction': ('tanh', 'atan'), 'pump_lag': ('first_order', 'second_order'),
           'entrained_air': ('polytropic', 'isothermal', 'henry')}
HEALTHY = ('another day', 'another temperature', 'another rock')
PARTS = ('healthy', 'own', 'datasheet')
_LOGS = ('drilling', 'speed_sweep')
_SECONDS, _RATE = 30.0, 100.0
_FIRST = 910_000    # seed
_LEVELS = (38.0, 44.0, 56.0, 62.0)      # degC
Day = Callable[..., tuple[dict, list[Run]]]


def day(machine: int, number: int, effect: str = '', dose: float = 0.0, *,
        celsius: float | None = None, rougher: bool = False) -> tuple[dict, list[Run]]:
    """Return datasheet and recordings of a machine on a day of its life."""
    seed = _FIRST + 1000 * machine + number
    hidden = {'leakage_temperature': {'size': 1.0, 'form': 'walther'}}
    if effect:
        hidden[effect] = {'size': dose, 'form': random.Random(seed).choice(EFFECTS[effect])}
    made = make_campaign(
        seed, hidden, duration=_SECONDS, rate_hz=_RATE, logs=_LOGS, keep_exact=False,
        unit_seed=_FIRST + machine, roughness=1.5 if rougher else 0.5,
        temperature='steady' if celsius is None else {
            name: (celsius, celsius + 2.0) for name in _LOGS})
    return made.sheet, [run_of(f'{number} {name}', columns) for name, columns in made.logs.items()]


GENERATORS: dict[str, Day] = {'truth': day, 'frozen': doses_frozen.day}


def healthy(day: Day, machine: int, what: str, number: int) -> list[Run]:
    """Return recordings of a day on which nothing is wrong."""
    level = random.Random(_FIRST + 1000 * machine + number).choice(_LEVELS)
    return day(machine, number, celsius=level if what == 'another temperature' else None,
               rougher=what == 'another rock')[1]


def judged(content: dict, runs: list[Run]) -> dict:
    """Return what a diagnosis names, look-alikes included."""
    began = time.process_time()
    found = diagnose(parse_rig(content, 'unit'), runs)
    return {'verdict': found.verdict, 'cpu_seconds': round(time.process_time() - began, 1),
            'named': sorted({name for entry in found.effects
                             for name in (entry.id, *entry.indistinguishable_from)})}


def trials(day: Day, machine: int, done: dict[tuple, dict], part: str,
           days: int) -> Iterator[dict]:
    """Yield what is left to be tried of a part on a machine, as rows."""
    if (machine, 'commissioned') in done and not done[machine, 'commissioned']['unit']:
        return
    sheet, first = day(machine, 0)
    row = done.get((machine, 'commissioned'))
    if row is None:
        try:
            unit = commission(sheet, 'rig', [*first, *day(machine, 1)[1]]).rig
        except InputError as problem:
            unit, told = None, str(problem)
        else:
            told = ''
        row = {'key': [machine, 'commissioned'], 'unit': unit, 'told': told}
        yield row
    if row['unit'] is None:
        return
    own = part != 'datasheet'
    content = row['unit'] if own else sheet
    if part == 'healthy':
        for turn, (number, what) in product(range(days), enumerate(HEALTHY, 10)):
            if (machine, what, turn) not in done:
                yield {'key': [machine, what, turn],
                       **judged(content, healthy(day, machine, what, 100 * turn + number))}
        return
    for number, effect in enumerate(EFFECTS, 20):
        place, found = DOSES.index(START[own]), {}
        while 0 <= place < len(DOSES) and place not in found:
            key = (machine, effect, own, DOSES[place])
            row = done.get(key)
            if row is None:
                row = {'key': [*key],
                       **judged(content, day(machine, number, effect, DOSES[place])[1])}
                yield row
            found[place] = effect in row['named']
            place += -1 if found[place] else 1


def thresholds(done: dict[tuple, dict]) -> dict[tuple[str, bool], list[float]]:
    """Return the smallest dose found, machine by machine; infinite where none was."""
    tried: dict[tuple, dict[float, bool]] = {}
    for key, row in done.items():
        if len(key) == 4:
            tried.setdefault(key[:3], {})[key[3]] = key[1] in row['named']
    found: dict[tuple[str, bool], list[float]] = {}
    for (_, effect, own), doses in tried.items():
        least = min((dose for dose, seen in doses.items() if seen), default=float('inf'))
        ends = (DOSES[0] in doses or DOSES[-1] in doses
                or any(not seen and dose < least for dose, seen in doses.items())
                and least < float('inf'))
        if ends:    # else it is still under way
            found.setdefault((effect, own), []).append(least)
    return found


def report(done: dict[tuple, dict]) -> str:
    """Return the tables."""
    lines = ['| effect | file | machines | found at 50 % | at 90 % | at a fifth of typical |',
             '|---|---|---|---|---|---|']
    for (effect, own), least in sorted(thresholds(done).items()):
        half, most = (np.quantile(least, share, method='inverted_cdf') for share in (0.5, 0.9))
        seen = sum(dose <= 0.2 for dose in least)
        lines.append(f'| {effect} | {"its own" if own else "datasheet"} | {len(least)} | {half:g} '
                     f'| {most:g} | {seen} of {len(least)} |')
    lines += ['', '| healthy | named | unknown | comparisons | alarms, 95 % interval |',
              '|---|---|---|---|---|']
    for what, kinds in (*((kind, (kind,)) for kind in HEALTHY), ('all', HEALTHY)):
        rows = [row for key, row in done.items() if key[1] in kinds]
        # That the leakages follow the viscosity is true.
        named = [bool({*row['named']} - {'leakage_temperature'}) for row in rows]
        unknown = sum(row['verdict'] == 'unknown' and not wrong
                      for row, wrong in zip(rows, named))
        if rows:
            lines.append(f'| {what} | {sum(named)} | {unknown} | {len(rows)} '
                         f'| {wilson(sum(named) + unknown, len(rows))} |')
    refused = [key[0] for key, row in done.items() if row.get('told')]
    return '\n'.join([*lines, '', f'refused as healthy: {len(refused)} machines {refused or ""}'])


def main() -> None:
    """Try what is left and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--generator', choices=GENERATORS, default='truth')
    parser.add_argument('--first', type=int, default=0, help='number of the first machine')
    parser.add_argument('--machines', type=int, default=20)
    parser.add_argument('--days', type=int, default=2, help='healthy days of each kind')
    parser.add_argument('--parts', nargs='+', choices=PARTS, default=PARTS)
    parser.add_argument('--json', default='doses.jsonl', help='JSON lines')
    args = parser.parse_args()
    output = Path(args.json)
    rows = [json.loads(line) for line in output.read_text(encoding='utf-8').splitlines()] \
        if output.exists() else []
    done = {tuple(row['key']): row for row in rows}
    with output.open('a', encoding='utf-8') as file:
        for part, machine in product(args.parts, range(args.first, args.first + args.machines)):
            for row in trials(GENERATORS[args.generator], machine, done, part, args.days):
                done[tuple(row['key'])] = row
                file.write(json.dumps(row) + '\n')
                file.flush()
                print(row['key'], row.get('named', row.get('told')), row.get('cpu_seconds', ''),
                      flush=True)
    print(report(done))


if __name__ == '__main__':
    main()
