# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From a diagnosis, or from names of effects, to the test that tells them apart."""
from __future__ import annotations

from collections.abc import Callable, Sequence
import math

from hst_drive.design.design import Design, design
from hst_drive.design.rivals import by_name, matched, Rivals, widened
from hst_drive.design.trials import limits, LONGEST
from hst_drive.diagnose.result import require_schema, UNIT_ALONE
from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.identify.model import Model
from hst_drive.rig import Rig

_MOST = 7       # explanations that a diagnosis left


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


def of_diagnosis(diagnosis: dict, source: str,
                 wanted: Sequence[str] | None = None) -> Rivals | None:
    """
    Return the rivals that a diagnosis left, None if it left none.

    Parameters
    ----------
    diagnosis : dict
        What ``diagnose --json`` wrote.
    source : str
        Its file, for messages.
    wanted : sequence of str, optional
        Tell these effects apart instead.

    Raises
    ------
    InputError
        If this is no diagnosis, or an effect is not known.

    """
    require_schema(diagnosis, source)
    try:
        channels = tuple(diagnosis['errors']['before'])
        factors = {entry['quantity']: math.log(entry['factor'])
                   for entry in diagnosis.get('calibration', ())}
        effects = {entry['id']: {key: float(value['value'])
                                 for key, value in entry['parameters'].items()}
                   for entry in diagnosis['effects']}
        groups = {entry['id']: tuple(name for name in entry.get('indistinguishable_from', ())
                                     if name != UNIT_ALONE)
                  for entry in diagnosis['effects']}
        fitted = [Model(dict(entry), factors)
                  for entry in (diagnosis.get('next_test') or {}).get('models', ())]
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{source}: has no readable 'effects' and 'errors'; write the diagnosis "
                         'again') from None
    strange = [name for name in (*effects, *(entry for group in groups.values()
                                             for entry in group)) if name not in catalogue()]
    if strange:
        raise InputError(f"{source}: effect '{strange[0]}' is not in the catalogue; see "
                         "'hst-drive effects'")
    best = Model(effects, factors)
    if wanted:
        return by_name(wanted, channels, best)
    sets = [tuple(effects)]
    for name, group in groups.items():
        sets += [tuple(entry for entry in effects if entry != name) + (rival,) for rival in group]
    if len(sets) < 2:
        return None
    known = {frozenset(model.effects): model for model in (*fitted, best)}
    sets = sets[:_MOST]
    return Rivals(tuple(sets), tuple(known.get(frozenset(entry)) for entry in sets), channels)
