# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From a diagnosis, or from names of effects, to the test that tells them apart."""
from __future__ import annotations

from collections.abc import Callable, Sequence

from hst_drive.design.design import Design, design
from hst_drive.design.rivals import by_name, matched, of_diagnosis, widened
from hst_drive.design.trials import limits, LONGEST
from hst_drive.errors import InputError
from hst_drive.rig import Rig


def next_test(rig: Rig, diagnosis: dict | None = None, source: str = 'diagnosis',
              effects: Sequence[str] | None = None, *, duration: float = LONGEST,
              closed_loop: bool = False,
              progress: Callable[[str], None] = lambda text: None) -> Design | None:
    """
    Return the test that separates what a diagnosis could not; None if it left nothing open.

    Parameters
    ----------
    rig : Rig
        The baseline that was diagnosed.
    diagnosis : dict, optional
        What ``diagnose --json`` writes; without it ``effects`` are told apart.
    source : str
        Its file, for messages.
    effects : sequence of str, optional
        Tell these apart.
    duration, closed_loop, progress
        As for ``design``.

    Raises
    ------
    InputError
        If the diagnosis is of another rig, or ``design`` refuses.

    """
    if diagnosis is None:
        rivals = by_name(effects, rig.sensors)
    else:
        rivals = of_diagnosis(diagnosis, source, effects)
        if rivals is not None and diagnosis.get('rig_digest') not in (None, rig.digest):
            raise InputError(f'{rig.source or rig.name}: is not the rig that was diagnosed '
                             f"({diagnosis.get('rig')}); give that one with --rig")
    if rivals is None:
        return None
    limits(rig)
    models = matched(rig, rivals)
    likely = len(models)
    if not rivals.asked:
        models = widened(rig, models, rivals.channels)
    return design(rig, models, rivals.channels, duration=duration, closed_loop=closed_loop,
                  likely=likely, progress=progress)
