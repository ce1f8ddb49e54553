# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb losses: its JSON, its pictures, its rig file, its inputs good and bad."""
import json
import sys

from hst_drive.rig import load_rig
import numpy as np
import pytest

from .verbs import calls_of
from ..losses import generator
from ..losses.tables import bench_from, SHARED

command, refused = calls_of('losses')
MOTORS = SHARED / 'bench' / 'motors.csv'
RPM = np.pi / 30
RECIPE = generator.Recipe(sizes_cc=(16.0, 23.0), temperatures_degc=(45.0, 60.0),
                          speeds_rpm=(600.0, 900.0, 1200.0, 1500.0),
                          pressures_bar=(60.0, 100.0, 140.0, 180.0))


@pytest.fixture(scope='module')
def rows():
    """Return a small table of two motors."""
    return generator.make(RECIPE, np.random.default_rng(2))[0]


@pytest.fixture
def bench(rows, tmp_path):
    """Return it as a file."""
    return generator.write(tmp_path / 'bench.csv', rows)


def test_json_holds_all_parts(bench, rows, tmp_path, capsys):
    target = tmp_path / 'losses.json'
    code, out, _ = command(capsys, bench, '--json', target, '--duty', '20:1000:0.6', '10:700:0.4')
    assert code == 0
    content = json.loads(target.read_text())
    assert content['schema'] == 'hst_drive/losses/1'
    assert out.startswith(content['summary'])
    assert content['missing_term']['verdict'] == 'none'
    assert len(content['rows']) == len(rows)
    assert set(content['fits']) == {'R_el', 'R_2', 'R_1'}
    assert {entry['id'] for entry in content['models']} >= {'wilson', 'schloesser', 'polynomial'}
    errors = [entry['error'] for entry in content['models']]
    assert errors == sorted(errors)
    assert len(content['trends']) == 24 and content['contradiction']['equation'] == '(7)'
    row, found = rows[5], content['rows'][5]
    assert found['line'] == 7
    assert found['actual']['efficiency'] == pytest.approx(
        row[2] * row[3] * RPM / (row[4] * 1e5 * row[5] / 6e4), rel=1e-4)
    assert found['resistances']['R_el'] == pytest.approx(row[4] * 1e5 / (row[6] / 6e4), rel=1e-4)
    assert found['predicted']['efficiency'] == pytest.approx(found['actual']['efficiency'],
                                                             rel=0.02)
    assert len(content['selection']['motors']) == 2


def test_without_case_drain_flow_the_split_is_not_invented(rows, tmp_path, capsys):
    path = generator.write(tmp_path / 'bench.csv', rows, drain=False)
    code, out, _ = command(capsys, path, '--json', tmp_path / 'a.json')
    content = json.loads((tmp_path / 'a.json').read_text())
    assert code == 0 and 'Eq. (2)' in out and 'No split is invented' in out
    assert set(content['not_determined']) == {'R_el', 'R_1', 'R_2'}
    assert content['rows'][0]['resistances']['R_el'] is None
    assert set(content['fits']) == {'R_total', 'R_1'}


def test_a_fitted_motor_drives_the_plant(bench, rows, tmp_path, capsys):
    """The steady drive with this motor needs the pressure and flow that the losses predict."""
    from hst_drive.losses.study import study
    from hst_drive.model import Drive
    from hst_drive.model.steady import operating_point

    rig = tmp_path / 'rig.yaml'
    code, out, _ = command(capsys, bench, '--motor', 23, '--temperature', 45, '-o', rig)
    assert code == 0 and 'rig.yaml' in out
    found = study(bench_from(rows))
    drive = Drive(load_rig(rig))
    size = 23e-6 / (2 * np.pi)
    viscosity = float(np.median(found.bench.viscosity[found.bench.temperature < 325]))
    for speed, torque in ((900 * RPM, 30.0), (1300 * RPM, 45.0)):
        point = operating_point(drive, speed, torque)
        at = found.operate(speed, torque, viscosity, size)
        assert point.readings['load_torque'] == pytest.approx(torque, rel=1e-6)
        assert point.readings['pump_outlet_pressure'] == pytest.approx(at['pressure'][0], rel=3e-3)
        assert point.readings['motor_inlet_flow'] == pytest.approx(at['flow'][0], rel=3e-3)
    assert 'exists already' in refused(capsys, bench, '--motor', 23, '-o', rig)


