# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Layered ground against Teale's balance worked by hand, energy, geometry and statistics."""
import math

from hst_drive.load.ground import Bit, Ground, Layer
from hst_drive.load.profiles import constant, Points
from hst_drive.load.rocks import ROCKS, typical_strength
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

REV = 2.0 * math.pi
RPM = REV / 60.0


def bit(**changes):
    """Return a 76 mm bit at 6 m/h and 100 rpm."""
    return Bit(**{'diameter': 0.076, 'depth_of_cut': 6.0 / 3600.0 / (100.0 / 60.0), **changes})


def test_torque_by_hand():
    """
    Teale's formula in the field's own numbers, worked on paper.

    90 MPa at efficiency 0.35: e = 257.143 MPa; A = 45.365 cm^2; u = 1/600 m/s; n = 100/60 /s;
    with 8 kN: F/A = 1.7635 MPa; T = (e - F/A) A u / (2 pi n) = 184.4 N m.
    """
    assert bit(weight=8e3).cutting_torque(90e6) == pytest.approx(184.4, rel=1e-3)


@settings(deadline=None, max_examples=30)
@given(st.lists(st.tuples(st.floats(0.01, 0.1), st.floats(10e6, 250e6), st.floats(0, 0.3)),
                min_size=1, max_size=5),
       st.floats(0, 1), st.floats(10, 150), st.integers(0, 99))
def test_energy_of_the_run_is_specific_energy_times_volume(described, exponent, rpm, seed):
    """What the bit turns in is what the drilled rock takes (thrust's share is nil here)."""
    layers = [Layer('rock', thickness, ucs, rough, 2e-3) for thickness, ucs, rough in described]
    speed = constant(rpm * RPM)
    ground = Ground(layers, bit(strength_exponent=exponent), speed, 30.0, start=2.0, seed=seed)
    turned = np.trapezoid(ground.torque, ground.time) * rpm * RPM \
        if hasattr(np, 'trapezoid') else np.trapz(ground.torque, ground.time) * rpm * RPM
    depth = np.diff(ground.depth)
    middle = 0.5 * (ground.strength[1:] + ground.strength[:-1])
    rock = np.sum(middle / 0.35 * bit().area * depth)
    assert turned == pytest.approx(rock, rel=0.02)


def test_depth_follows_the_penetration_rate():
    speed = Points([0.0, 10.0], [100.0 * RPM, 50.0 * RPM], 'zero')
    ground = Ground([Layer('coal', 1.0, 30e6)], bit(), speed, 20.0, start=4.0)
    at = np.searchsorted(ground.time, 10.0)
    assert ground.depth[at] == pytest.approx(6.0 / 600.0, rel=5e-3)
    assert ground.depth[-1] == pytest.approx(6.0 / 600.0 + 10.0 / 1200.0, rel=5e-3)


@given(st.floats(10e6, 300e6), st.floats(0.0, 1.0))
def test_torque_does_not_depend_on_speed(ucs, exponent):
    """The cut per revolution sets the torque (Detournay and Defourny see the same)."""
    results = [Ground([Layer('rock', 5.0, ucs)], bit(strength_exponent=exponent),
                      constant(rpm * RPM), 1.0)(0.5) for rpm in (40, 140)]
    assert results[0] == pytest.approx(results[1])
    assert results[0] == pytest.approx(bit().cutting_torque(ucs) * (60e6 / ucs)**exponent)


def test_boundary_is_crossed_over_the_height_of_the_bit():
    layers = [Layer('coal', 0.01, 30e6), Layer('limestone', 0.1, 90e6)]
    ground = Ground(layers, bit(height=2e-3), constant(100 * RPM), 20.0)
    low, high = bit().cutting_torque(30e6), bit().cutting_torque(90e6)
    inside = (ground.torque > low + 1) & (ground.torque < high - 1)
    assert ground.depth[inside].min() == pytest.approx(0.010, abs=1e-4)
    assert ground.depth[inside].max() == pytest.approx(0.012, abs=1e-4)
    assert np.all(np.diff(ground.torque) >= -1e-9)


def test_no_rotation_no_progress_and_free_torque_alone():
    speed = Points([0.0, 5.0, 10.0], [100 * RPM, 0.0, 100 * RPM], 'zero')
    ground = Ground([Layer('shale', 1.0, 50e6)], bit(free_torque=15.0), speed, 15.0, start=1.0)
    assert ground(0.5) == 15.0
    assert ground(7.0) == 15.0
    assert ground(12.0) > 50.0
    still = (ground.time > 5.05) & (ground.time < 9.95)
    assert np.ptp(ground.depth[still]) == 0.0


def test_roughness_has_the_stated_size_and_length():
    layers = [Layer('sandstone', 3.0, 80e6, 0.1, 2e-3)]
    ground = Ground(layers, bit(height=1e-3), constant(100 * RPM), 900.0, seed=4)
    deviation = ground.strength / 80e6 - 1.0
    assert np.mean(deviation) == pytest.approx(0.0, abs=0.01)
    assert np.std(deviation) == pytest.approx(0.1, rel=0.06)
    shift = int(round(2e-3 / (ground.depth[-1] / len(ground.depth))))
    correlation = np.corrcoef(deviation[:-shift], deviation[shift:])[0, 1]
    assert correlation == pytest.approx(math.exp(-1.0), abs=0.08)


def test_seed_decides_the_rock():
    layers = [Layer('sandstone', 1.0, 80e6, 0.1, 2e-3)]
    runs = [Ground(layers, bit(), constant(10.0), 5.0, seed=seed).torque for seed in (1, 1, 2)]
    assert np.array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_drilling_through_is_said():
    ground = Ground([Layer('coal', 0.005, 30e6)], bit(), constant(100 * RPM), 20.0)
    assert 'leaves the described ground' in ground.notes[0]
    assert ground(19.0) == pytest.approx(bit().cutting_torque(30e6))


def test_scale_shrinks_the_drill_to_the_rig():
    layers = [Layer('coal', 1.0, 30e6)]
    full = Ground(layers, bit(), constant(10.0), 1.0)(0.5)
    assert Ground(layers, bit(), constant(10.0), 1.0, scale=0.1)(0.5) == pytest.approx(0.1 * full)


def test_named_rocks():
    assert all(5e6 <= low < high <= 400e6 for low, high in ROCKS.values())
    assert typical_strength('coal') == pytest.approx(math.sqrt(25 * 50) * 1e6)
    with pytest.raises(ValueError, match="did you mean 'sandstone'"):
        typical_strength('sandstoen')
