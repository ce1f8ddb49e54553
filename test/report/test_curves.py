# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Thinned curves: short, and no peak is lost."""
import base64

from hst_drive.report.curves import pack, thin, thin_time
import numpy as np
import pytest


@pytest.mark.parametrize('samples', [10, 1999, 2000, 2001, 360_000, 360_007])
def test_peaks_stay(samples):
    random = np.random.default_rng(1)
    values = random.standard_normal(samples)
    places = random.choice(samples, 5, replace=False)
    values[places] = [50, -60, 70, -80, 90]
    time = np.arange(samples) * 0.01
    short, when = thin(values, 2000), thin_time(time, 2000)
    assert len(short) == len(when) <= max(2000, 2)
    assert set(values[places]) <= set(short)
    assert (np.diff(when) >= 0).all() and when[0] == 0 and when[-1] <= time[-1]
    # Each peak stands within a bunch of where it was.
    bunch = max(2 * samples // 2000, 1) * 0.01
    for place in places:
        shown = when[np.flatnonzero(short == values[place])[0]]
        assert abs(shown - time[place]) <= bunch + 1e-9


def test_gaps_stay_gaps():
    values = np.ones(10_000)
    values[4000:6000] = np.nan
    short, when = thin(values, 1000), thin_time(np.arange(10_000) * 1.0, 1000)
    inside = (when > 4050) & (when < 5950)
    assert inside.sum() > 100
    assert np.isnan(short[inside]).all() and np.isfinite(short[~inside]).sum() > 700


def test_a_short_curve_stays_as_it_is():
    values = np.array([1.0, np.nan, 3.0])
    assert np.array_equal(thin(values, 100), values, equal_nan=True)
    assert np.array_equal(thin_time(values, 100), values, equal_nan=True)


def test_packed_numbers_are_four_byte_floats():
    raw = base64.b64decode(pack(np.array([1.0, -2.5])))
    assert raw == b'\x00\x00\x80\x3f\x00\x00\x20\xc0'
