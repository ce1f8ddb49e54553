# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The integrator: against SciPy's Radau on equations of their own, against itself, in pieces."""
from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.model import Drive, OUTPUTS, STATES
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .reference import Reference

COLUMNS = ('pump_displacement', 'pump_outlet_pressure', 'motor_speed', 'pprv_pressure')


def commands(time):
    """Return commands that start, cavitate and stall the drive and open the relief valve."""
    time = time + 1e-6     # no row falls before or after a corner by rounding
    pump = np.select([time < t for t in (0.2, 1.2, 2.2, 3.2, 5.0)], [0, 5.6, 4.0, 7.5, 5.8], 2.5)
    pprv = np.select([time < t for t in (1.7, 2.7, 3.7, 4.4)], [1.0, 3.6, 5.0, 3.9], 9.9)
    return pump, pprv


@pytest.mark.parametrize('interval', [0.01, 0.001])
def test_against_radau_on_independent_equations(interval):
    """Rows of 1 ms are integrated by Adams and Bashforth where commands stand still."""
    time = np.arange(round(6 / interval) + 1) * interval
    pump, pprv = commands(time)
    drive = Drive(default_rig())
    start = drive.initial_state(pump_command=pump[0], pprv_command=pprv[0])
    want = Reference().run(time, pump, pprv, start[:4], tolerance=1e-8)
    found = drive.simulate(time, {'pump_command': pump, 'pprv_command': pprv}, start)
    # The run goes everywhere: cavitation, standstill, relief valve.
    assert want[:, 1].min() == pytest.approx(-0.9e5)
    assert want[:, 1].max() > 200e5
    assert want[-1, 2] < 0.3 and want[0, 2] == 0
    for index, name in enumerate(COLUMNS):
        spread = np.ptp(want[:, index])
        assert np.max(np.abs(found[name] - want[:, index])) < 1e-4 * spread, name


@pytest.mark.parametrize('name', sorted(catalogue()))
def test_fine_rows_agree_with_coarse_ones(name):
    """Two integrators: Adams and Bashforth at 1 ms, Runge and Kutta at 10 ms."""
    drive = Drive(default_rig(), {name: {}})
    runs = []
    for interval in (0.01, 0.001):
        time = np.arange(round(6 / interval) + 1) * interval
        pump, pprv = commands(time)
        found = drive.simulate(time, {
            'pump_command': pump, 'pprv_command': pprv,
            'oil_temperature': np.full(len(time), 330.0)})
        runs.append({key: values[::round(0.01 / interval)] for key, values in found.items()})
    for key in COLUMNS:
        spread = np.ptp(runs[0][key])
        assert np.max(np.abs(runs[1][key] - runs[0][key])) < 2e-4 * spread, key


@pytest.mark.parametrize('command', [6.0, 7.0])
@pytest.mark.parametrize('effects', [
    {}, {'hydrodynamic_drag': {'coefficient': 10.0}}, {'piston_ripple': {'cosine': 0.3}},
    {'line_inertance': {}}])
def test_fine_rows_at_the_corners(command, effects):
    """A start where the line runs empty, as much damping as there may be, a long line."""
    time = np.arange(2001) * 0.001
    inputs = {'pump_command': np.where(time < 1.2 - 1e-6, command, 4.5),
              'pprv_command': np.where(time < 1.6 - 1e-6, 1.0, 2.0)}
    found, fine = (Drive(default_rig(), effects, max_step=step).simulate(time, inputs)
                   for step in (2.5e-3, 5e-5))
    assert effects or fine['pump_outlet_pressure'].min() < -0.89e5
    for key in COLUMNS:
        spread = np.ptp(fine[key])
        assert np.max(np.abs(found[key] - fine[key])) < 1e-3 * spread, key


def test_readings_follow_from_the_states():
    """Flow meter, torque sensor and inner quantities, from the state by the datasheet's words."""
    reference = Reference()
    time = np.arange(300) * 0.01
    pump, pprv = commands(time)
    found = Drive(default_rig()).simulate(time, {'pump_command': pump, 'pprv_command': pprv})
    for k in range(5, 300, 17):
        p, w = found['pump_outlet_pressure'][k], found['motor_speed'][k]
        leak = reference.q_leak_motor(p, w)
        want = {
            'motor_inlet_pressure': p, 'case_drain_flow': leak,
            'motor_inlet_flow': reference.d_motor * w + leak,
            'load_torque': reference.torque_load(found['pprv_pressure'][k], w),
            'motor_torque_hydraulic': reference.torque_motor(p, w),
            'relief_flow': reference.q_relief(p), 'pump_speed': reference.w_pump,
            'pump_flow': found['pump_displacement'][k] * reference.w_pump
            - reference.q_leak_pump(p, pump[k])}
        for name, value in want.items():
            assert found[name][k] == pytest.approx(value, rel=1e-9, abs=1e-9), name


