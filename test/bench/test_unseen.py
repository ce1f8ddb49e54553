# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The generator of unseen campaigns: the datasheet's tables, other solvers, closed forms."""
from collections import Counter
import csv
import json
from math import pi

from bench.unseen import campaign, datasheet, machine, make, plan, profiles, score, stepper
from bench.unseen.fault import Drawn
from bench.unseen.kernel import packed
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator
import yaml

RIG = datasheet.TEST_RIG
HEALTHY = machine.build(RIG, {}, {})
FORMS = [pytest.param(fault, i, id=f'{fault.id}-{form[0]}')
         for fault in (*plan.LISTED, *plan.UNLISTED) for i, form in enumerate(fault.forms)]


def by_table(table: dict, second: str):
    """Return a table of the datasheet as function of bar and the second argument."""
    rows = table['pressure_bar'], table[second]
    return RegularGridInterpolator(rows, np.array(table['table']))


def driven(m, setpoint, manual, pprv) -> np.ndarray:
    """Run a drive without noise or roughness."""
    ticks = len(pprv)
    still = np.zeros(ticks)
    return stepper.run(stepper.at_rest(m, 3e5), setpoint, manual, pprv, still + 1, still,
                       still + 1, still, 0.0, stepper.steps_for(m, 700.0), packed(m))


def asked(fault, form: int = 0) -> plan.Plan:
    """Return a small plan with one effect."""
    return plan.plan(0)._replace(
        kind='single', drawn=(Drawn(fault, form, 7),), bands=((5.0, 15.0),), on_datasheet=True,
        other_size=False, row=0.01, seconds=(2.0, 2.0), names=('manual', 'holdout'), missing=(),
        jitter=0.0, lost=0.0)


def listed(name: str):
    """Return a listed effect."""
    return next(fault for fault in plan.LISTED if fault.id == name)


@pytest.mark.slow
@pytest.mark.parametrize('u, v', [(3.5, 1.5), (5.0, 4.0), (7.5, 5.0)])
def test_balances_close_in_steady_state(u, v):
    """Flow and torque by the datasheet's tables, read by another interpolation."""
    ticks = 8000
    last = driven(HEALTHY, np.zeros(ticks), np.full(ticks, u), np.full(ticks, v))[-1]
    bar, flow = last[stepper.SEEN_P] / 1e5, last[stepper.SEEN_Q] * 6e4
    rpm, torque = last[stepper.SEEN_W] * 30 / pi, last[stepper.SEEN_T]
    pump, motor = RIG['pump'], RIG['motor']
    curve = pump['displacement_vs_command']
    given = np.interp(u, curve['command_V'], curve['displacement_cc_rev']) * 1450 / 1e3
    lost = by_table(pump['leakage_L_min'], 'command_V')((bar, u))
    assert given - lost == pytest.approx(flow, abs=0.005)
    slip = by_table(motor['leakage_L_min'], 'speed_rpm')((bar, min(rpm, 200)))
    assert 195 * rpm / 1e3 + slip == pytest.approx(flow, abs=0.005)
    eta = by_table(motor['mechanical_efficiency'], 'speed_rpm')((bar, min(rpm, 200)))
    assert eta * bar * 1e5 * 195e-6 / (2 * pi) == pytest.approx(torque, abs=0.05)


@pytest.mark.slow
def test_published_operating_point():
    """100 rpm and 241.1 N m take 88.5 bar and 5.777 V (the paper: 88.43 bar, 5.781 V)."""
    ticks = 12000
    lines = []
    for v in (3.0, 3.5):
        out = driven(HEALTHY, np.full(ticks, 10 * pi / 3), np.full(ticks, -1.0),
                     np.full(ticks, v))
        lines.append(out[-1, [stepper.SEEN_T, stepper.SEEN_P, stepper.U, stepper.SEEN_W]])
    low, high = lines
    share = (241.1 - low[0]) / (high[0] - low[0])
    between = low + share * (high - low)
    assert between[1] / 1e5 == pytest.approx(88.5, abs=0.3)
    assert between[2] == pytest.approx(5.777, abs=0.005)
    assert between[3] * 30 / pi == pytest.approx(100, abs=0.05)


