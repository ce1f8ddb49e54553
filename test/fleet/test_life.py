# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A pump over its life, from files to a page: commissioned by itself, followed, its limit told."""
import json

from hst_drive import cli
from hst_drive.fleet.life import written
from hst_drive.fleet.store import Store
from hst_drive.rig import load_rig
from hst_drive.units import from_si
import numpy as np
import pytest
import yaml

from ..diagnose.machines import day, MAKE

UNITS = {'pump_outlet_pressure': 'bar', 'pump_speed': 'rpm', 'motor_inlet_flow': 'L/min',
         'oil_temperature': 'degC'}
MONTHS = (1, 3, 5, 7, 9, 11)
LEAKS = (0.0, 0.0, 0.1, 0.2, 0.3, 0.4)


@pytest.mark.parametrize('one, other', [('rig ö', 'rig ü'), ('a/b', 'a b')])
def test_each_machine_has_a_file_of_its_own(tmp_path, one, other):
    store = Store(tmp_path / 'kept')
    assert written(store, one, {'name': one}) != written(store, other, {'name': other})
    assert {yaml.safe_load(path.read_text())['name']
            for path in (tmp_path / 'kept' / 'units').iterdir()} == {one, other}


def put(folder, made):
    """Write a log."""
    folder.mkdir(parents=True)
    header = ','.join(['time[s]', *(f'{key}[{unit}]' for key, unit in UNITS.items())])
    table = np.column_stack([made.time, *(from_si(made[key], unit)
                                          for key, unit in UNITS.items())])
    np.savetxt(folder / 'log.csv', table, delimiter=',', header=header, comments='')


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    """Return the folder of a fleet that was followed, its JSON and its page."""
    place = tmp_path_factory.mktemp('fleet')
    for number, (month, leak) in enumerate(zip(MONTHS, LEAKS)):
        put(place / 'logs' / 'wears' / f'2026-{month:02}-01', day(20 + number, leak))
    for number, leak in enumerate((2.0, 2.0, 2.0)):
        put(place / 'logs' / 'broken' / f'2026-{number + 1:02}-01', day(40 + number, leak))
    for number, leak in enumerate((0.0, 2.0, 2.0)):
        put(place / 'logs' / 'breaks' / f'2026-{number + 1:02}-01', day(50 + number, leak))
    (place / 'logs' / 'rig.yaml').write_text(yaml.safe_dump(MAKE))
    (place / 'limits.yaml').write_text('pump_leakage: 0.04 L/min/bar\n')
    assert cli.main(['fleet', str(place / 'logs'), '--results', str(place / 'kept'), '--workers',
                     '1', '--limits', str(place / 'limits.yaml'), '--json', str(place / 'f.json'),
                     '-o', str(place / 'f.html')]) == 0
    return place, json.loads((place / 'f.json').read_text()), (place / 'f.html').read_text()


def test_wear_is_followed_by_the_machines_own_file(made):
    place, found, page = made
    machine, = [entry for entry in found['machines'] if entry['name'] == 'wears']
    assert load_rig(place / 'kept' / 'units' / 'wears.yaml').fingerprint is not None
    statuses = [row['status'] for row in found['rows'] if row['machine'] == 'wears']
    assert statuses == ['commissioned'] * 2 + ['done'] * 4
    entry, = [entry for entry in machine['followed'] if entry['effect'].startswith('pump_')]
    assert entry['kind'] in ('grows', 'accelerates') and len(entry['dates']) == 6
    # Also on days on which nothing was named: there it is none within its standard error.
    assert abs(entry['values'][0]) < 4 * entry['sigmas'][0]
    assert '<svg' in page and 'wears' in page


def test_who_is_broken_from_the_first_day_is_judged_by_its_make(made):
    _, found, page = made
    machine, = [entry for entry in found['machines'] if entry['name'] == 'broken']
    assert 'cannot be commissioned as healthy' in machine['unit']
    assert machine['effects'].get('pump_leakage', 0) == 3
    assert 'cannot be commissioned as healthy' in page


def test_who_breaks_on_the_second_day_is_judged_by_its_first(made):
    place, found, _ = made
    machine, = [entry for entry in found['machines'] if entry['name'] == 'breaks']
    file, why = machine['unit'].split(', of the first day alone: ')
    assert load_rig(file).fingerprint and 'cannot be commissioned as healthy' in why
    statuses = [row['status'] for row in found['rows'] if row['machine'] == 'breaks']
    assert statuses == ['commissioned', 'done', 'done']


def test_a_slip_in_a_limit_is_told_before_the_work(made, capsys):
    place, _, _ = made
    assert cli.main(['fleet', str(place / 'logs'), '--limit', 'pump_leak=1']) == 2
    assert 'did you mean' in capsys.readouterr().err
