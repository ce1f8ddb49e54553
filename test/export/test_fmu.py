# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The exported drive against the model here, through FMI's own functions and through fmpy."""
import ctypes
import json
import shutil

from hst_drive.cli import main
from hst_drive.effects import catalogue
from hst_drive.export.fmu import unit_of
from hst_drive.model import Drive
from hst_drive.model.compose import OUTPUTS
from hst_drive.rig import default_rig, default_rig_file, load_rig
from hst_drive.rig.yaml_file import read_yaml
import numpy as np
import pytest
import yaml

from .slave import Slave

pytestmark = pytest.mark.skipif(shutil.which('cc') is None, reason='needs a C compiler')
INTERVAL = 0.02


def inputs(steps):
    """Return commands that start, load, coast and load the drive again."""
    time = INTERVAL * np.arange(steps)
    return {'pump_command': np.where(time < 0.2, 0.0, 5.0 + 1.5 * np.sin(2.0 * time)),
            'pprv_command': 2.0 + 2.0 * (time > 1.0) - 3.0 * (time > 2.0) + 3.0 * (time > 2.6),
            'oil_temperature': 323.15 + 15.0 * np.sin(time),
            'load_disturbance': 3.0 * np.sign(np.sin(5.0 * time))}


def here(drive, given, interval):
    """Return what the model gives at the end of each step."""
    state, found = drive.initial_state(), []
    for values in zip(*given.values()):
        held = dict(zip(given, values))
        state = drive.advance(state, interval, **held)
        shown = drive.outputs(state, **held)
        found.append([shown[name] for name in OUTPUTS])
    return np.array(found)


def off(found, wanted):
    """Return the greatest difference over the range of each output."""
    return float(np.max(np.abs(found - wanted) / np.maximum(np.ptp(wanted, axis=0), 1e-30)))


@pytest.mark.parametrize('name', ['', *catalogue()])
def test_every_effect_is_the_same_in_c(tmp_path, name):
    drive = Drive(default_rig(), {name: {}} if name else None)
    given = inputs(60 if name else 160)
    found = Slave(unit_of(drive), tmp_path).play(given, INTERVAL, OUTPUTS)
    assert off(found, here(drive, given, INTERVAL)) < 1e-9


def test_parameters_reset_saved_states_and_two_at_once(tmp_path):
    drive = Drive(default_rig(), {'motor_leakage': {'conductance': 1e-12}})
    unit, given = unit_of(drive), inputs(80)
    one = Slave(unit, tmp_path)
    first = one.play(given, INTERVAL, OUTPUTS)
    other = Slave(unit, tmp_path, one.library)
    other.put(**{'effect__motor_leakage__conductance': 4e-12, 'factor__motor__inertia': 1.3})
    changed = Drive(default_rig(), {'motor_leakage': {'conductance': 4e-12}})
    changed.scale({'motor.inertia': 1.3})
    assert off(other.play(given, INTERVAL, OUTPUTS), here(changed, given, INTERVAL)) < 1e-9
    # The first one has not noticed.
    one.call('GetFMUstate', ctypes.byref(one.saved))
    one.step(0.5)
    after = one.get(OUTPUTS)
    one.step(0.5)
    one.call('SetFMUstate', one.saved)
    one.step(0.5)
    np.testing.assert_array_equal(one.get(OUTPUTS), after)
    one.call('Reset')
    np.testing.assert_array_equal(one.play(given, INTERVAL, OUTPUTS), first)
    wrong = (ctypes.c_uint * 1)(77)
    assert one.refuses('GetReal', wrong, ctypes.c_size_t(1), (ctypes.c_double * 1)())
    for value in (np.nan, np.inf):
        assert one.refuses('SetReal', (ctypes.c_uint * 1)(0), ctypes.c_size_t(1),
                           (ctypes.c_double * 1)(value))
    assert one.refuses('DoStep', ctypes.c_double(0.0), ctypes.c_double(-1.0), 0)


def test_another_simulator_reads_and_runs_it(tmp_path, capsys):
    """With two adopted effects, by the verb, checked and played by fmpy."""
    fmpy = pytest.importorskip('fmpy')
    validation = pytest.importorskip('fmpy.validation')
    content = read_yaml(default_rig_file())
    content['effects'] = {'bearing_friction': {'coulomb': 12.0},
                          'line_inertance': {'inertance': 2e8}}
    rig, target = tmp_path / 'rig.yaml', tmp_path / 'drive.fmu'
    rig.write_text(yaml.safe_dump(content))
    assert main(['export', str(rig), '-o', str(target), '--json', str(tmp_path / 'e.json')]) == 0
    assert 'with bearing_friction, line_inertance' in capsys.readouterr().out
    assert json.loads((tmp_path / 'e.json').read_text())['fmi'] == '2.0'
    assert validation.validate_fmu(str(target)) == []
    told = {variable.name: variable for variable
            in fmpy.read_model_description(str(target)).modelVariables}
    for variable in told.values():
        if variable.causality == 'parameter':
            assert float(variable.min) <= float(variable.start) <= float(variable.max)
    assert float(told['oil_temperature'].max) == 473.15
    given = inputs(150)
    time = INTERVAL * np.arange(151)
    signals = np.array(
        [(at, *(values[min(k, 149)] for values in given.values())) for k, at in enumerate(time)],
        dtype=[('time', float), *((name, float) for name in given)])
    played = fmpy.simulate_fmu(str(target), stop_time=time[-1], step_size=INTERVAL, input=signals,
                               output_interval=INTERVAL, output=list(OUTPUTS))
    found = np.array([[row[name] for name in OUTPUTS] for row in played[1:]])
    assert off(found, here(Drive(load_rig(rig)), given, INTERVAL)) < 1e-6


def test_what_is_in_the_way_is_one_line(tmp_path, capsys, monkeypatch):
    target = tmp_path / 'drive.fmu'
    monkeypatch.setenv('CC', 'no-such-compiler')
    assert main(['export', '-o', str(target)]) == 2
    line, = capsys.readouterr().err.strip().splitlines()
    assert 'no C compiler found (no-such-compiler)' in line and 'apt install gcc' in line
    monkeypatch.setenv('CC', 'false')
    assert main(['export', '-o', str(target)]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
    target.write_text('mine')
    monkeypatch.delenv('CC')
    assert main(['export', '-o', str(target)]) == 2 and target.read_text() == 'mine'
