# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A long recording: short cuts on the way must not change what comes out."""
from hst_drive.measure import kept_replay
from hst_drive.measure.compare import compare
from hst_drive.measure.errors import Moments, russell
from hst_drive.measure.floor import replay_floor
from hst_drive.measure.kept_replay import KeptReplay
from hst_drive.measure.pieces import LEAD, PIECES, simulate_in_pieces
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.measure.sections import AFTER, BEFORE, compare_sections
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

RIG = default_rig()


def long_inputs(seconds: float = 200.0) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return commands that step every few seconds, as in changing rock."""
    random = np.random.default_rng(3)
    time = np.arange(round(seconds * 100)) / 100
    rock = (time / 4.0).astype(int)
    return time, {'pump_command': 5.7 + random.uniform(-0.3, 0.3, rock.max() + 1)[rock],
                  'pprv_command': random.uniform(0.8, 4.2, rock.max() + 1)[rock]}


@pytest.mark.needs_numba
@pytest.mark.parametrize('effects', [
    {}, {'pump_hysteresis': {'width': 0.35}}, {'shaft_compliance': {}}, {'piston_ripple': {}}],
    ids=str)
def test_pieces_are_the_whole(effects):
    """Also where a piece's guess is wrong throughout: then it is run again."""
    drive = Drive(RIG, effects)
    time, inputs = long_inputs()
    whole = drive.simulate(time, inputs)
    for guess in (drive.initial_state(pump_command=5.7, pprv_command=2.0, speed=10.0),
                  drive.initial_state(pump_command=9.0, pressure=2e7)):
        state = drive.initial_state(pump_command=inputs['pump_command'][0],
                                    pprv_command=inputs['pprv_command'][0])
        found = simulate_in_pieces(drive, time, inputs, state, lambda row: guess.copy())
        for name, values in whole.items():
            assert np.allclose(found[name], values, rtol=1e-7, atol=1e-9 * np.ptp(values)), name
    assert time[-1] / PIECES > LEAD


@pytest.mark.needs_numba
def test_what_is_kept_is_what_would_be_computed():
    run, drive = record(4, duration=20.0), Drive(RIG)
    plain, kept = Replay(run, drive), KeptReplay(run, drive)
    assert replay_floor(plain, drive) == replay_floor(kept, drive)
    for other in (drive, Drive(RIG, {'motor_leakage': {}}), drive):
        one, two = plain.predict(other), kept.predict(other)
        assert all(np.array_equal(one[name], two[name]) for name in one)


@pytest.mark.needs_numba
def test_the_floor_of_stretches_is_that_of_the_whole(monkeypatch):
    run, drive = record(4, duration=200.0), Drive(RIG)
    whole = replay_floor(Replay(run, drive), drive)
    monkeypatch.setattr(kept_replay, 'LONG', 100.0)
    monkeypatch.setattr(kept_replay, '_STRETCH', 10.0)
    assert replay_floor(KeptReplay(run, drive), drive) == pytest.approx(whole, rel=0.05)


@pytest.mark.needs_numba
def test_sections_give_the_errors_of_the_whole():
    """20 min in sections of 7 min: errors within 0.1 %, noise and floor within 3 %."""
    pieces = [record(seed, duration=300.0, effects={'motor_leakage': {}}) for seed in range(4)]
    time = np.arange(sum(map(len, pieces))) / 100
    whole = Run('joined', time, {name: np.concatenate([piece[name] for piece in pieces])
                                 for name in pieces[0].channels}, 'joined.csv')
    drive = Drive(RIG)
    expected = compare(drive, [whole])
    edges = [0.0, 420.0, 840.0, np.inf]
    found = compare_sections(drive, 'joined', 'joined.csv', (
        (whole.between(start - BEFORE, end + AFTER), start, end)
        for start, end in zip(edges, edges[1:])), 420.0)
    assert found.logs[0].sections[:4] == (3, 420.0, BEFORE, AFTER)
    assert list(found.signals) == list(expected.signals)
    for name, entry in expected.signals.items():
        got = found.signals[name]
        assert got.samples == entry.samples
        for key in ('rmse', 'bias', 'fit'):
            assert getattr(got, key) == pytest.approx(getattr(entry, key), rel=1e-3,
                                                      abs=1e-3 * entry.rmse), (name, key)
        assert got.russell == pytest.approx(entry.russell, rel=1e-3, abs=1e-6)
        assert got.noise_std == pytest.approx(entry.noise_std, rel=0.03), name
        assert got.floor == pytest.approx(entry.floor, rel=0.03), name
    same = {(region.signal, region.variable) for region in expected.where[:3]}
    assert same & {(region.signal, region.variable) for region in found.where[:3]}


def test_moments_are_the_errors_of_all_samples():
    """Sums over parts, also with a mean far larger than the spread and with gaps."""
    random = np.random.default_rng(8)
    measured = 1e6 + random.standard_normal(1000)
    measured[100:140] = np.nan
    model = measured + 0.1 + random.standard_normal(1000)
    moments = Moments()
    for part in (slice(0, 120), slice(120, 135), slice(135, 1000)):
        moments.add(model[part], measured[part], 0.5, 2.0)
    found, known = moments.summary('Pa'), np.isfinite(measured)
    error, rmse = (model - measured)[known], np.sqrt(np.mean((model - measured)[known]**2))
    assert found[1:-1] == pytest.approx([
        known.sum(), rmse, error.mean(), np.abs(error).max(), 0.5, 2.0, rmse / 2.0,
        1.0 - rmse / np.std(measured[known])], rel=1e-9)
    assert found.russell == pytest.approx(russell(model[known], measured[known]), rel=1e-3,
                                          abs=1e-7)
    assert Moments().summary('Pa').samples == 0
