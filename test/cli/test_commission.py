# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb commission, and diagnose --since: from files to files."""
import json
import re

from hst_drive.diagnose.commission import commission
from hst_drive.errors import InputError
from hst_drive.rig import load_rig
from hst_drive.units import from_si
import numpy as np
import pytest
import yaml

from .verbs import calls_of
from ..diagnose.machines import day, MAKE

run, refused = calls_of('commission')
diagnose, _ = calls_of('diagnose')
report, refused_page = calls_of('report')
HEADER = 'time[s],pump_outlet_pressure[bar],pump_speed[rpm],motor_inlet_flow[L/min],' \
         'oil_temperature[degC]'
UNITS = {'pump_outlet_pressure': 'bar', 'pump_speed': 'rpm', 'motor_inlet_flow': 'L/min',
         'oil_temperature': 'degC'}


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Return a folder with a rig file and logs: two healthy, one with a small leak."""
    folder = tmp_path_factory.mktemp('machine')
    (folder / 'make.yaml').write_text(yaml.safe_dump(MAKE))
    for name, made in {'old': day(1), 'other': day(2), 'leaky': day(3, 0.1),
                       'broken': day(4, 2.0)}.items():
        table = np.column_stack([made.time, *(from_si(made[key], unit)
                                              for key, unit in UNITS.items())])
        np.savetxt(folder / f'{name}.csv', table, delimiter=',', header=HEADER, comments='')
    return folder


def test_the_unit_file_is_a_rig_file(files, tmp_path, capsys):
    """It loads, says what is known, and is not written over what is there."""
    unit = tmp_path / 'unit.yaml'
    code, out, _ = run(capsys, files / 'old.csv', '--rig', files / 'make.yaml', '-o', unit,
                       '--json', tmp_path / 'unit.json')
    assert code == 0 and 'pump.leakage' in out and 'commissioned for: pump outlet pressure' in out
    content = json.loads((tmp_path / 'unit.json').read_text())
    assert content['schema'] == 'hst_drive/commission/1'
    read = load_rig(unit)
    for entry in content['quantities']:
        assert read.scatter[entry['quantity']] == pytest.approx(entry['sigma'], rel=1e-3)
        assert read.calibration[entry['quantity']] == pytest.approx(entry['factor'])
    assert 'exists already' in refused(capsys, files / 'old.csv', '-o', unit)
    with pytest.raises(InputError, match="commissioned already; give the make's"):
        commission(yaml.safe_load(unit.read_text()), str(unit), [])


def test_broken_machines_and_bad_shares_are_refused(files, tmp_path, capsys):
    unit = tmp_path / 'unit.yaml'
    code, out, err = run(capsys, files / 'broken.csv', '--rig', files / 'make.yaml', '-o', unit)
    assert code == 2 and not out and not unit.exists()
    assert 'broken.csv: cannot be commissioned as healthy' in err and 'pump_leakage' in err
    # What a log lacks is told, whatever comes of it.
    (tmp_path / 'short.csv').write_text(''.join(
        line.rpartition(',')[0] + (
            ',motor_speed[rpm]\n' if '[' in line else ',\n')
        for line in (files / 'broken.csv').read_text().splitlines()))
    assert 'short: motor_speed: no numbers in it; left out' in run(
        capsys, tmp_path / 'short.csv', '--rig', files / 'make.yaml', '-o', unit)[2]
    assert '--day-to-day -1: expected' in refused(
        capsys, files / 'old.csv', '--day-to-day', '-1', '-o', unit)
    # An output that cannot be is told first: before the logs are judged.
    assert 'cannot be written' in refused(capsys, files / 'broken.csv', '--rig',
                                          files / 'make.yaml', '-o', tmp_path / 'no' / 'unit.yaml')


def test_since_is_commission_and_diagnose_in_one_step(files, tmp_path, capsys):
    """The same rig is judged by, so that 'adopt' takes the answer with the unit file as well."""
    unit, found = tmp_path / 'unit.yaml', {}
    run(capsys, files / 'old.csv', '--rig', files / 'make.yaml', '-o', unit)
    for name, more in {'since': ['--rig', files / 'make.yaml', '--since', files / 'old.csv'],
                       'unit': ['--rig', unit]}.items():
        code, out, _ = diagnose(capsys, files / 'leaky.csv', '--json', tmp_path / name, *more)
        assert code == 0 and 'Since it was commissioned the machine has got pump_' in out
        found[name] = json.loads((tmp_path / name).read_text())
    assert found['since']['rig_digest'] == found['unit']['rig_digest'] == load_rig(unit).digest
    assert found['since']['effects'] == found['unit']['effects']
    assert found['since']['since'] == [str(files / 'old.csv')]
    healthy = diagnose(capsys, files / 'other.csv', '--rig', files / 'make.yaml', '--since',
                       files / 'old.csv')[1]
    assert healthy.startswith('Nothing has changed since the machine was commissioned, as far as')
    twice = diagnose(capsys, files / 'old.csv', '--rig', files / 'make.yaml', '--since',
                     files / 'old.csv')
    assert twice[0] == 2 and 'given twice' in twice[2]


def test_a_page_shows_then_and_now(files, tmp_path, capsys):
    """The older log by the machine as it was; the new one without and with what came since."""
    page, made = tmp_path / 'page.html', tmp_path / 'page.json'
    code, _, _ = report(capsys, files / 'leaky.csv', '--rig', files / 'make.yaml', '--since',
                        files / 'old.csv', '-o', page, '--json', made)
    found = json.loads(made.read_text())
    assert code == 0 and found['diagnosis']['effects'][0]['id'].startswith('pump_')
    assert [entry['role'] for entry in found['provenance']['sources']] == [
        'training', 'commissioning']
    shown = page.read_text(encoding='utf-8')
    assert 'What has changed' in shown and 'What is missing' not in shown
    assert '2 logs' in shown and '1 from when it was commissioned' in shown
    # Error of the flow over the floor, table by table.
    then, without, with_it = (
        float(re.search(rf'<caption>{title}.*?class="ratio.*?>([\d.]+)<', shown, re.DOTALL)[1])
        for title in ('when it was commissioned', 'the machine as it was', 'with what was found'))
    assert then < 1.25 and with_it < 1.25 and without > 1.5
    assert 'leave --diagnosis out' in refused_page(
        capsys, files / 'leaky.csv', '--since', files / 'old.csv', '--diagnosis', made)
    assert '--day-to-day nan' in refused_page(
        capsys, files / 'leaky.csv', '--since', files / 'old.csv', '--day-to-day', 'nan')
