# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Limit cycles are told from ringing and ripple, and compared by their means."""
from hst_drive.measure.oscillation import means_where, shaking
from hst_drive.measure.run import Run
import numpy as np
import pytest

STEP = 0.01
TIME = np.arange(0.0, 30.0, STEP)


def swing(amplitude: float, decay: float = np.inf) -> np.ndarray:
    """Return a speed of 4 rad/s that swings at 4 Hz from the tenth second on."""
    since = np.maximum(TIME - 10.0, 0.0)
    return 4.0 + amplitude * np.exp(-since / decay) * np.sin(8 * np.pi * since) * (TIME >= 10.0)


def recorded(speed: np.ndarray, name: str = 'motor_speed') -> Run:
    return Run(TIME, {name: speed}, 'log.csv')


@pytest.mark.parametrize('name', ['motor_speed', 'motor_inlet_flow'])
def test_what_goes_on_and_on_is_told(name):
    found = shaking(recorded(swing(3.0), name))
    assert found[1050:2950].all() and not found[:950].any()


@pytest.mark.parametrize('speed', [
    swing(3.0, decay=0.7), swing(0.4), 4.0 + 0.0 * TIME, np.where(TIME < 15.0, 2.0, 9.0),
    np.zeros_like(TIME)], ids=['ringing', 'ripple', 'steady', 'step', 'rest'])
def test_what_ends_or_is_small_is_not(speed):
    assert not shaking(recorded(speed)).any()


def test_nothing_shakes_that_was_not_recorded():
    assert not shaking(recorded(swing(3.0), 'load_torque')).any()
    assert not shaking(recorded(np.full_like(TIME, np.nan))).any()


@pytest.mark.parametrize('step', [0.002, 0.01, 0.05])
def test_the_phase_does_not_count_there_but_the_mean_does(step):
    time = np.arange(0.0, 30.0, step)
    where = (time > 10.0) & (time < 20.0)
    phase = np.sin(8 * np.pi * time) - np.sin(8 * np.pi * time + 2.0)
    known = np.ones_like(where)
    means = means_where(phase + 0.5, known, where, step)
    assert means[where] == pytest.approx(0.5, abs=0.01)
    assert np.array_equal(means[~where], (phase + 0.5)[~where])
    known[::7] = False      # readings that were lost weigh nothing
    gaps = means_where(np.where(known, phase + 0.5, 1e3), known, where, step)
    assert gaps[where] == pytest.approx(0.5, abs=0.05)
