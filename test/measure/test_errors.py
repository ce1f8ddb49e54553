# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Error measures against values by hand."""
import math

from hst_drive.measure.errors import russell, summarise
import numpy as np
import pytest

WAVE = np.sin(np.linspace(0, 20 * np.pi, 20001)[:-1])


def errors(model, measured):
    """Return Russell's errors of two signals."""
    return russell(model @ model, measured @ measured, model @ measured)


def test_equal_signals_have_no_error():
    found = errors(WAVE, WAVE)
    assert found == pytest.approx((0, 0, 0), abs=1e-7)


@pytest.mark.parametrize('factor', [0.5, 1.1, 2.0])
def test_a_scaled_signal_has_a_magnitude_error_alone(factor):
    """With f = k*g, A = k^2*B and sqrt(A*B) = k*B, so that m = k - 1/k."""
    relative = factor - 1 / factor
    want = math.copysign(math.log10(1 + abs(relative)), relative)
    found = errors(factor * WAVE, WAVE)
    assert found.magnitude == pytest.approx(want)
    assert found.phase == pytest.approx(0, abs=1e-7)
    assert found.comprehensive == pytest.approx(math.sqrt(math.pi / 4) * abs(want))


@pytest.mark.parametrize('shift', [0.1, 1.0, 3.0])
def test_a_shifted_wave_has_its_angle_over_pi_as_phase_error(shift):
    moved = np.sin(np.linspace(0, 20 * np.pi, 20001)[:-1] - shift)
    found = errors(moved, WAVE)
    assert found.phase == pytest.approx(shift / math.pi, rel=1e-6)
    assert found.magnitude == pytest.approx(0, abs=1e-9)


def test_by_hand():
    """With f = (3, 4), g = (4, 3): A = B = 25, C = 24; P = arccos(0.96)/pi."""
    phase = math.acos(0.96) / math.pi
    assert errors(np.array([3.0, 4.0]), np.array([4.0, 3.0])) == pytest.approx(
        (0, phase, math.sqrt(math.pi / 4) * phase))
    # f = (2, 0), g = (1, 1): A = 4, B = 2, C = 2.
    magnitude = math.log10(1 + 2 / math.sqrt(8))
    phase = math.acos(2 / math.sqrt(8)) / math.pi
    assert errors(np.array([2.0, 0.0]), np.array([1.0, 1.0])) == pytest.approx(
        (magnitude, phase, math.sqrt(math.pi / 4 * (magnitude**2 + phase**2))))


def test_it_hides_an_error_on_a_large_mean():
    assert errors(WAVE + 100, -WAVE + 100).comprehensive < 0.005


def test_zero_signals():
    assert all(map(math.isnan, errors(np.zeros(5), np.ones(5))))


def test_summary_by_hand():
    measured = np.array([1.0, 2.0, 3.0, 4.0, np.nan, 5.0])
    model = np.array([1.5, 2.0, 3.0, 3.0, 7.0, np.nan])
    found = summarise(model, measured, 'Pa', 0.1, 0.2)
    rmse = math.sqrt((0.25 + 1.0) / 4)
    assert (found.unit, found.samples) == ('Pa', 4)
    assert found.rmse == pytest.approx(rmse)
    assert found.bias == pytest.approx(-0.125)
    assert found.max_abs == 1.0
    assert found.noise_ratio == pytest.approx(rmse / 0.2)
    assert found.fit == pytest.approx(1 - rmse / math.sqrt(1.25))
    assert found.russell == errors(model[:4], measured[:4])


def test_summary_of_nothing():
    found = summarise(np.full(3, np.nan), np.ones(3), 'Pa', 0.1, 0.2)
    assert found.samples == 0 and math.isnan(found.rmse) and math.isnan(found.noise_ratio)
    assert math.isinf(summarise(np.ones(3), np.zeros(3), 'Pa', 0.0, 0.0).noise_ratio)
