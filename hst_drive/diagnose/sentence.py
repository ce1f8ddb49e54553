# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The sentence that a diagnosis begins with, and how its numbers are told."""
from __future__ import annotations

from math import exp, log
from typing import Collection, Mapping, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.result import Found, Step, UNIT_ALONE, Unknown
from hst_drive.effects import catalogue
from hst_drive.identify.conditions import Outside
from hst_drive.identify.evidence import DECIDED, Probability
from hst_drive.identify.judge import CLEAN_RATIO
from hst_drive.units import for_people

# Where something enters that no listed effect explains: what may be wrong there.
_CHECK = {
    'sensor': "that sensor's zero, span and time stamps",
    'flow': 'displacements, leakages and oil in the rig file, and the flow meter',
    'torque': 'efficiency and inertia in the rig file, and the torque sensor',
    'load': 'the loading unit in the rig file, the torque sensor, and what else loads the shaft',
    'pump_actuator': "the pump's curve and lag in the rig file, and its command's column"}


def sentence(verdict: str, effects: Sequence[Found], ladder: Sequence[Step],
             remaining: Unknown | None, hidden: Sequence[str] = (),
             limited: Sequence[str] = (), commissioned: bool = False,
             adopted: Sequence[str] = ()) -> str:
    """
    Return what is missing and how far the error falls with it, in words.

    ``hidden`` are the effects that the logs could not have shown, ``limited`` the quantities that
    sit at the limits of their tolerances in the unit without effects; ``commissioned`` says that
    the model is that of this machine as it was then, with the effects that are ``adopted``.
    """
    # A machine that was commissioned is known so well that its calibration takes most changes up.
    first = ladder[0 if commissioned and effects else 1].holdout
    last = ladder[-1].holdout
    signal = max(first, key=lambda name: first[name] - last[name]) if effects else \
        max(first, key=first.get, default='')
    if not signal:
        return 'There is nothing to judge.'
    title = CHANNELS[signal].title
    unit = [entry for entry in effects if UNIT_ALONE in entry.indistinguishable_from]
    sure = [entry for entry in effects if entry not in unit]
    lacks = ('; and ' if any(entry.indistinguishable_from for entry in sure) else ' and ').join(
        f'{entry.id} ({catalogue()[entry.id].title})' + (
            f", or {' or '.join(entry.indistinguishable_from)} in its place (which these logs do "
            'not rule out)' if entry.indistinguishable_from else '')
        for entry in sure if not entry.change)
    changed = ' '.join(_changed(entry) for entry in sure if entry.change)
    falls = (f'Held-out error of {title} falls from {times(first[signal])} to '
             f'{times(last[signal])} times the noise.')
    if verdict == 'none':
        return _nothing(first, signal, hidden, commissioned, adopted)
    if verdict in ('missing_effect', 'ambiguous'):
        new = '' if not lacks else f'Since it was commissioned the machine has got {lacks}.' \
            if commissioned else f'The model lacks {lacks}.'
        end = _or_the_unit(unit[0], limited, commissioned, bool(sure)) if unit else \
            f'{falls}{_stays(last)}'
        return ' '.join(filter(None, [changed, new, end]))
    place = ''
    if remaining:
        on = f', depending on {", ".join(remaining.depends_on)}' if remaining.depends_on else ''
        place = f' It enters at the {remaining.enters.replace("_", " ")}{on}.' + (
            f' First to check: {_CHECK[remaining.enters]}.' if remaining.enters in _CHECK else '')
    start = f'The model lacks {lacks}, and something' if lacks else 'The model lacks something'
    return ' '.join(filter(None, [changed, f'{start} that no listed effect explains.{place} '
                                  + (falls if effects else '')]))


def _changed(entry: Found) -> str:
    """Return a sentence for an effect that the rig has adopted."""
    others = ' or '.join(entry.indistinguishable_from)
    rivals = f' (or there is {others}, which these logs do not rule out)' if others else ''
    return f'{entry.id} ({catalogue()[entry.id].title}), adopted before, {_did(entry)}{rivals}.'


def _did(entry: Found) -> str:
    """Say what an effect that the rig has adopted did since."""
    size, value = next(iter(entry.parameters.items()))
    before, now = (f'{for_people(number, value.unit)[0]:.4g}'
                   for number in (entry.adopted[size], value.value))
    unit = for_people(1.0, value.unit)[1]
    unit = f' {unit}' * (unit != '1')
    return f'has {entry.change} from {before} to {now}{unit}' if entry.change != 'gone' else \
        f'is gone, as after a repair ({size} was {before}{unit})'


def _nothing(ratios: Mapping[str, float], worst: str, hidden: Sequence[str],
             commissioned: bool, adopted: Sequence[str]) -> str:
    """Say of what nothing is missing: of what these logs could have shown."""
    missing, known = ('has changed since the machine was commissioned', 'what is known of it') \
        if commissioned else ('is missing', 'the tolerances')
    untold = f', but not {listed(hidden, "or")}' if hidden else ''
    beside = f'; {listed(adopted)}, adopted before, ' + (
        'stay as they were' if len(adopted) > 1 else 'stays as it was') if adopted else ''
    clean = ratios[worst] <= CLEAN_RATIO
    return (f'Nothing {missing}, as far as these logs show{beside}. They show the balances of '
            f'{listed([CHANNELS[name].title for name in ratios])}, and effects from the sizes '
            f'below on{untold}. The model, calibrated within {known}, explains them'
            + (f' down to the noise (worst held-out: {CHANNELS[worst].title}, '
               f'{ratios[worst]:.2f} times).' if clean else f'.{_stays(ratios)}'))


