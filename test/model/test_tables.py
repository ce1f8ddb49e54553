# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables, cut into cells, against SciPy's interpolation of the rig's numbers."""
from hst_drive.model import Drive
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.kernel_template import interpolate, interpolate2
from hst_drive.model.parameters import baseline_tables, bulge, TABLES
from hst_drive.model.part import PartModel
from hst_drive.resources import share
from hst_drive.rig import Curve, default_rig, load_rig
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

RIG = default_rig()
CLOSED = load_rig(share('config', 'rig', 'closed_rig.yaml'))
SOURCES = (RIG.pump.displacement, RIG.pump.leakage, RIG.motor.leakage,
           RIG.motor.mechanical_efficiency, RIG.loading.pump_mechanical_efficiency,
           RIG.loading.pprv_pressure)


def points(axis, random):
    """Return places inside, outside and exactly on the points of an axis, in no order."""
    reach = np.ptp(axis)
    found = np.concatenate([random.uniform(axis[0] - reach, axis[-1] + reach, 200), axis, axis])
    random.shuffle(found)
    return found


@pytest.mark.parametrize('name', TABLES[:len(SOURCES)])
def test_a_table_everywhere_in_any_order(name):
    number, random = TABLES.index(name), np.random.default_rng(4)
    table, (cells, layout) = SOURCES[number], baseline_tables(RIG)
    x = points(table.x, random)
    if isinstance(table, Curve):
        want = np.interp(x, table.x, table.y)
        found = [interpolate(value, number, cells, layout) for value in x]
        size = np.max(np.abs(table.y))
    else:
        y = random.choice(points(table.y, random), len(x))
        inside = np.clip(x, *table.x[[0, -1]]), np.clip(y, *table.y[[0, -1]])
        want = RegularGridInterpolator((table.x, table.y), table.z)(np.column_stack(inside))
        found = [interpolate2(*at, number, cells, layout) for at in zip(x, y)]
        size = np.max(np.abs(table.z))
    np.testing.assert_allclose(found, want, rtol=0, atol=1e-13 * size)


def test_a_smooth_curve_through_even_points_is_scipys():
    curve = Curve(np.arange(7.0), np.array([0.0, 0.0, 1.0, 3.0, 3.5, 3.2, 5.0]))
    above = bulge(curve)
    inner = (above.x >= 1.0) & (above.x <= 5.0)     # SciPy has other slopes at the ends
    want = PchipInterpolator(curve.x, curve.y)(above.x) - curve(above.x)
    np.testing.assert_allclose(above.y[inner], want[inner], atol=1e-12)


def test_a_unit_may_have_smooth_curves():
    """Factor 1 is straight, 2 smooth: at the points both are the datasheet's."""
    held = {'pump_command': np.full(400, 2.4), 'pprv_command': np.full(400, 3.0)}
    found = []
    for factor in (1.0, 1.5):
        drive = Drive(RIG)
        drive.scale({'pump.displacement_between_points': factor})
        found.append(drive.simulate(np.arange(400) * 0.01, held)['pump_displacement'][-1])
    table = RIG.pump.displacement
    assert found[0] == pytest.approx(table(2.4))
    assert found[1] - found[0] == pytest.approx(0.5 * bulge(table)(2.4))
    smooth = PchipInterpolator(table.x, table.y)(2.4) - table(2.4)
    assert found[1] - found[0] == pytest.approx(0.5 * smooth, rel=0.1) and smooth < 0.0


@pytest.mark.parametrize('halves', [1, 2, 3])
@pytest.mark.parametrize('command', [2.4, 6.1])
def test_a_units_curve_may_part_from_its_sheets_in_waves(command, halves):
    """By a cosine of so many half waves along the commands, in each model of a pump."""
    scales = {f'pump.displacement_wave_{halves}': 1.02}
    time, held = np.arange(800) * 0.01, np.full(800, command)
    whole = Drive(RIG)
    whole.scale(scales)
    part = PartModel(RIG, {}, scales)
    found = {
        'whole': (RIG, whole.simulate(time, {
            'pump_command': held, 'pprv_command': np.full(800, 3.0)})['pump_displacement'][-1]),
        'part': (RIG, part.stroke(None, held, part.complete({}))[0]),
        'closed': (CLOSED, CircuitModel(CLOSED, {}, scales).run(time, {
            'pump_command': held, 'motor_torque': np.zeros(800)}, {})['pump_displacement'][-1])}
    for name, (rig, stroke) in found.items():
        curve = rig.pump.displacement
        share = (command - curve.x[0]) / (curve.x[-1] - curve.x[0])
        assert stroke == pytest.approx(
            curve(command) * (1.0 + 0.02 * np.cos(halves * np.pi * share)), rel=1e-5), name


def torques(rig, pressure, speed, factors):
    """Return the torque of a unit's hydromotor as each model has it, N.m."""
    part = PartModel(rig, {}, factors)
    found = [part.motor_torque(part.complete({'pressure': pressure, 'motor_speed': speed}))]
    if rig is CLOSED:
        found += [CircuitModel(rig, {}, factors).run(
            np.arange(2) * 0.01, {'motor_torque': np.zeros(2)}, {
                name: np.full(2, value) for name, value in (
                    ('motor_speed', speed), ('line_a_pressure', pressure + 2e6),
                    ('line_b_pressure', 2e6), ('pump_displacement', 1e-5))})['motor_torque'][0]]
    else:
        drive = Drive(rig)
        drive.scale(factors)
        state = drive.initial_state(pressure=pressure, speed=speed)
        found += [drive.outputs(state, pump_command=0.0, pprv_command=0.0)[
            'motor_torque_hydraulic']]
    return np.array(found)


@pytest.mark.parametrize('key, shape', [
    ('tilt', lambda share: 2 * share - 1), ('bend', lambda share: 8 * share**2 - 8 * share + 1)])
@pytest.mark.parametrize('share', [0.1, 0.6])
def test_a_units_efficiency_may_part_from_its_sheets_along_the_pressure(share, key, shape):
    """By the first and second Chebyshev polynomial up to the rated pressure."""
    scales, speed = {f'motor.efficiency_{key}': 1.02}, 8.0
    for rig in (RIG, CLOSED):
        motor, pressure = rig.motor, share * rig.rated_pressure
        efficiency = 1.0 - motor.torque_loss[2] if motor.torque_loss else \
            motor.mechanical_efficiency(pressure, speed)
        moved = torques(rig, pressure, speed, scales) - torques(rig, pressure, speed, {})
        assert moved == pytest.approx(
            0.02 * shape(share) * efficiency * motor.displacement * pressure, rel=1e-3)


@pytest.mark.parametrize('share', [0.1, 0.6])
def test_a_unit_may_lose_more_of_its_torque_than_its_sheet_says(share):
    """All that is lost by a tenth more, whether the sheet has a table or coefficients."""
    for rig in (RIG, CLOSED):
        pressure = share * rig.rated_pressure
        usual, lossy = (torques(rig, pressure, 8.0, {'motor.torque_loss': factor})
                        for factor in (1.0, 1.1))
        lost = rig.motor.displacement * pressure - usual
        assert usual - lossy == pytest.approx(0.1 * lost, rel=1e-3)
