# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A long recording: short cuts on the way must not change what comes out."""
from hst_drive.measure import kept_replay
from hst_drive.measure.kept_replay import KeptReplay
from hst_drive.measure.pieces import LEAD, PIECES, simulate_in_pieces
from hst_drive.measure.replay import Replay
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
    assert plain.floor(drive) == kept.floor(drive)
    for other in (drive, Drive(RIG, {'motor_leakage': {}}), drive):
        one, two = plain.predict(other).signals, kept.predict(other).signals
        assert all(np.array_equal(one[name], two[name]) for name in one)


@pytest.mark.needs_numba
def test_the_floor_of_stretches_is_that_of_the_whole(monkeypatch):
    run, drive = record(4, duration=200.0), Drive(RIG)
    whole = Replay(run, drive).floor(drive)
    monkeypatch.setattr(kept_replay, 'LONG', 100.0)
    monkeypatch.setattr(kept_replay, '_STRETCH', 10.0)
    assert KeptReplay(run, drive).floor(drive) == pytest.approx(whole, rel=0.05)
