# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The sentence that a diagnosis begins with, and how its numbers are told."""
from __future__ import annotations

from typing import Mapping, Sequence

from hst_drive.diagnose.judge import CLEAN_FITTED
from hst_drive.diagnose.result import Found, Step, Unknown
from hst_drive.effects import catalogue
from hst_drive.measure.run import CHANNELS


def sentence(verdict: str, effects: Sequence[Found], ladder: Sequence[Step],
             remaining: Unknown | None) -> str:
    """Return what is missing and how far the error falls with it, in words."""
    first, last = ladder[1].holdout, ladder[-1].holdout
    signal = max(first, key=lambda name: first[name] - last[name]) if effects else \
        max(first, key=first.get, default='')
    if not signal:
        return 'There is nothing to judge.'
    title = CHANNELS[signal].title
    lacks = ('; and ' if any(entry.indistinguishable_from for entry in effects) else ' and ').join(
        f'{entry.id} ({catalogue()[entry.id].title})' + (
            f", or {' or '.join(entry.indistinguishable_from)} in its place (these logs cannot "
            'tell which)' if entry.indistinguishable_from else '') for entry in effects)
    falls = (f'Held-out error of {title} falls from {times(first[signal])} to '
             f'{times(last[signal])} times the noise.')
    if verdict == 'none':
        return ('Nothing is missing: the model, calibrated within the tolerances, explains these '
                f'logs down to the noise (worst held-out: {title}, {first[signal]:.2f} times).')
    if verdict in ('missing_effect', 'ambiguous'):
        return f'The model lacks {lacks}. {falls}{_stays(last)}'
    place = ''
    if remaining:
        on = f', depending on {", ".join(remaining.depends_on)}' if remaining.depends_on else ''
        place = f' It enters at the {remaining.enters.replace("_", " ")}{on}.'
    start = f'The model lacks {lacks}, and something' if effects else 'The model lacks something'
    return f'{start} that no listed effect explains.{place} ' + (falls if effects else '')


def limits(verdict: str, quantities: Sequence[str], likely: str = '') -> str:
    """
    Tell which of the unit's quantities sit at their limits; '' if none does.

    ``likely`` is an effect with which none would.
    """
    if not quantities:
        return ''
    if len(quantities) == 1:
        sit, like = f'{quantities[0]} sits at the limit of its tolerance', 'it'
    else:
        sit, like = (f'{", ".join(quantities[:-1])} and {quantities[-1]} sit at the limits of '
                     'their tolerances'), 'them'
    if verdict == 'unknown':
        return f'Of the unit {sit}.'
    if verdict != 'none':
        return f'But {sit}: what acts like {like} may be missing as well.'
    first = f', {likely} first of all' if likely else ''
    return f'But {sit}: what acts like {like} may be missing{first}; these logs cannot tell.'


def times(ratio: float) -> str:
    """Write a noise ratio; near the noise with two digits, where a tenth would hide the fall."""
    return f'{ratio:.1f}' if ratio >= 2 else f'{ratio:.2f}'


def _stays(last: Mapping[str, float]) -> str:
    """Say what stays well above the noise though it counts as explained."""
    worst = max(last, key=last.get)
    return '' if last[worst] <= CLEAN_FITTED else (
        f' {CHANNELS[worst].title.capitalize()} stays at {times(last[worst])} times: no more than '
        'chance and other formulas of it make.')
