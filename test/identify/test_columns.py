# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a sample counts, by how fast its signal moves."""
from types import SimpleNamespace

from hst_drive.identify.columns import columns
from hst_drive.identify.phases import strongest_orders
from hst_drive.measure.run import Run
import numpy as np
import pytest

TIME = np.arange(6000) / 100.0


def column_of(measured, missing):
    """Return the column of a signal that lacks some rows."""
    run = Run('log', TIME, {'motor_speed': np.where(missing, np.nan, measured)}, 'log.csv')
    replay = SimpleNamespace(
        run=run, signals=('motor_speed',), stamp_std=1e-3, command_time_std=0.0, extra_std={},
        counted=lambda name: np.isfinite(run[name]), inputs={'motor_angle': 2.0 * TIME})
    return replay, columns([replay], [{'motor_speed': 0.1}], [np.ones(len(TIME))])[0]


def test_rows_beside_one_that_is_missing_count_as_they_do_without_it():
    missing = np.arange(len(TIME)) == 3000
    measured = 10.0 + np.sin(TIME)
    whole, gap = (column_of(measured, rows)[1] for rows in (np.zeros_like(missing), missing))
    assert gap.weight == pytest.approx(whole.weight, rel=1e-3)
    assert 3000 not in gap.fit and 3000 in whole.fit


def test_a_signal_that_no_row_has_counts_nowhere():
    _, column = column_of(TIME, np.ones(len(TIME), dtype=bool))
    assert not len(column.fit) and not len(column.judge)


@pytest.mark.parametrize('count', [0, 20])
def test_rows_that_are_missing_swing_with_no_order(count):
    """A swing nine times a turn of 2 rad/s stays that; what no row shows is 1000 floors off."""
    missing = np.isin(np.arange(len(TIME)), np.random.default_rng(1).integers(0, 6000, count))
    replay, column = column_of(10.0 + 0.0 * TIME, missing)
    error = np.where(missing, 1e3, 0.7 * np.cos(9 * 2.0 * TIME))
    campaign = SimpleNamespace(columns=[column], replays=[replay])
    assert strongest_orders(campaign, [error]) == [9]
