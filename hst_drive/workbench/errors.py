# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The errors of a model as the page shows them: those of compare, and those of diagnose."""
from __future__ import annotations

import math
from typing import Sequence

from hst_drive.measure.compare import LogComparison
from hst_drive.measure.run import CHANNELS
from hst_drive.units import difference_from_si
import numpy as np


def pooled(logs: Sequence[LogComparison]) -> dict[str, dict]:
    """
    Return rmse, bias and noise ratio by signal over all logs, in the units of the field.

    The numbers of ``measure.compare.compare`` with the same logs.
    """
    found = {}
    for name in dict.fromkeys(name for log in logs for name in log.signals):
        having = [log for log in logs if name in log.signals]
        error = np.concatenate([log.model[name] - log.measured(name) for log in having])
        error = error[np.isfinite(error)]
        weights = [max(log.signals[name].samples, 1) for log in having]
        floor = math.sqrt(sum(weight * log.signals[name].floor**2
                              for weight, log in zip(weights, having)) / sum(weights))
        rmse = math.sqrt(float(np.mean(error**2))) if len(error) else math.nan
        unit = CHANNELS[name].display
        found[name] = {
            'ratio': rmse / floor if floor > 0 else math.inf,
            'rmse': difference_from_si(rmse, unit), 'floor': difference_from_si(floor, unit),
            'bias': difference_from_si(float(error.mean()), unit) if len(error) else math.nan}
    return found
