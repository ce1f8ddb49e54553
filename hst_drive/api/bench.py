# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``losses`` does: a table of motors or of transmissions, whichever it is."""
from __future__ import annotations

from typing import Any

from hst_drive.api import given
from hst_drive.api.results import Losses
from hst_drive.bag.arrays import is_table
from hst_drive.bag.bench_table import points_of, read_points
from hst_drive.losses.resistances import identify
from hst_drive.losses.study import LEAST_ROWS
from hst_drive.losses.study import study as fitted
from hst_drive.losses.table import bench_of
from hst_drive.report import losses as told
from hst_drive.report.transmissions import is_transmissions, study_transmissions
from hst_drive.rig.oils import oil_of


def study(table: Any, channels: Any, oil: str) -> Losses:
    """Return what a bench table says; fewer rows than a curve needs give the resistances."""
    if is_table(table):
        points = points_of(table, channels)
    else:
        points = read_points(given.path(table, 'table', given.TABLE), channels)
    if is_transmissions(points):
        return Losses(*study_transmissions(points), points.notes)
    bench = bench_of(points.columns, points.headers, points.lines, points.constants,
                     points.source, oil_of(oil))
    found, done = identify(bench), fitted(bench) if len(bench) >= LEAST_ROWS else None
    content = told.as_json(bench, oil, found, done)
    return Losses(content, told.shown(content, bench, found, done), points.notes + bench.notes)
