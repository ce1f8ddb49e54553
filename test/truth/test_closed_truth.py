# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The generator of closed-circuit and valve-driven heads: physical, reproducible, independent."""

from functools import lru_cache
import json

import numpy as np
import pytest

pytest.importorskip('numba')

from scipy.integrate import cumulative_trapezoid, solve_ivp  # noqa: E402
import yaml  # noqa: E402

from .closed import catalogue, circuit, make, rigs  # noqa: E402
from .closed.common import ANGLE, PA, PB, STROKE, W  # noqa: E402
from .closed.make import make_campaign  # noqa: E402
from .closed.pieces import modulus  # noqa: E402
from .terms import record  # noqa: E402

BAR, L_MIN = 1e5, 1e-3 / 60
KNOWN = {c: {**catalogue.LISTED[c], **catalogue.OUTSIDE[c]} for c in ('closed', 'valve')}


def sheet_of(name, seed=2):
    """Return a drawn datasheet with a gear."""
    return rigs.draw(name, np.random.default_rng(seed), gear=True)


def steady(name, sheet, volts, rock=0.0, push=0.0, effects=None, forms=None, seconds=6.0,
           degrees=50.0, fluid=1.0, detail=0.0):
    """Return the states after some seconds at a held command, unit on its datasheet."""
    chosen = catalogue.resolve(name, effects or {}, np.random.default_rng(0),
                               rigs.scales(sheet), forms)
    flat = make.machine(sheet, {}, chosen, np.random.default_rng(0), detail, [])
    n = int(seconds * 1000)
    one = np.ones(n)
    kernel = make.KERNEL[name]
    ramp = np.minimum(np.arange(n) / 1000, 1.0)
    out = kernel.run(record(flat), 0 * one, volts * one, False, rock * ramp, push * ramp,
                     fluid * one, degrees * one, one, 0 * one, 0 * one, flat['d_motor'] * one, 1)
    return dict(zip(kernel.OUT, out[-1])), flat


def test_a_seed_gives_the_same_campaign_and_another_seed_another():
    a, b, c = (make_campaign('closed', s, kind='pair', duration=4.0) for s in (4, 4, 5))
    assert a.truth == b.truth and a.sheet == b.sheet and a.truth != c.truth
    for log in a.logs:
        for name, values in a.logs[log].items():
            np.testing.assert_array_equal(values, b.logs[log][name])


def test_rigs_of_three_sizes():
    pumps = [sheet_of('closed', s)['pump']['max_displacement_cc_rev'] for s in range(20)]
    assert min(pumps) < 35 and max(pumps) > 110
    assert any(60 < p < 80 for p in pumps)


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_the_oil_balance_closes(name):
    """What goes in and out is what the oil's compression stores, to 0.1 % of what passes."""
    c = make_campaign(name, 3, {}, duration=10.0, logs=('sweep',))
    x = c.exact['sweep']
    rng = np.random.default_rng([3, 4])
    factor = rigs.scatter(c.sheet, rng)
    p = record(make.machine(c.sheet, factor, {}, rng, 1.0, c.truth['channels']))[0]

    def stored(pressure, volume):
        stiff = np.array([modulus(p, v) for v in pressure])
        return cumulative_trapezoid(volume / stiff, pressure, initial=0.0)

    kept = stored(x['pa'], p['volume']) + stored(x['pb'], p['volume'])
    if name == 'closed':
        kept += stored(x['pc'], p['v_charge'])
        net, through = x['q_charge'] - x['q_out'], x['q_pump']
    else:
        net, through = x['q_a'] + x['q_b'] - x['q_motor'] + x['q_give'], x['q_a']
    moved = cumulative_trapezoid(net, dx=1e-3, initial=0.0)
    assert np.max(np.abs(kept - moved)) < 1e-3 * np.sum(np.abs(through)) * 1e-3


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_the_shafts_energy_balance_closes(name):
    c = make_campaign(name, 3, {'viscous_drag': 1.0}, duration=10.0, logs=('sweep',),
                      on_datasheet=True)
    x = c.exact['sweep']
    work = cumulative_trapezoid((x['t_drive'] - x['t_lost'] - x['torque']) * x['w'], dx=1e-3,
                                initial=0.0)
    kinetic = 0.5 * c.sheet['motor']['inertia_total_kg_m2'] * x['w'] ** 2
    assert np.max(np.abs(kinetic - work)) < 2e-3 * np.sum(np.abs(x['t_drive'] * x['w'])) * 1e-3


