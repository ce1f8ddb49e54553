# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Twenty machines over two years, and whether the page tells what happened to them.

    python -m bench.life --folder life

Machines of the truth generator wear (steadily, from some day on, faster and faster), get other
oil, are repaired, get another sensor, and have warm summers. Every two months two logs of 20 s are
recorded. ``fleet`` follows them; what it says is laid beside what was done. It goes on where it
was interrupted. ``--known``: what each wears by is given and nothing is diagnosed; how sizes
grow is judged alone.
"""
from __future__ import annotations

import argparse
from datetime import date, timedelta
import json
from pathlib import Path
import subprocess
import sys
from test.truth import make_campaign, write_campaign
from test.truth.catalogue import EFFECTS
from test.truth.unit import datasheet
from typing import NamedTuple

from hst_drive.fleet.campaigns import Campaign
from hst_drive.fleet.document import as_json
from hst_drive.fleet.life import Lives
from hst_drive.fleet.summary import summarise
from hst_drive.fleet.task import commission_machine, row_of, track_campaign
from hst_drive.fleet.track import to_follow
from hst_drive.rig import default_rig
import numpy as np
import yaml

START = date(2024, 1, 10)
MONTHS = range(0, 24, 2)
LIMIT = 2.0             # of what is typical
_DAYS = 365.25 / 12     # in a month
_LOGS = ('drilling', 'speed_sweep')
# Effect: form of the truth and its number, our parameter.
WEAR = {'motor_leakage': ('laminar', 'g_motor', 'conductance'),
        'pump_leakage': ('laminar', 'g_pump', 'conductance'),
        'bearing_friction': ('tanh', 't_coul', 'coulomb')}


class Life(NamedTuple):
    """
    What happens to a machine: months, sizes of what is typical.

    ``law`` is how it wears: 'steady', 'onset' or 'faster'; ``size`` what it is after 24 months;
    ``sensor`` an effect and its size from then on; ``summer``: K by which the oil is warmer.
    """

    wear: str = ''
    law: str = 'steady'
    size: float = 0.0
    onset: float = 0.0
    repair: float = 0.0
    oil: float = 0.0
    sensor: tuple[str, float, float] = ('', 0.0, 0.0)
    summer: float = 0.0


LIVES = (
    Life('motor_leakage', size=1.0), Life('pump_leakage', size=0.8, summer=8.0),
    Life('bearing_friction', size=1.1), Life('motor_leakage', size=0.6),
    Life('motor_leakage', 'onset', 1.0, 9.0), Life('pump_leakage', 'onset', 0.9, 7.0, summer=8.0),
    Life('bearing_friction', 'onset', 1.0, 10.0),
    Life('motor_leakage', 'faster', 1.0), Life('pump_leakage', 'faster', 1.0, summer=8.0),
    Life('bearing_friction', 'faster', 1.2),
    Life('motor_leakage', size=0.8, repair=13.0), Life('pump_leakage', size=0.8, repair=11.0,
                                                       summer=8.0),
    Life(oil=11.0), Life(oil=15.0, summer=8.0), Life('bearing_friction', size=0.9, oil=9.0),
    Life(sensor=('flow_sensor_scale', 13.0, 0.8)), Life(sensor=('torque_sensor_scale', 9.0, 0.7)),
    Life('motor_leakage', size=0.8, sensor=('torque_sensor_scale', 15.0, 0.7)),
    Life(summer=12.0), Life())


def worn(life: Life, month: float) -> float:
    """Return how large the wear is, in what is typical."""
    begin = life.onset
    if life.repair and month > life.repair:
        begin = life.repair
    share = max(month - begin, 0.0) / (24.0 - life.onset)
    return life.size * (float(np.expm1(3.0 * share) / np.expm1(3.0)) if life.law == 'faster'
                        else share)


def reached(life: Life) -> float:
    """Return the month in which the limit is reached."""
    months = np.linspace(0.0, 1200.0, 120_001)
    sizes = np.array([worn(life, month) for month in months])
    return float(months[np.argmax(sizes >= LIMIT)]) if (sizes >= LIMIT).any() else np.inf


def sheet_of(life: Life, month: float) -> dict:
    """Return the datasheet with the numbers of the oil that is in the machine."""
    sheet = datasheet()
    if life.oil and month > life.oil:
        sheet['line']['bulk_modulus_Pa'] *= 0.85
        for part in ('pump', 'motor'):
            table = sheet[part]['leakage_L_min']
            table['table'] = [[1.25 * value for value in row] for row in table['table']]
    return sheet


def make(folder: Path, number: int, life: Life, first: int) -> None:
    """Write the campaigns of a machine."""
    place = folder / f'rig_{number + 1:02}'
    for month in MONTHS:
        day = START + timedelta(days=round(month * _DAYS))
        at = place / day.isoformat()
        if at.exists():
            continue
        hidden = {'leakage_temperature': {'size': 1.0, 'form': 'walther'}}
        if life.wear and (size := worn(life, month)) > 0.0:
            hidden[life.wear] = {'size': size, 'form': WEAR[life.wear][0]}
        name, since, size = life.sensor
        if name and month > since:
            hidden[name] = {'size': size, 'form': 'factor'}
        seed = first + 100 * number + month
        warm = 50.0 + life.summer * np.sin(2.0 * np.pi * (month - 2.0) / 12.0) + float(
            np.random.default_rng(seed).uniform(-1.5, 1.5))
        made = make_campaign(seed, hidden, duration=20.0, rate_hz=50.0, logs=_LOGS,
                             sheet=sheet_of(life, month), unit_seed=first + number,
                             temperature={log: (warm - 1.0, warm + 1.0) for log in _LOGS},
                             keep_exact=False)
        write_campaign(made, at)
        (at / 'rig.yaml').unlink()
    (place / 'rig.yaml').write_text(yaml.safe_dump(datasheet(), sort_keys=False))


def told(machine: dict, life: Life) -> dict[str, bool]:
    """Return what of a machine's life was told rightly."""
    def between(month: float, effects: tuple[str, ...]) -> bool:
        day = (START + timedelta(days=round(month * _DAYS))).isoformat()
        return any(entry['after'] <= day <= entry['before'] and set(entry['effects']) & {*effects}
                   for entry in machine['events'])

    entries = {entry['effect']: entry for entry in machine['followed']}
    found = {}
    if life.wear:
        own = entries.get(life.wear, {})
        found['wear'] = own.get('kind') in ('grows', 'accelerates')
        left, true = own.get('remaining'), START + timedelta(days=reached(life) * _DAYS)
        found['remaining'] = bool(left) and (left['low'] or '9') <= true.isoformat() <= (
            left['high'] or '9')
    if life.oil:
        found['oil'] = between(life.oil, ('line.bulk_modulus',))
    if life.repair:
        found['repair'] = between(life.repair, (life.wear,))
    if life.sensor[0]:
        found['sensor'] = between(life.sensor[1], (life.sensor[0],))
    # Summers and sound machines: nothing that was not done is told as growing or as an event.
    right = sum(bool(value) for value in (life.oil, life.repair, life.sensor[0]))
    growing = {name for name, entry in entries.items()
               if entry['kind'] in ('grows', 'accelerates') and entry['size'][0] > 0.0}
    found['nothing else'] = not growing - {life.wear} and len(machine['events']) <= right
    return found


