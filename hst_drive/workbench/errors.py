# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The errors of a model as the page shows them: those of compare, and those of diagnose."""
from __future__ import annotations

from typing import Sequence

from hst_drive.channels import CHANNELS
from hst_drive.measure.compare import LogComparison, pooled as over_all
from hst_drive.units import difference_from_si


def pooled(logs: Sequence[LogComparison]) -> dict[str, dict]:
    """
    Return rmse, bias and noise ratio by signal over all logs, in the units of the field.

    The numbers of ``measure.compare.compare`` with the same logs.
    """
    return {name: {'ratio': entry.noise_ratio, **{
        key: difference_from_si(getattr(entry, key), CHANNELS[name].display)
        for key in ('rmse', 'floor', 'bias')}} for name, entry in over_all(logs).items()}