def test_pictures_are_drawn(bench, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    from matplotlib.image import imread

    assert command(capsys, bench, '--plot', tmp_path / 'plots')[0] == 0
    names = sorted(path.name for path in (tmp_path / 'plots').iterdir())
    assert names == ['figures_6_to_27.png', 'maps_16_cc.png', 'maps_23_cc.png']
    for name in names:
        picture = imread(tmp_path / 'plots' / name)
        assert min(picture.shape[:2]) > 400 and picture[..., :3].std() > 0.05


@pytest.mark.parametrize('name', ['plots', 'plots.pdf'])
def test_without_matplotlib_nothing_is_left_behind(bench, tmp_path, capsys, monkeypatch, name):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    code, _, err = command(capsys, bench, '--plot', tmp_path / name)
    assert code == 2 and 'matplotlib is not installed' in err and 'Traceback' not in err
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize('change, word', [
    (lambda lines: lines[:1], 'no rows'),
    (lambda lines: [], 'empty'),
    (lambda lines: [lines[0].replace('[bar]', '[baar]'), *lines[1:]], 'unknown unit'),
    (lambda lines: [lines[0].replace('motor_speed[rpm]', 'motor_speed[bar]'), *lines[1:]],
     'another quantity'),
    (lambda lines: [lines[0].replace('load_torque', 'torque'), *lines[1:]],
     'load_torque[N.m] is missing'),
    (lambda lines: [*lines[:3], lines[3].replace(',', ',-', 5), *lines[4:]], 'row 4'),
    (lambda lines: [*lines[:3], lines[3].rsplit(',', 2)[0] + ',0,0.1', *lines[4:]], 'row 4'),
    (lambda lines: [*lines[:3], 'x' + lines[3], *lines[4:]], 'expected a number'),
    (lambda lines: [*lines[:3], lines[3] + ',1', *lines[4:]], 'cells'),
    (lambda lines: [lines[0].replace('[N.m]', '[kN.m]'), *lines[1:]], 'hydraulic power'),
])
def test_wrong_tables_are_refused_in_one_line(bench, tmp_path, capsys, change, word):
    path = tmp_path / 'wrong.csv'
    path.write_text('\n'.join(change(bench.read_text().splitlines())))
    assert word in refused(capsys, path)


@pytest.mark.parametrize('arguments, word', [
    (('--oil', 'ISO VG 47'), 'did you mean'), (('--duty', '20'), 'TORQUE:SPEED'),
    (('--motor', '16'), '-o'), (('-o', 'x.yaml'), 'choose one'),
    (('--temperature', '900'), 'degC'), (('--motor', '50', '-o', 'x.yaml'), 'choose one'),
])
def test_wrong_wishes_are_refused_in_one_line(bench, capsys, arguments, word):
    assert word in refused(capsys, bench, *arguments)


def test_rows_that_cannot_count_are_named(bench, capsys):
    lines = bench.read_text().splitlines()
    cells = lines[4].split(',')
    cells[4] = 'nan'
    bench.write_text('\n'.join([*lines[:4], ','.join(cells), *lines[5:], lines[9]]))
    code, _, err = command(capsys, bench)
    assert code == 0 and 'row 5: supply_pressure[bar] is empty' in err
    assert f'row {len(lines) + 1}: repeats' in err


def test_a_single_row_gives_its_resistances(bench, capsys):
    bench.write_text('\n'.join(bench.read_text().splitlines()[:2]))
    code, out, err = command(capsys, bench)
    assert code == 0 and 'determine no curves' in err and 'R_el' in out


@pytest.mark.skipif(not MOTORS.exists(), reason='the shared recordings are not there')
def test_the_bench_of_five_motors(tmp_path, capsys):
    code, out, _ = command(capsys, MOTORS, '--json', tmp_path / 'a.json')
    assert code == 0
    content = json.loads((tmp_path / 'a.json').read_text())
    assert content['missing_term']['verdict'] == 'none'
    assert all(entry['within_2_5_percent'] for entry in content['heldout']
               if not entry['motor_left_out'])
    seen = {(trend['quantity'], trend['variable']): trend['verdict']
            for trend in content['trends']}
    # Eq. (7): both cannot hold; here R_1 falls with size faster than 1/D^2.
    assert seen['R_1', 'size'] == 'fails' and seen['torque_loss', 'size'] == 'holds'
    assert content['contradiction']['size_exponent_of_R_1'] < -2.0