@pytest.mark.slow
def test_another_solver_agrees():
    """The datasheet's equations, written out and integrated with LSODA."""
    exact = machine.build(RIG, {}, {'bulk_growth': 0.0, 'pilot_lag': 1e-6})
    ticks = 3000
    out = driven(exact, np.zeros(ticks), np.full(ticks, 5.0), np.full(ticks, 3.0))
    leak_p = by_table(RIG['pump']['leakage_L_min'], 'command_V')
    leak_m = by_table(RIG['motor']['leakage_L_min'], 'speed_rpm')
    eta = by_table(RIG['motor']['mechanical_efficiency'], 'speed_rpm')
    brake = RIG['loading']['pump_mechanical_efficiency']
    motor, loading = 195e-6 / 2 / pi, 10e-6 / 2 / pi

    def rates(_, y):
        pressure, speed, pprv, stroke = y
        bar, rpm = np.clip(pressure / 1e5, 0, 200), np.clip(speed * 30 / pi, 0, 200)
        flow = stroke * 1.45 - leak_p((bar, 5.0)) - leak_m((bar, rpm))
        load = max(pprv + 0.4 * (20 * 10 * speed * 30 / pi / 1e3 - 20), 0.0)
        torque = load * 1e5 * loading * 20 / np.interp(load, brake['pressure_bar'],
                                                       brake['efficiency'])
        torque *= np.tanh(speed / 0.15)
        return [1.2e9 / 9e-4 * (flow / 6e4 - motor * speed),
                (eta((bar, rpm)) * pressure * motor - torque) / 0.35, (48.0 - pprv) / 0.05,
                (11.5 - stroke) / 0.06]

    done = solve_ivp(rates, (0, 2.999), [3e5, 0.0, 3.0, 0.0], 'LSODA', rtol=1e-7, atol=1e-6,
                     max_step=0.01, t_eval=np.arange(0, 3, 0.05))
    ours = out[::50]
    # A tenth of the sensors' noise, in the mean square.
    assert np.sqrt(np.mean((done.y[0] - ours[:, stepper.SEEN_P]) ** 2)) < 1200
    assert np.sqrt(np.mean((done.y[1] - ours[:, stepper.SEEN_W]) ** 2)) < 0.0016


@pytest.mark.slow
@pytest.mark.parametrize('fault, form', FORMS)
def test_size_zero_changes_nothing_and_the_largest_shows(monkeypatch, fault, form):
    """Every form of every effect."""
    small = asked(fault, form)._replace(seconds=(5.0,), names=('manual',))
    monkeypatch.setattr(campaign, 'plan', lambda seed: small)

    def worst(size: float, attempt: int) -> float:
        where = campaign.setting(3, attempt)
        return max(campaign.simulate(where, small.drawn[0].at(size, where.scale)[1])[1].values())

    assert worst(0.0, 0) < 1e-6
    # Not every operator comes where each effect shows.
    assert any(worst(fault.high, attempt) > 2 for attempt in range(campaign.ATTEMPTS))


@pytest.mark.slow
@pytest.mark.parametrize('name, column, noise', [
    ('flow_sensor_scale', 'motor_inlet_flow[L/min]', 0.05),
    ('torque_sensor_scale', 'load_torque[N.m]', 0.5)])
def test_stated_moves_follow_from_the_file(monkeypatch, tmp_path, name, column, noise):
    """What a factor changes is its share of the reading."""
    monkeypatch.setattr(campaign, 'plan', lambda seed: asked(listed(name)))
    make.write(campaign.find(5), tmp_path)
    truth = json.loads((tmp_path / 'truth.json').read_text())
    readings = []
    for path in tmp_path.glob('*.csv'):
        with path.open() as file:
            readings += [float(row[column]) for row in csv.DictReader(file)]
    factor = truth['effects'][name]['scale']
    moved = abs(1 - 1 / factor) * np.sqrt(np.mean(np.square(readings))) / noise
    stated = truth['moves'][column.partition('[')[0]]
    assert stated == pytest.approx(moved, rel=0.02)
    assert 5 <= stated <= 15


@pytest.mark.slow
def test_stated_moves_of_a_leak_are_its_flow(monkeypatch):
    """In steady state a leak before the meter takes g P from the motor's flow."""
    ticks = 8000
    leak = {'pump_gap': 2e-12}
    commands = np.zeros(ticks), np.full(ticks, 5.0), np.full(ticks, 3.0)
    ill = driven(machine.build(RIG, {}, leak), *commands)[-1]
    well = driven(HEALTHY, *commands)[-1]
    short = well[stepper.SEEN_Q] - ill[stepper.SEEN_Q]
    assert short == pytest.approx(2e-12 * ill[stepper.SEEN_P], rel=0.03)