def hand_speed(sheet, volts, dp, low):
    """Return the steady speed by hand: what the pump sends less what leaks, over the motors."""
    pump, motor = sheet['pump'], sheet['motor']
    share = (abs(volts) - 1) / 9
    leak, one = pump['leakage_L_min'], motor['leakage_L_min']['laminar_L_min_per_bar']
    high = (dp + low) / BAR
    lost = leak['laminar_L_min_per_bar'] * high + one * motor['count'] * high \
        + leak['turbulent_L_min_per_sqrt_bar'] * high ** 0.5
    flow = share * pump['max_displacement_cc_rev'] * pump['shaft_speed_rpm'] / 1000
    turns = (flow - lost) * 1000 / (motor['displacement_cc_rev'] * motor['count']
                                    * sheet['gear']['ratio'])
    return turns * np.pi / 30


def test_steady_state_of_the_closed_circuit_by_hand():
    sheet = sheet_of('closed')
    scale = rigs.scales(sheet)
    for volts, share in ((6.0, 0.4), (9.0, 0.8)):
        x, flat = steady('closed', sheet, volts, rock=share * scale['T'])
        dp = x['pa'] - x['pb']
        assert x['w'] == pytest.approx(hand_speed(sheet, volts, dp, x['pb']), rel=3e-4)
        motor = sheet['motor']
        loss = motor['mechanical_efficiency']
        ideal = motor['displacement_cc_rev'] * 1e-6 / (2 * np.pi) * dp
        one = ideal * (1 - loss['pressure_share']) - loss['coulomb_N_m'] \
            - loss['viscous_N_m_s_per_rad'] * x['w'] * sheet['gear']['ratio']
        out = one * motor['count'] * sheet['gear']['ratio'] * sheet['gear']['efficiency']
        assert out == pytest.approx(x['torque'], rel=1e-4)
        charge = sheet['charge']
        made = charge['pump_displacement_cc_rev'] * sheet['pump']['shaft_speed_rpm'] / 1000
        used = (x['q_out'] - 0.0) / L_MIN
        spilt = (x['pc'] / BAR - charge['relief_pressure_bar']) \
            / charge['relief_override_bar_per_L_min']
        assert made == pytest.approx(used + spilt, rel=0.03)
        assert (x['pc'] - x['pb']) / BAR == pytest.approx(
            used * charge['check_valve_bar_per_L_min'], abs=0.05)


def test_steady_state_of_the_valve_by_hand():
    sheet = sheet_of('valve')
    x, flat = steady('valve', sheet, 6.0, rock=0.5 * rigs.scales(sheet)['T'])
    curve = sheet['valve']['opening_vs_command']['command_V']
    opening = (6.0 - curve[2]) / (10 - curve[2])
    gain = sheet['valve']['rated_flow_L_min'] / sheet['valve']['rated_pressure_drop_bar'] ** 0.5
    a, b = (opening * gain * (d / BAR) ** 0.5
            for d in (sheet['supply']['pressure_bar'] * BAR - x['pa'], x['pb']))
    motor = sheet['motor']
    leak = motor['count'] * motor['leakage_L_min']['laminar_L_min_per_bar'] / BAR
    swept = x['w'] * 30 / np.pi * motor['displacement_cc_rev'] * motor['count'] \
        * sheet['gear']['ratio'] / 1000
    assert a == pytest.approx(swept + leak * x['pa'], rel=3e-3)
    assert b == pytest.approx(swept - leak * x['pb'], rel=3e-3)


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_losses_take_power_in_every_quadrant(name):
    sheet = sheet_of(name)
    full = rigs.scales(sheet)['T']
    for volts in (-6.0, 6.0):
        for push in (-0.4 * full, 0.4 * full):
            x, flat = steady(name, sheet, volts, rock=0.02 * full, push=push)
            ideal = (x['pa'] - x['pb']) * flat['per_turn'] * flat['d_motor'] * x['w']
            shaft = x['torque'] * x['w']
            assert np.sign(x['w']) == np.sign(volts)
            assert np.sign(shaft) == np.sign(volts * push)
            assert shaft < ideal
            if name == 'closed':
                hydraulic = x['q_pump'] * (x['pa'] - x['pb'])
                assert ideal < hydraulic < x['t_pump'] * x['w_pump']


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_both_directions_are_alike_where_the_machine_is(name):
    sheet = sheet_of(name)
    full = rigs.scales(sheet)['T']
    a, _ = steady(name, sheet, 5.0, 0.5 * full, 0.1 * full, seconds=4.0, detail=1.0)
    b, _ = steady(name, sheet, -5.0, 0.5 * full, -0.1 * full, seconds=4.0, detail=1.0)
    for one, other in (('pa', 'pb'), ('pb', 'pa'), ('q_drain', 'q_drain')):
        assert a[one] == pytest.approx(b[other], rel=1e-9)
    for key in ('w', 'torque', 'theta', 't_drive'):
        assert a[key] == pytest.approx(-b[key], rel=1e-9)


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_another_solver_gives_the_same(name):
    """Radau of SciPy over a step of command and load."""
    sheet = sheet_of(name)
    flat = make.machine(sheet, {}, {}, np.random.default_rng(0), 1.0, [])
    p = record(flat)
    kernel, full, n = make.KERNEL[name], rigs.scales(sheet)['T'], 600
    one = np.ones(n)
    out = kernel.run(p, 0 * one, 6.0 * one, False, 0.5 * full * one, 0 * one, one, 50 * one, one,
                     0 * one, 0 * one, flat['d_motor'] * one, 1)
    states = dict(zip(kernel.OUT, out[-1]))
    y = np.zeros(kernel.STATES)
    dy, aux = np.zeros(kernel.STATES), np.zeros(11)
    if name == 'closed':
        y[[PA, PB, circuit.PC]], y[circuit.WP] = flat['c_set'], flat['w_pump']
        aim = circuit.stroke(round(6.0 * 409.6) / 409.6, flat['u_zero'], flat['corner'])
        args = (aim, flat['d_motor'], 0.5 * full, 0.0, 1.0, 50.0, 1.0, 1.0, 1.0)
    else:
        y[[PA, PB]] = 5e5
        behind = round(6.0 * 409.6) / 409.6 - 0.5 * flat['spool_play']
        args = (behind, flat['d_motor'], 0.5 * full, 0.0, 1.0, 50.0, flat['p_supply'])

    def rates(t, at):
        kernel.rhs(p[0], at, dy, aux, *args)
        return dy.copy()

    size = np.where(np.isin(np.arange(y.size), [PA, PB]), 1.0, 1e-7)
    end = solve_ivp(rates, (0, (n - 1) / 1000), y, 'Radau', rtol=1e-7, atol=size).y[:, -1]
    for key, i in (('pa', PA), ('pb', PB), ('w', W), ('theta', ANGLE)):
        assert states[key] == pytest.approx(end[i], rel=1e-4), key
    assert abs(end[STROKE]) > 0.4


