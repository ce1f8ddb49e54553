# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A long recording: short cuts on the way must not change what comes out."""
from hst_drive.measure import recorded_load
from hst_drive.measure.compare import compare
from hst_drive.measure.errors import Moments, russell
from hst_drive.measure.floor import replay_floor
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.measure.sections import AFTER, BEFORE, compare_sections
from hst_drive.measure.turns import turn
from hst_drive.model import Drive
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

RIG = default_rig()


@pytest.mark.needs_numba
@pytest.mark.parametrize('effects', [{'motor_leakage': {}}, {'gearbox_loss': {}}], ids=str)
def test_what_is_kept_is_what_would_be_computed(effects):
    """Effects that leave the load as it is, and that do not; what turned the shaft in between."""
    run, drive = record(4, duration=20.0), Drive(RIG)
    asked = Replay(run, drive)
    for other, angle in ((drive, 0.0), (Drive(RIG, effects), 0.0), (drive, 0.0), (drive, 0.3)):
        fresh = Replay(run, drive)
        if angle:
            turn(asked, angle)
            turn(fresh, angle)
        found, expected = asked.predict(other), fresh.predict(other)
        assert all(np.array_equal(found[name], expected[name]) for name in expected)


@pytest.mark.needs_numba
def test_one_draw_gives_the_floor_of_a_long_recording(monkeypatch):
    run, drive = record(4, duration=200.0), Drive(RIG)
    whole = replay_floor(Replay(run, drive), drive)
    monkeypatch.setattr(recorded_load, '_LONG', 100.0)
    assert replay_floor(Replay(run, drive), drive) == pytest.approx(whole, rel=0.05)


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
    model, measured = model[known], measured[known]
    assert found.russell == pytest.approx(russell(
        model @ model, measured @ measured, model @ measured), rel=1e-3, abs=1e-7)
    assert Moments().summary('Pa').samples == 0


@pytest.mark.needs_numba
def test_what_is_too_much_to_leave_out_is_told_as_a_share_of_the_whole_log(monkeypatch):
    """It fills most of the first of six sections and none of the others."""
    run = record(4, duration=12.0)
    run.channels['pump_outlet_pressure'][:180] = 0.0    # and the ringing after it
    found = compare_sections(Drive(RIG), 'log', 'log.csv', (
        (run.between(start, start + 2.0), start, start + 2.0) for start in range(0, 12, 2)), 2.0)
    assert found.logs[0].judged.kept['cavitation'] == pytest.approx(1.0 / 6.0)