def fleet(folder: Path, args: argparse.Namespace, limits: dict[tuple[str, str], float]) -> dict:
    """Return what the program says."""
    subprocess.run([sys.executable, '-m', 'hst_drive', 'fleet', str(folder / 'logs'), '--results',
                    str(folder / 'results'), '--json', str(folder / 'fleet.json'), '-o',
                    str(folder / 'fleet.html'), '--workers', str(args.workers),
                    *(f'--limit={name}={size:.6g}' for (name, _), size in limits.items())],
                   check=True)
    return json.loads((folder / 'fleet.json').read_text())


def known(folder: Path, args: argparse.Namespace, limits: dict[tuple[str, str], float]) -> dict:
    """Return what the fleet tells if each machine's effect is known."""
    rows, sizes = [], []
    for number in args.machines:
        name, wear = f'rig_{number:02}', LIVES[number - 1].wear
        place = folder / 'logs' / name
        days = [Campaign(day.name, name, day.name, tuple(map(str, sorted(day.glob('*.csv')))), (),
                         rig=str(place / 'rig.yaml'))
                for day in sorted(place.iterdir()) if day.is_dir()]
        unit = folder / f'{name}.yaml'
        unit.write_text(yaml.safe_dump(commission_machine(days[0]._replace(
            logs=days[0].logs + days[1].logs))['unit']))
        effects = to_follow((), default_rig(), [wear] if wear else ())
        rows += [row_of(day, status='commissioned', reason=None, diagnosis=None) for day in days]
        sizes += [track_campaign(day._replace(rig=str(unit)), {name: effects}) for day in days]
    lives = Lives(rows, {}, sizes)
    return as_json(lives, summarise(lives, limits))


def main() -> None:
    """Make what is missing, follow the fleet and print what was told."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--folder', default='life')
    parser.add_argument('--machines', type=int, nargs='+', default=range(1, len(LIVES) + 1),
                        help='numbers of those to follow (default: all)')
    parser.add_argument('--seed', type=int, default=930_000)
    parser.add_argument('--known', action='store_true', help='the effect is given')
    parser.add_argument('--workers', type=int, default=1)
    args = parser.parse_args()
    folder = Path(args.folder)
    for number in args.machines:
        make(folder / 'logs', number - 1, LIVES[number - 1], args.seed)
    limits = {(name, key): LIMIT * EFFECTS[name].typical[number]
              for name, (_, number, key) in WEAR.items()}
    follow = known if args.known else fleet
    machines = {entry['name']: entry for entry in follow(folder, args, limits)['machines']}
    count: dict[str, list[bool]] = {}
    for number in args.machines:
        life, name = LIVES[number - 1], f'rig_{number:02}'
        found = told(machines[name], life)
        print(name, life, found, *machines[name]['told'], sep='\n  ')
        for what, right in found.items():
            count.setdefault(what, []).append(right)
    print('\n| told | right | of |\n|---|---|---|')
    for what, found in count.items():
        print(f'| {what} | {sum(found)} | {len(found)} |')


if __name__ == '__main__':
    main()