@pytest.mark.needs_numba
@pytest.mark.parametrize('effects', [{}, {'motor_leakage': {'conductance': 2e-12}}])
def test_plain_python_gives_the_numbers_of_the_compiled_code(effects):
    time = np.arange(460) * 0.01
    pump, pprv = commands(time)
    random = np.random.default_rng(3)
    inputs = {'pump_command': pump, 'pprv_command': pprv,
              'oil_temperature': 323.15 + 10 * np.sin(time),
              'load_disturbance': random.standard_normal(len(time))}
    fast, slow = (Drive(default_rig(), effects, compiled=compiled).simulate(time, inputs)
                  for compiled in (True, False))
    for name in OUTPUTS:
        scale = np.max(np.abs(slow[name]))
        np.testing.assert_allclose(fast[name], slow[name], rtol=1e-12, atol=1e-12 * scale)


def test_pieces_of_one_sample_equal_the_whole():
    time = np.arange(200) * 0.01
    pump, pprv = commands(time)
    drive = Drive(default_rig())
    whole = drive.simulate(time, {'pump_command': pump, 'pprv_command': pprv})
    state = drive.initial_state(pump_command=pump[0], pprv_command=pprv[0])
    for k in range(len(time) - 1):
        inputs = {'pump_command': pump[k], 'pprv_command': pprv[k]}
        if not k % 20:
            shown = drive.outputs(state, **inputs)
            assert set(shown) == set(whole)
            for name, value in shown.items():
                assert value == pytest.approx(whole[name][k], rel=1e-11, abs=1e-12), name
        before = state.copy()
        state = drive.advance(state, 0.01, **inputs)
        assert np.any(state != before)
    assert state[2] == pytest.approx(whole['motor_speed'][-1], rel=1e-11)


def test_small_pieces_agree_with_the_whole():
    """A millisecond at a time, as the plant node steps."""
    drive = Drive(default_rig())
    inputs = {'pump_command': 5.6, 'pprv_command': 3.0, 'oil_temperature': 330.0,
              'load_disturbance': 2.0}
    start = drive.initial_state(pump_command=5.6, pprv_command=1.0)
    whole = drive.advance(start, 0.5, **inputs)
    state = start
    for _ in range(500):
        state = drive.advance(state, 0.001, **inputs)
    np.testing.assert_allclose(state, whole, rtol=2e-5)
    # What is not known at the start settles at once.
    known = np.isfinite(start)
    assert [STATES[k] for k in np.flatnonzero(~known)] == [
        'slowdown', 'pilot_aim', 'line_flow', 'far_pressure']
    assert drive.advance(start, 0.0, **inputs)[known] == pytest.approx(start[known])


def test_the_disturbance_moves_on_a_straight_line_between_samples():
    drive = Drive(default_rig())
    coarse, fine = np.arange(0, 2.0001, 0.1), np.arange(0, 2.00001, 0.01)
    values = 10 * np.sin(2 * coarse)
    ends = []
    for time in (coarse, fine):
        inputs = {'pump_command': np.full(len(time), 5.6), 'pprv_command': np.full(len(time), 3.0),
                  'load_disturbance': np.interp(time, coarse, values)}
        ends.append(drive.simulate(time, inputs)['motor_speed'][::len(time) // 20])
    np.testing.assert_allclose(ends[0], ends[1], rtol=5e-5, atol=1e-6)


def test_a_motion_without_bounds_ends_in_nan_not_in_an_error():
    drive = Drive(default_rig(), max_step=10.0)
    drive.scale({'line.bulk_modulus': 1e6})
    time = np.arange(20) * 10.0
    held = {'pump_command': np.full(20, 8.0), 'pprv_command': np.full(20, 5.0)}
    out = drive.simulate(time, held)
    assert np.isnan(out['motor_speed'][-1])
    assert np.isfinite(out['motor_speed'][0])


def test_standstill_is_left_in_peace():
    """Without a command the drive does not creep, whatever load torque is measured."""
    drive = Drive(default_rig())
    time = np.arange(200) * 0.01
    out = drive.simulate(time, {'pump_command': np.zeros(200), 'pprv_command': np.full(200, 4.0),
                                'load_disturbance': np.full(200, -30.0)},
                         drive.initial_state(pressure=0.0))
    assert np.max(np.abs(out['motor_speed'])) < 1e-9


@pytest.mark.parametrize('effects, expected', [
    ({'motor_leakege': {}}, "unknown effect 'motor_leakege'; did you mean 'motor_leakage'?"),
    ({'motor_leakage': {'conductanse': 1.0}}, "'motor_leakage' has no parameter 'conductanse'"),
])
def test_effects_that_are_not_there(effects, expected):
    with pytest.raises(InputError, match=expected.replace('?', r'\?')):
        Drive(default_rig(), effects)


def test_states_have_names():
    assert len(Drive(default_rig()).initial_state()) == len(STATES)