def test_what_is_lost_comes_through_the_check_valves_of_a_stiff_machine():
    """Of a large charge pump on short lines: steps of 0.2 ms let its valves swing up."""
    exact = make_campaign('closed', 9671, logs=('drilling',), duration=10.0).exact['drilling']
    settled = slice(3000, None)
    made, lost = (exact[name][settled].mean() for name in ('q_check', 'q_out'))
    assert made == pytest.approx(lost, rel=0.01)


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_effects_act_in_the_right_direction(name):
    sheet = sheet_of(name)
    full = rigs.scales(sheet)['T']

    def at(effects, volts=8.0, push=0.0, **more):
        return steady(name, sheet, volts, 0.6 * full - 1.2 * abs(push), push, effects, **more)[0]

    plain, braked = at({}), at({}, push=-0.4 * full)
    rise = plain['pa'] - plain['pb']
    for ident in ('bearing_friction', 'viscous_drag', 'hydrodynamic_drag', 'gearbox_loss'):
        x, y = at({ident: 1.0}), at({ident: 1.0}, push=-0.4 * full)
        assert x['pa'] - x['pb'] > rise + BAR, ident
        assert y['pa'] - y['pb'] > braked['pa'] - braked['pb'] + 0.5 * BAR, ident
    for ident in ('motor_leakage', 'motor_orifice_leakage', 'elastic_leakage',
                  'cross_port_leakage'):
        x = at({ident: 1.0})
        assert x['w'] < plain['w'], ident
        assert (x['q_drain'] > 1.2 * plain['q_drain']) == (ident != 'cross_port_leakage'), ident
    assert at({'leakage_temperature': 1.0}, fluid=1.5)['q_drain'] > 1.4 * plain['q_drain']
    if name == 'valve':
        assert at({'back_pressure': 1.0})['pb'] > plain['pb'] + BAR
        assert at({'valve_dead_band': 1.0})['w'] < plain['w']
        return
    for ident in ('pump_leakage', 'swash_compliance', 'suction_starvation', 'pump_speed_droop',
                  'compressibility_flow', 'cross_port_relief_cracking', 'pump_command_offset',
                  'leaking_check_valve', 'pump_hysteresis'):
        assert at({ident: 1.0})['w'] < plain['w'] * 0.999, ident
    for form in ('relief', 'worn_pump'):
        x = at({'charge_pressure_loss': 1.5}, forms={'charge_pressure_loss': form})
        assert x['pc'] < plain['pc'] - 1.0 * BAR and x['pb'] < plain['pb'] - 1.0 * BAR
    assert at({'swash_compliance': 1.0})['d_pump'] < 0.99 * plain['d_pump']
    lossy = at({'line_loss': 1.0})
    assert lossy['pa'] - lossy['pb'] > rise + 4 * BAR