def _or_the_unit(found: Found, limited: Sequence[str], commissioned: bool,
                 beside: bool) -> str:
    """Say that the unit is at its limits, or an effect is missing, ``beside`` others or alone."""
    others = [name for name in found.indistinguishable_from if name != UNIT_ALONE]
    names = ' or '.join([f'{found.id} ({catalogue()[found.id].title})', *others])
    unit = 'what it was when commissioned as one day is off another' if commissioned else \
        'its datasheet as its tolerances let it'
    cause = f'{names}, adopted before, {_did(found)}' if found.change else \
        f'the model lacks {"also " * beside}{names}'
    return (f'Either this unit is as far off {unit} ({listed(limited)}), or {cause}, which is far '
            'likelier by these tolerances: both explain these logs down to the noise.')


def stated(found: Probability) -> str:
    """Tell how probable explanations are, and where such numbers are not known to hold."""
    known = '' if found.calibrated else ', not calibrated for such logs'
    return f'probability{known}: {odds(found)}'


def odds(found: Probability) -> str:
    """Tell how probable explanations are, the most probable first, those below 1 % together."""
    shares = [(' + '.join(names), share) for names, share in found.sets]
    shares += [('none', found.none), ('unknown', found.unknown)]
    told = sorted((entry for entry in shares if entry[1] >= 0.01), key=lambda item: -item[1])
    rest = sum(share for _, share in shares if share < 0.01)
    return ', '.join(f'{what} {share:.2f}' if share < 0.995 else f'{what} above 0.99'
                     for what, share in (*told, *([('all others', rest)] if rest >= 0.01 else ())))


def nearly(found: Probability, named: Collection[tuple[str, ...]]) -> str:
    """Tell what else than the sets named is as probable, by odds hardly worth a mention, or ''."""
    shares = [(f'{listed(names)} {"together are" if len(names) > 1 else "alone is"}', share,
               names in named) for names, share in found.sets]
    shares += [('that nothing is missing is', found.none, () in named),
               ('something that is not listed is', found.unknown, not named)]
    what, most, _ = max((entry for entry in shares if not entry[2]), key=lambda item: item[1])
    said = sum(share for _, share, own in shares if own)
    return f'But {what} nearly as probable.' if DECIDED * most > said > 0.0 else ''


def listed(names: Sequence[str], last: str = 'and') -> str:
    """Write names with commas and an 'and'."""
    return f' {last} '.join(filter(None, [', '.join(names[:-1]), *names[-1:]]))


def beyond(unseen: Sequence[Outside], untold: bool, power: float | None) -> str:
    """
    Tell what the machine was not commissioned for, or ``untold`` oil; '' if nothing.

    ``power`` is that of the viscosity which leakages follow, where these logs are first to tell.
    """
    said = [] if not unseen else [
        'These logs go beyond what the machine was commissioned for: '
        f'{listed([entry.told for entry in unseen])}. What shows only there may have been so '
        'from the start.']
    if untold:
        said.append('The temperature of the oil is not known, now and then: leaks and friction '
                    'of a healthy machine change with it, too.')
    if power is not None:
        said.append(f'Its leakages follow the viscosity of the oil by the power {power:.2f}. No '
                    'log from which it was commissioned had told: add these to them.')
    return ' '.join(said)


def taken(inertia: float) -> str:
    """Tell the inertia (kg.m^2) that was taken since the rig file gives none; '' if none was."""
    return inertia and (f'The rig file gives no inertia: {inertia:.2g} kg.m^2 was found in these '
                        'logs, and adopt writes it there.') or ''


def limits(verdict: str, quantities: Sequence[str], commissioned: bool = False) -> str:
    """
    Tell which of the unit's quantities sit at their limits; '' if none does.

    ``commissioned``: these limits are a machine's own.
    """
    if not quantities:
        return ''
    if len(quantities) == 1:
        sit, like = f'{quantities[0]} sits at the limit of its tolerance', 'it'
    else:
        sit, like = f'{listed(quantities)} sit at the limits of their tolerances', 'them'
    if commissioned and 'motor.displacement' in quantities:
        sit += (' (no wear changes motor.displacement: are these logs of the machine that was '
                'commissioned?)')
    if verdict == 'unknown':
        return f'Of this unit, {sit}.'
    if verdict != 'none':
        return f'But {sit}: an effect that acts like {like} may be missing as well.'
    return f'But {sit}: an effect that acts like {like} may be missing; these logs cannot tell.'


def times(ratio: float) -> str:
    """Write a noise ratio; near the noise with two digits, where a tenth would hide the fall."""
    return f'{ratio:.1f}' if ratio >= 2 else f'{ratio:.2f}'


def less(value: float) -> str:
    """Write how much less probable something is, of its log odds."""
    return 'as' if value > -log(DECIDED) else (
        f'{exp(-value):.0f} times less' if value > -log(1e6) else 'more than a million times less')


def _stays(last: Mapping[str, float]) -> str:
    """Say what stays well above the noise though it counts as explained."""
    worst = max(last, key=last.get)
    return '' if last[worst] <= CLEAN_RATIO else (
        f' {CHANNELS[worst].title.capitalize()} stays at {times(last[worst])} times the noise, '
        'no more than chance and formulas, off by a tenth of what they do, may leave.')
