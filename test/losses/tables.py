# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Benches for the tests of this folder."""
from pathlib import Path

from hst_drive.effects.oil import viscosity
from hst_drive.losses.table import Bench
import numpy as np

SHARED = Path(__file__).resolve().parents[3] / 'shared'


def bench_from(rows, drain=True):
    """Return the bench that rows of the generator mean."""
    cc, degc, torque, rpm, bar, flow, case = rows.T
    return Bench(cc * 1e-6 / (2 * np.pi), degc + 273.15, torque, rpm * np.pi / 30, bar * 1e5,
                 flow / 6e4, viscosity(degc + 273.15, 'ISO VG 46'), np.arange(len(cc)) + 2,
                 case / 6e4 if drain else None)
