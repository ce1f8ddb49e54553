# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The truth generator: independent of the product, physical, and like the sample campaigns."""

import ast
from functools import lru_cache
import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('numba')

from . import EFFECTS, make_campaign, OUTSIDE, write_campaign  # noqa: E402
from .catalogue import TEMPERATURE  # noqa: E402
from .sensors import noise_of  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ROOT.parent / 'shared' / 'cases'
JUDGED = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
EVERY = {**EFFECTS, **OUTSIDE}


def column(campaign, log, channel):
    """Return a column by its name without the unit."""
    return next(v for k, v in campaign.logs[log].items() if k.split('[')[0] == channel)


def distance(a, b, start=100):
    """Return the greatest rms difference of any channel, in units of its noise."""
    return max(np.sqrt(np.nanmean((column(a, log, c) - column(b, log, c))[start:] ** 2))
               / noise_of(a.sheet, c)[0] for log in a.logs for c in JUDGED)


def imported(path):
    """Return the names of all modules that a Python file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield '.' * node.level + (node.module or '')


def test_it_imports_nothing_of_the_product_and_the_product_nothing_of_it():
    for path in Path(__file__).parent.rglob('*.py'):
        assert not [n for n in imported(path) if n.split('.')[0] == 'hst_drive'], path
    for path in (ROOT / 'hst_drive').rglob('*.py'):
        assert not [n for n in imported(path) if n.split('.')[0] in ('test', 'truth')], path


def test_a_seed_gives_the_same_campaign_and_another_seed_another():
    a, b, c = (make_campaign(s, {'line_loss': 1.0}, duration=10.0) for s in (4, 4, 5))
    for log in a.logs:
        for name, values in a.logs[log].items():
            np.testing.assert_array_equal(values, b.logs[log][name])
    assert a.truth == b.truth
    assert distance(a, c) > 1


def test_oil_balance_closes():
    c = make_campaign(1, {}, True, logs=('open_loop',))
    x = {k: v[5000:] for k, v in c.exact['open_loop'].items()}
    stored = 0.5 * 9e-4 / 1.2e9 * (x['p1'] + x['p2'])
    net = np.cumsum(x['q_pump'] - x['q_motor'] - x['q_relief']) * 1e-3
    through = np.sum(x['q_pump']) * 1e-3
    assert np.max(np.abs(stored - stored[0] - net + net[0])) < 1e-3 * through


def test_shaft_energy_closes():
    c = make_campaign(1, {}, True, logs=('open_loop',))
    x = {k: v[5000:] for k, v in c.exact['open_loop'].items()}
    work = np.cumsum((x['t_motor'] - x['t_load']) * x['w']) * 1e-3
    kinetic = 0.5 * 0.35 * x['w'] ** 2
    through = np.sum(x['t_motor'] * x['w']) * 1e-3
    assert np.max(np.abs(kinetic - kinetic[0] - work + work[0])) < 1e-3 * through


def test_published_operating_points():
    """The points of the drill-drive paper: 241.1 N m at 100 rpm takes 88.43 bar and 5.781 V."""
    n = 30000
    point = []
    for volts in (3.6, 3.9):
        held = {'setpoint': np.full(n, 100.0), 'manual': np.zeros(n), 'closed': True,
                'pprv': np.full(n, volts)}
        x = make_campaign(0, {}, True, duration=30.0, logs=('drilling',), noise=0.0,
                          roughness=0.0, command={'drilling': held}).exact['drilling']
        point.append([np.mean(x[k][-5000:]) for k in ('torque', 'p1', 'u')])
    share = (241.1 - point[0][0]) / (point[1][0] - point[0][0])
    _, pressure, command = np.add(point[0], share * np.subtract(point[1], point[0]))
    assert pressure == pytest.approx(88.43e5, rel=0.005)
    assert command == pytest.approx(5.781, rel=0.005)


def test_command_of_a_row_follows_from_the_speed_reading_of_that_row():
    c = make_campaign(2, {}, True, duration=20.0)
    e = (column(c, 'drilling', 'speed_setpoint') - column(c, 'drilling', 'motor_speed')) \
        * np.pi / 30
    u = column(c, 'drilling', 'pump_command')
    law = 0.02 * e + np.concatenate([[0.0], np.cumsum(0.45 * 0.01 * e)[:-1]])
    assert np.max(np.abs(u - law)) < 0.0013


@lru_cache
def plain(temperature):
    """Return a campaign without an effect at an oil temperature."""
    return make_campaign(5, {}, True, temperature=temperature)


@pytest.mark.parametrize('ident', EVERY)
def test_each_effect_shows_and_its_forms_differ(ident):
    temperature = 'warm' if ident in TEMPERATURE else 'steady'
    none = plain(temperature)
    made = [make_campaign(5, {ident: {'form': form}}, True, temperature=temperature)
            for form in EVERY[ident].forms]
    for campaign in made:
        assert all(np.isfinite(v).all() for cols in campaign.logs.values()
                   for v in cols.values())
        assert distance(campaign, none) > 3
    for other in made[1:]:
        assert distance(other, made[0]) > 0.04
    tiny = make_campaign(5, {ident: {'size': 1e-3, 'form': EVERY[ident].forms[0]}}, True,
                         temperature=temperature)
    limit = 40 if EVERY[ident].inverse else 1
    assert distance(tiny, none) < limit


@pytest.mark.parametrize('case, effects', [
    ('no_effect', {}),
    ('worn_motor', {'motor_leakage': {'form': 'laminar'}}),
    ('dry_bearing', {'bearing_friction': {'form': 'tanh'}})])
def test_like_the_samples(case, effects):
    """With a sample's own inputs the truth gives the sample's readings, down to its noise."""
    if not SAMPLES.is_dir():
        pytest.skip('the sample campaigns are not here')
    read, command = {}, {}
    for path in sorted((SAMPLES / case).glob('*.csv')):
        names = [n.split('[')[0] for n in path.read_text().split('\n', 1)[0].split(',')]
        read[path.stem] = dict(zip(names, np.loadtxt(path, delimiter=',', skiprows=1).T))
        x = {k: np.repeat(v, 10) for k, v in read[path.stem].items()}
        command[path.stem] = {'setpoint': x['speed_setpoint'], 'manual': x['pump_command'],
                              'pprv': x['pprv_command'], 'closed': False}
    made = make_campaign(1, effects, True, command=command, noise=0.0, roughness=0.0)
    for log, sample in read.items():
        for channel, limit in zip(JUDGED, (0.40, 0.08, 0.36, 0.9)):
            error = (sample[channel] - column(made, log, channel))[300:]
            assert np.std(error) < limit, (log, channel)
            assert abs(np.mean(error)) < limit / 2, (log, channel)


@pytest.mark.parametrize('rate', [20.0, 50.0, 100.0, 250.0, 500.0])
def test_rates(rate):
    c = make_campaign(3, {}, rate_hz=rate, duration=10.0, logs=('open_loop',))
    assert c.logs['open_loop']['time[s]'].size == 10 * rate
    assert np.std(np.diff(column(c, 'open_loop', 'motor_speed')[int(2 * rate):int(4 * rate)])) > 0


def test_imperfect_recording():
    c = make_campaign(3, {}, duration=20.0, jitter=1e-3, stamp_noise=5e-4, drop_out=0.01,
                      sensor_filter=0.002, delay={'motor_inlet_flow': 0.02}, gentle=True,
                      channels=('pump_command', 'pprv_command', 'motor_speed',
                                'motor_inlet_flow'))
    log = c.logs['drilling']
    assert [k.split('[')[0] for k in log] == ['time', 'pump_command', 'pprv_command',
                                              'motor_speed', 'motor_inlet_flow']
    assert np.all(np.diff(log['time[s]']) > 0)
    assert 0 < np.isnan(log['motor_speed[rpm]']).mean() < 0.03


def test_another_rig_holds_its_speed():
    for seed in range(4):
        c = make_campaign(seed, {'bearing_friction': 1.0, 'pump_leakage': 0.5}, rig_seed=seed)
        settled = slice(500, None)
        goal = column(c, 'drilling', 'speed_setpoint')[0]
        assert np.mean(column(c, 'drilling', 'motor_speed')[settled]) == pytest.approx(
            goal, rel=0.01)
        assert np.max(column(c, 'drilling', 'pump_outlet_pressure')) < 190


def test_written_campaign(tmp_path):
    c = make_campaign(6, {'line_loss': {'size': 0.5, 'form': 'blasius'}, 'pprv_creep': 1.0},
                      duration=5.0)
    write_campaign(c, tmp_path)
    truth = json.loads((tmp_path / 'truth.json').read_text())
    assert truth['effects'] == ['line_loss', 'unknown:pprv_creep']
    assert truth['si_parameters']['r_lam'] == pytest.approx(1.8e8)
    header = (tmp_path / 'drilling.csv').read_text().split('\n')[0]
    assert header.startswith('time[s],pump_command[V],pprv_command[V],speed_setpoint[rpm]')
    with pytest.raises(KeyError, match='no effect'):
        make_campaign(6, {'leakage': 1.0})
