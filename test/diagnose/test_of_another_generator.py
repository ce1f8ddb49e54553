# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Machines as authors of other simulators wrote them (bench/frozen, unseen): other forms, rigs."""
from dataclasses import replace
from test.diagnose.unseen import unseen

from bench import doses_frozen
from bench.frozen.make import make
from hst_drive.bag import read_log
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import default_rig, load_rig, parse_rig
from hst_drive.rig.rig import Curve, Surface
import numpy as np
import pytest


@pytest.mark.needs_numba
@pytest.mark.parametrize('index, name', [
    (40, 'motor_orifice_leakage'), (35, 'suction_starvation'), (56, 'accumulator')])
def test_it_is_named(tmp_path, index, name):
    truth = make(5000, index, tmp_path, 'single')
    assert truth['effects'] == [name]
    rig = tmp_path / 'rig.yaml'
    *logs, held_out = (read_log(tmp_path / f'{log}.csv') for log in (
        'drilling', 'open_loop', 'speed_sweep', 'drilling_holdout'))
    found = diagnose(load_rig(rig) if rig.exists() else default_rig(), logs, [held_out])
    assert found.verdict in ('missing_effect', 'ambiguous')
    entry, = found.effects
    assert name in (entry.id, *entry.indistinguishable_from)


@pytest.mark.needs_numba
def test_oil_that_stiffens_and_straight_curves_are_the_unit(tmp_path):
    """All machines there have oil whose bulk modulus is 1 + 0.08 times as large at 200 bar."""
    found = diagnose(*unseen(5003, tmp_path))
    assert found.verdict == 'none'
    factors = {entry.quantity: entry for entry in found.calibration}
    assert factors['line.compressibility_under_pressure'].factor == pytest.approx(
        1 / 1.08, abs=0.02)
    for name in ('pump.displacement_between_points', 'loading.pprv_between_points'):
        assert factors[name].factor == pytest.approx(1.0, abs=0.1)


@pytest.mark.needs_numba
def test_a_displacement_curve_that_is_off_in_waves_is_the_unit(tmp_path):
    """0.4 % at both ends and in the middle was a suction_starvation."""
    rig, logs, held_out = unseen(5003, tmp_path)
    sheet = rig.pump.displacement
    share = (sheet.x - sheet.x[0]) / np.ptp(sheet.x)
    off = Curve(sheet.x, sheet.y * (1 + 0.004 * np.cos(2 * np.pi * share)))
    found = diagnose(replace(rig, pump=replace(rig.pump, displacement=off)), logs, held_out)
    assert found.verdict == 'none'


@pytest.mark.needs_numba
@pytest.mark.parametrize('off', [0.01, -0.01])
def test_an_efficiency_that_is_off_along_the_pressure_is_the_unit(off, tmp_path):
    """1 % more at one end of the pressures than in the middle was unknown (0.63)."""
    rig, logs, held_out = unseen(5003, tmp_path)
    sheet = rig.motor.mechanical_efficiency
    tilted = sheet.z * (1 + off * (2 * sheet.x / sheet.x[-1] - 1))[:, None]
    found = diagnose(replace(rig, motor=replace(rig.motor, mechanical_efficiency=Surface(
        sheet.x, sheet.y, tilted))), logs, held_out)
    assert found.verdict == 'none'
    tilt, = (entry for entry in found.calibration if entry.quantity == 'motor.efficiency_tilt')
    assert tilt.factor == pytest.approx(1 - off, abs=0.004)


@pytest.mark.needs_numba
def test_the_likeliest_of_what_stands_is_named_first(tmp_path):
    """A line's loss of three shapes fits a drag as well as the drag of one."""
    found = diagnose(*unseen(5008, tmp_path))
    effect, = found.effects
    assert effect.id == 'hydrodynamic_drag' and 'line_loss' in effect.indistinguishable_from


@pytest.mark.needs_numba
@pytest.mark.parametrize('machine, number, name, dose', [
    (0, 20, 'motor_leakage', 0.2), (1, 21, 'pump_leakage', 0.2)])
def test_a_leak_that_no_power_of_the_pressure_fits_is_still_a_leak(machine, number, name, dose):
    """The best power is at the end of its range: the laminar gap stands for it."""
    sheet, first = doses_frozen.day(machine, 0)
    unit = commission(sheet, 'rig', [*first, *doses_frozen.day(machine, 1)[1]]).rig
    found = diagnose(parse_rig(unit, 'unit'), doses_frozen.day(machine, number, name, dose)[1])
    effect, = found.effects
    assert effect.id == name
    assert effect.parameters['exponent'].value == 1.0


@pytest.mark.needs_numba
def test_rock_whose_roughness_goes_with_its_load_is_no_change():
    sheet, first = doses_frozen.day(4, 0)
    unit = commission(sheet, 'rig', [*first, *doses_frozen.day(4, 1)[1]]).rig
    found = diagnose(parse_rig(unit, 'unit'), doses_frozen.day(4, 12, rougher=True)[1])
    assert found.verdict == 'none'


@pytest.mark.needs_numba
def test_a_second_lag_that_no_error_shows_is_none(tmp_path):
    """Its servo has a pole of its own: by its stroke far likelier, and no error falls."""
    assert make(84_000, 13, tmp_path, 'none')['effects'] == []
    *logs, held_out = (read_log(tmp_path / f'{log}.csv') for log in (
        'drilling', 'open_loop', 'speed_sweep', 'drilling_holdout'))
    assert diagnose(load_rig(tmp_path / 'rig.yaml'), logs, [held_out]).verdict == 'none'


@pytest.mark.needs_numba
def test_a_load_that_hangs_behind_the_torque_sensor_is_a_constant_torque(tmp_path):
    """The sensor reads it, so it is neither at the hydromotor's shaft nor in the reading."""
    found = diagnose(*unseen(8633, tmp_path))
    effect, = found.effects
    torque = effect.parameters['torque']
    assert effect.id == 'constant_torque' and torque.low < 6.2 < torque.high
    assert effect.parameters['in_load'].value == 1.0