@pytest.mark.slow
def test_seeds_reproduce_and_files_keep_the_contract(monkeypatch, tmp_path):
    """The same bytes again; headers with units; a rig that reads back as the datasheet."""
    monkeypatch.setattr(campaign, 'plan', lambda seed: asked(listed('bearing_friction')))
    for folder in ('one', 'again'):
        make.write(campaign.find(11), tmp_path / folder)
    names = sorted(path.name for path in (tmp_path / 'one').iterdir())
    assert names == ['holdout.csv', 'manual.csv', 'rig.yaml', 'truth.json']
    for name in names:
        first, second = ((tmp_path / folder / name).read_bytes() for folder in ('one', 'again'))
        assert first == second
    assert yaml.safe_load((tmp_path / 'one' / 'rig.yaml').read_text()) == RIG
    lines = (tmp_path / 'one' / 'holdout.csv').read_text().splitlines()
    assert lines[0] == ('time[s],pump_command[V],pprv_command[V],speed_setpoint[rpm],'
                        'oil_temperature[degC],pump_outlet_pressure[bar],'
                        'motor_inlet_flow[L/min],motor_speed[rpm],load_torque[N.m]')
    times = [float(line.split(',')[0]) for line in lines[1:]]
    assert np.diff(times) == pytest.approx(0.01, abs=1e-9)


def test_other_sizes_read_back():
    """YAML 1.1 takes 1e-05 for a word."""
    for seed in range(20):
        sheet, size = datasheet.other_size(np.random.default_rng(seed))
        assert yaml.safe_load(datasheet.as_yaml(sheet)) == sheet
        assert sheet['pump']['max_displacement_cc_rev'] == pytest.approx(28 * size, rel=1e-3)


def test_plans_keep_their_shares():
    """Of each twenty the same kinds; each listed effect as often as any other."""
    plans = [plan.plan(seed) for seed in range(20 * 31)]
    assert Counter(one.kind for one in plans[40:60]) == {
        'none': 4, 'single': 8, 'pair': 3, 'unlisted': 5}
    single = Counter(one.drawn[0].fault.id for one in plans if one.kind == 'single')
    assert len(single) == 31 and set(single.values()) == {8}
    unlisted = {one.drawn[0].fault.id for one in plans if one.kind == 'unlisted'}
    assert len(unlisted) >= 20 and not unlisted & set(single)
    assert {one.drawn[0].fault.enters for one in plans if one.kind == 'unlisted'} == {
        'flow', 'torque', 'pump_actuator', 'load', 'sensor'}


@pytest.mark.parametrize('law', ['walther', 'vogel'])
def test_viscosity_of_the_grade(law):
    """ISO VG 46 has 46 mm^2/s at 40 degC and 6.8 at 100 (viscosity index about 100)."""
    at_40, at_100 = profiles.viscosity_ratio(np.array([40.0, 100.0]), law)
    assert at_100 / at_40 == pytest.approx(46 / 6.8, rel=1e-9)
    assert profiles.viscosity_ratio(np.array([50.0]), law)[0] == 1.0


@pytest.mark.parametrize('kind, true, also, verdict, found, rivals, counts', [
    ('none', [], [], 'none', [], [], {'exact set'}),
    ('none', [], [], 'missing_effect', ['a'], [[]],
     {'false alarm', 'confident and wrong', '  and nothing right'}),
    ('single', ['a'], [], 'missing_effect', ['a'], [[]],
     {'first name right', 'exact set', 'in the set'}),
    ('single', ['a'], [], 'ambiguous', ['b'], [['a']], {'in the set'}),
    ('single', ['a'], ['b'], 'missing_effect', ['b'], [[]], set()),
    ('pair', ['a', 'b'], [], 'missing_effect', ['a', 'c'], [[], []],
     {'first name right', 'confident and wrong'}),
    ('unlisted', ['x'], [], 'unknown', [], [], {'unlisted flagged', 'place right'})])
def test_answers_are_counted(kind, true, also, verdict, found, rivals, counts):
    """Each count by its definition."""
    line = {'kind': kind, 'verdict': verdict, 'found': found, 'rivals': rivals, 'place': 'load',
            'truth': {'effects': {name: {} for name in true}, 'also': also, 'enters': 'load'}}
    assert {name for name, is_so in score.marks(line).items() if is_so} == counts
