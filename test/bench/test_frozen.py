# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulator behind the frozen campaigns: is a healthy machine the datasheet's machine."""
import ast
import json
from pathlib import Path

from bench.frozen import campaign, datasheet, listed, make, profiles, solve, tally, unlisted
from bench.frozen import equations as eq
from bench.frozen.kind import Kind
from bench.frozen.plant import BAR, build, CC, LPM, RPM
import numpy as np
import pytest
import yaml

SHEET = datasheet.rig()
SHARES = {'none': 0.2, 'single': 0.35, 'pair': 0.15, 'unlisted': 0.3}
HEALTHY = build(SHEET, datasheet.unit(SHEET, None))
TOP = Path(__file__).parents[2]
quick = pytest.mark.needs_numba


def drilled(pprv: list[float], seconds: float = 15.0, plant=HEALTHY) -> np.ndarray:
    """Hold 100 rpm through steps of the load, without noise."""
    v = np.repeat(pprv, int(seconds * 100))
    outside = np.zeros((len(v) * 10, 3))
    outside[:, eq.OIL] = 50
    return solve.run(plant, np.full(len(v), 100 * RPM), np.full(len(v), np.nan), v, outside,
                     np.zeros(len(v) * 10), campaign.STEP)


def test_numbers_are_those_of_the_shipped_rig():
    shipped = yaml.safe_load((TOP / 'config/rig/test_rig.yaml').read_text(encoding='utf-8'))
    own = yaml.safe_load(datasheet.rig_text(SHEET))
    assert {k: v for k, v in shipped.items() if k != 'name'} == {
        k: v for k, v in own.items() if k != 'name'}


def test_nothing_of_the_product_or_of_the_other_generator_is_imported():
    names = set()
    for path in (TOP / 'bench/frozen').glob('*.py'):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names.add(node.module)
    assert not [n for n in names if n.split('.')[0] in ('hst_drive', 'test')]
    assert all(n.startswith('bench.frozen') for n in names if n.split('.')[0] == 'bench')


@quick
def test_operating_points_of_the_datasheet():
    # Speed is held to a step of the reading (0.05 rpm), so that the command may be 0.003 V off.
    rows = drilled([0.5, 3.6, 3.75, 3.9, 4.0])[14990::15000]
    command, pressure, torque = rows[:, eq.O_U], rows[:, eq.O_P] / BAR, rows[:, eq.O_TORQUE]
    assert rows[:, eq.O_W] / RPM == pytest.approx(100, abs=0.06)
    assert command[0] == pytest.approx(5.608, abs=0.006)
    assert np.interp(223.5, torque, pressure) == pytest.approx(82.2, abs=0.2)
    assert np.interp(241.1, torque, pressure) == pytest.approx(88.5, abs=0.2)
    assert np.interp(241.1, torque, command) == pytest.approx(5.777, abs=0.006)


@quick
def test_balances_close_at_rest_and_on_the_way():
    rows = drilled([0.5, 3.0, 1.5], 6.0)[3000:]
    k = HEALTHY.bulk + HEALTHY.stiffening * (rows[:, eq.O_P] - 0.25 * HEALTHY.p_top)
    net = rows[:, eq.O_IN] - rows[:, eq.O_OUT] - rows[:, eq.O_FLOW]
    raised = np.trapezoid(k / HEALTHY.volume * net, dx=1e-3) if hasattr(np, 'trapezoid') \
        else np.trapz(k / HEALTHY.volume * net, dx=1e-3)
    assert raised == pytest.approx(rows[-1, eq.O_P] - rows[0, eq.O_P], abs=0.01 * BAR)
    gained = np.cumsum(rows[:, eq.O_NET]) * 1e-3
    assert gained[-1] == pytest.approx(
        HEALTHY.inertia * (rows[-1, eq.O_W] - rows[0, eq.O_W]), abs=0.02)
    # In the mean of the last second, pumped less the table's leakage is what the hydromotor takes
    # (0.0985 L/min at 25 bar and 5.7 V; 0.3 for each 75 bar), and no power comes from nowhere.
    last = rows[-1000:].mean(axis=0)
    leakage = (0.0985 + 0.004 * (last[eq.O_P] / BAR - 25)) * LPM
    assert last[eq.O_STROKE] * last[eq.O_SHAFT] - leakage == pytest.approx(
        last[eq.O_FLOW], abs=0.004 * LPM)
    out = last[eq.O_TORQUE] * last[eq.O_W]
    assert 0.7 < out / (last[eq.O_P] * last[eq.O_FLOW]) < 0.9


@quick
@pytest.mark.parametrize('name', datasheet.SIZES)
def test_rigs_of_other_sizes_hold_their_speed(name):
    sheet = datasheet.rig(name)
    here = campaign.setting([], [3, 1], rig=name, seconds=40.0, roughness=1e-3)
    rows = campaign.simulate(here, here.base, 'drilling', [])
    speed = rows[20000:, eq.O_W] / RPM
    assert np.mean(speed) == pytest.approx(datasheet.nominal_speed(sheet), rel=0.01)
    pressure = rows[:, eq.O_P] / BAR
    assert 0.3 < pressure.max() / sheet['relief_valve']['set_pressure_bar'] < 1.0