def test_a_play_that_closes_is_no_play_and_a_wide_one_frees_the_load():
    def speed(size):
        x = make_campaign('closed', 2, {'gear_backlash': size}, duration=6.0, logs=('sweep',),
                          forms={'gear_backlash': 'gap'}, noise=0.0).exact['sweep']
        return x['w']
    rigid = make_campaign('closed', 2, {}, duration=6.0, logs=('sweep',), noise=0.0,
                          changes={'sheet': sheet_like(2)}).exact['sweep']['w']
    top = np.max(np.abs(rigid))
    assert np.sqrt(np.mean((speed(1e-3) - rigid) ** 2)) < 0.02 * top
    assert np.max(np.abs(speed(1.0) - rigid)) > 0.05 * top


def sheet_like(seed):
    """Return the datasheet that an effect of the gear draws with this seed."""
    return rigs.draw('closed', np.random.default_rng([seed, 1]), gear=True)


@lru_cache
def short(name, ident='', size=0.0, form=''):
    """Return a short campaign without noise, on all channels."""
    every = make.draw_channels(name, list(KNOWN[name]), np.random.default_rng(1))
    return make_campaign(name, 7, {ident: size} if ident else {}, forms={ident: form},
                         duration=6.0, logs=('sweep',), noise=0.0, channels=every,
                         changes={'sheet': sheet_of(name, 5)})


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_each_effect_shows_in_each_form(name):
    for ident, effect in KNOWN[name].items():
        none = short(name, ident, 1e-5, effect.forms[0]) if effect.warm else short(name)
        for form in effect.forms:
            made = short(name, ident, 2.0, form)
            most = 0.0
            for column, values in made.logs['sweep'].items():
                assert np.isfinite(values).all(), (ident, column)
                sensor = made.sheet['sensors'].get(column.split('[')[0])
                if sensor:
                    noise = next(v for k, v in sensor.items() if k.startswith('noise'))
                    error = values - none.logs['sweep'][column]
                    most = max(most, np.sqrt(np.mean(error ** 2)) / noise)
            assert most > 1.0, (ident, form)


@pytest.mark.parametrize('name', ['closed', 'valve'])
def test_written_campaign(name, tmp_path):
    make.main(['--circuit', name, '--seed', '6', '--count', '2', '--kind', 'unlisted',
               '--duration', '3', '-o', str(tmp_path)])
    folder = tmp_path / '0001'
    truth = json.loads((folder / 'truth.json').read_text())
    assert truth['effects'] == {} and truth['unlisted'] and truth['seed'] == 7
    assert list(truth['enters']) == list(truth['depends_on']) == list(truth['sizes'])
    sheet = yaml.safe_load((folder / 'rig.yaml').read_text())
    assert sheet['circuit'] == name
    for log in ('drilling', 'reverse', 'sweep', 'holdout'):
        lines = (folder / f'{log}.csv').read_text().splitlines()
        assert 'line_a_pressure[bar],line_b_pressure[bar],motor_speed[rpm]' in lines[0]
        assert len(lines) == 1 + 3 * truth['rate_hz']
    make.main(['--circuit', name, '--effect', 'motor_leakage=0.5,viscous_drag', '--duration', '2',
               '-o', str(tmp_path / 'two')])
    truth = json.loads((tmp_path / 'two' / '0000' / 'truth.json').read_text())
    assert truth['effects']['motor_leakage'] == 0.5 and not truth['unlisted']
    assert 0.5 <= truth['effects']['viscous_drag'] <= 2


def test_the_second_displacement_is_faster_at_the_same_flow():
    seed = next(s for s in range(99) if 'second_displacement_cc_rev' in rigs.draw(
        'closed', np.random.default_rng([s, 1]))['motor'])
    c = make_campaign('closed', seed, {}, duration=12.0, logs=('drilling',), noise=0.0)
    volts, x = c.logs['drilling']['motor_displacement_command[V]'], c.exact['drilling']
    assert set(volts) == {0.0, 10.0}
    first, second = (x['q_motor'][k] / x['w'][k] for k in (5000, 8000))
    motor = c.sheet['motor']
    assert second / first == pytest.approx(
        motor['second_displacement_cc_rev'] / motor['displacement_cc_rev'], rel=0.1)
