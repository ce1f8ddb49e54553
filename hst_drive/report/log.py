# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording as text."""
from __future__ import annotations

from hst_drive.channels import CHANNELS
from hst_drive.measure.run import Run
from hst_drive.report.terminal import table
from hst_drive.units import from_si
import numpy as np


def text(run: Run) -> str:
    """Return what a recording holds."""
    rows = []
    for name, values in run.channels.items():
        unit = CHANNELS[name].display
        shown = from_si(values, unit)
        rows.append([name, unit, float(np.nanmin(shown)), float(np.nanmean(shown)),
                     float(np.nanmax(shown)), int(np.count_nonzero(~np.isfinite(values)))])
    lines = [f'{run.name}: {len(run)} samples, {run.time[-1] - run.time[0]:.4g} s, every '
             f'{1e3 * run.sample_time:.3g} ms', '',
             table(['channel', 'unit', 'least', 'mean', 'most', 'missing'], rows)]
    return '\n'.join([*lines, *(['', *run.notes] if run.notes else [])])