@quick
def test_readings_have_the_stated_noise_and_resolution(tmp_path):
    truth = make.make(11, 0, tmp_path, 'none', plain=True, rig='test rig', on_datasheet=True,
                      each_ms=10, seconds=40.0)
    assert truth['effects'] == [] and truth['unit_on_datasheet']
    here = campaign.setting([], [11, 0], plain=True, rig='test rig', on_datasheet=True,
                            each_ms=10, seconds=40.0)
    rows = campaign.simulate(here, here.base, 'open_loop', [])[::10]
    path = tmp_path / 'open_loop.csv'
    names = path.read_text(encoding='utf-8').splitlines()[0].split(',')
    log = dict(zip(names, np.loadtxt(path, delimiter=',', skiprows=1).T))
    assert log['time[s]'] == pytest.approx(0.01 * np.arange(4000))
    for name, clean, noise, step in (
            ('motor_inlet_flow[L/min]', rows[:, eq.O_FLOW] / LPM, 0.05, 0.0146484375),
            ('motor_speed[rpm]', rows[:, eq.O_READ] / RPM, 0.15, 0.05),
            ('load_torque[N.m]', rows[:, eq.O_TORQUE], 0.5, 0.1)):
        off = log[name] - clean
        assert np.std(off) == pytest.approx(np.hypot(noise, step / 12 ** 0.5), rel=0.05)
        assert abs(np.mean(off)) < 4 * noise / len(off) ** 0.5
        assert np.abs(log[name] / step - np.rint(log[name] / step)).max() < 0.02


@quick
def test_seed_and_index_decide_all(tmp_path):
    for folder in ('a', 'b'):
        make.make(12, 7, tmp_path / folder, 'none', seconds=10.0)
    make.make(13, 7, tmp_path / 'c', 'none', seconds=10.0)
    one, same, other = ({p.name: p.read_bytes() for p in (tmp_path / f).iterdir()} for f in 'abc')
    assert one == same
    assert one['drilling.csv'] != other['drilling.csv']


@pytest.fixture(scope='module')
def gauge() -> campaign.Gauge:
    """One healthy machine in hard rock whose oil warms, to try all kinds on."""
    asks = Kind('', '', 0, 1, wide=True, heavy=True, slowest_ms=20)
    found = campaign.Gauge(campaign.setting([asks], [14, 0], rig='test rig', on_datasheet=True,
                                            plain=True, seconds=16.0, roughness=2e-3))
    found.logs = ['open_loop']
    return found


@quick
@pytest.mark.parametrize('name', [*listed.KINDS, *unlisted.KINDS])
def test_at_its_neutral_size_nothing_is_wrong_and_at_a_large_one_there_is(name, gauge):
    kind = {**listed.KINDS, **unlisted.KINDS}[name](np.random.default_rng(5), HEALTHY)
    # A hose cannot be shorter than nothing, and a converter has steps.
    allowed = 0.25 if name in ('line_loss', 'line_inertance', 'pressure_drops_bits') else 1e-6
    assert gauge.moves(kind, kind.neutral) <= allowed
    large = max(kind.sizes) if kind.sizes else 0.5 * (kind.low + kind.high)
    assert gauge.moves(kind, large) > 1.0


@quick
def test_both_solvers_agree():
    """One tenth of a second after a stroke, by Runge and Kutta and by LSODA."""
    p, c = HEALTHY.packed()
    found = []
    for solver in (solve._runge_kutta, solve._lsoda):
        y, states = eq.start(p, c, 2.0), np.empty((solve.SAMPLE, eq.STATES))
        outside = np.tile([0.0, 50.0, 0.0], (200, 1))
        for k in range(0, 200, solve.SAMPLE):
            y = solver(y, k, 5.0, 2.0, outside, p, c, 5, states)
        found.append(y)
    assert found[0][eq.P] == pytest.approx(found[1][eq.P], rel=1e-3)
    assert found[0][eq.W] == pytest.approx(found[1][eq.W], rel=1e-3)
    assert found[0][eq.STROKE] > 5 * CC


def test_mix_and_turns():
    groups = [make.group_of(i, None) for i in range(200)]
    for group, share in SHARES.items():
        numbers = [n for g, n in groups if g == group]
        assert numbers == list(range(int(200 * share)))
    names = list(listed.KINDS)
    assert sorted(make.deck(names, 1, n, 6)[0] for n in range(len(names))) == sorted(names)


def test_rough_rock_has_its_size():
    noise = profiles.rough(np.random.default_rng(0), 400_000, 0.02, 0.1)
    assert np.std(noise) == pytest.approx(0.02, rel=0.05)


def test_wilson_and_what_counts_as_right():
    # E. B. Wilson's interval for 0 of 10 ends at z^2 / (10 + z^2).
    assert tally.wilson(0, 10) == pytest.approx((0, 3.8415 / 13.8415), abs=1e-4)
    truth = {'kind': 'single', 'effects': ['a'], 'enters': ['flow'], 'strength': 'typical'}
    row = {'truth': truth, 'verdict': 'ambiguous', 'named': ['b'], 'rivals': ['a'],
           'unknown_enters': None, 'before': 3.0, 'after': 1.0, 'seconds': 4.0}
    assert tally.in_set(row) and not tally.misplaced(row)
    assert tally.misplaced(row | {'verdict': 'missing_effect'})
    assert not tally.misplaced(row | {'verdict': 'missing_effect', 'named': ['a']})
    assert tally.group(row, ['a']) == 'single'
    assert tally.group(row, ['b']) == 'unlisted'
    strange = row | {'verdict': 'unknown', 'unknown_enters': 'flow'}
    assert tally.right_place(strange)
    assert '1 of 1' in tally.table([json.loads(json.dumps(row))], ['a'])
