# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A pump on a bench with torque or power at its shaft: judged by formulas written here."""
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig
import numpy as np
import pytest

SIZE = 28e-6 / (2 * np.pi)      # m^3/rad
RIG = parse_rig({'pump': {'max_displacement_cc_rev': 28, 'mechanical_efficiency': 0.94}})


def bench(channel, *, coulomb=0.0, load_share=0.0, seed=1):
    """Return a bench of a fixed pump with a sheet of 94 %, and what it loses beyond."""
    random, time = np.random.default_rng(seed), np.arange(4000) * 0.01
    pressure = 1e5 * (110.0 + 60.0 * np.sin(0.7 * time) + 30.0 * np.sin(2.3 * time))
    speed = 150.0 + 20.0 * np.sin(0.31 * time)
    ideal = SIZE * pressure
    torque = ideal / 0.94 + coulomb + load_share * ideal
    if channel == 'pump_power':
        torque = torque * speed
    size = 0.002 * torque.mean()
    return Run('bench', time, {
        'pump_outlet_pressure': pressure + 1e4 * random.standard_normal(len(time)),
        'pump_speed': speed + 0.05 * random.standard_normal(len(time)),
        channel: torque + size * random.standard_normal(len(time))}, 'bench.csv')


@pytest.mark.parametrize('channel', ['pump_torque', 'pump_power'])
def test_friction_of_the_pump_is_named_and_sized(channel):
    assert diagnose(RIG, [bench(channel)]).verdict == 'none'
    result = diagnose(RIG, [bench(channel, coulomb=2.0, load_share=0.08)])
    found, = result.effects
    assert (result.verdict, found.id) == ('missing_effect', 'pump_friction')
    assert found.parameters['coulomb'].value == pytest.approx(2.0, rel=0.05)
    assert found.parameters['load_share'].value == pytest.approx(0.08, rel=0.05)


@pytest.mark.parametrize('channel', ['pump_torque', 'pump_power', 'motor_inlet_flow'])
def test_a_rig_file_without_the_pump_is_told_in_one_line(channel):
    run, rig = bench('pump_power'), parse_rig({'motor': {'displacement_cc_rev': 28}})
    rows = Run('bench', run.time, {
        'pump_outlet_pressure': run['pump_outlet_pressure'], 'pump_speed': run['pump_speed'],
        'pump_displacement': np.full(len(run), SIZE), channel: run['pump_power']}, 'bench.csv')
    with pytest.raises(InputError, match='close no balance') as it:
        diagnose(rig, [rows])
    assert '\n' not in str(it.value)
