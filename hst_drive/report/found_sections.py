# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sections of the page on a diagnosis (the JSON of the verb diagnose): what is missing."""
from __future__ import annotations

import re

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.result import not_known, UNIT_ALONE
from hst_drive.diagnose.sentence import stated
from hst_drive.effects import catalogue, SLOTS
from hst_drive.identify.evidence import Probability
from hst_drive.report.diagnosis import GAUGE_CLASS
from hst_drive.report.markup import element, join, Markup, note, number, plot, section, table
from hst_drive.units import for_people

_VERDICTS = {'none': 'nothing is missing', 'missing_effect': 'an effect is missing',
             'ambiguous': 'ambiguous', 'unknown': 'something unknown is missing'}
_SINCE = {'none': 'nothing has changed', 'missing_effect': 'something has changed',
          'ambiguous': 'something has changed', 'unknown': 'something unknown has changed'}
_SHOWN = 12     # candidates of the ranking


def verdict(diagnosis: dict) -> Markup:
    """Return the verdict as a badge."""
    kind = str(diagnosis.get('verdict'))
    words = _SINCE if diagnosis.get('since') else _VERDICTS
    return element('span', words.get(kind, kind), class_=f'badge {kind}')


def ladder_section(diagnosis: dict) -> Markup:
    """Return the fall of the error, as a chart and as numbers."""
    steps = diagnosis['ladder']
    signals = list(steps[0]['holdout'])
    rows = [[('+ ' if place > 1 else '') + step['added'],
             *(f'{number(step["holdout"].get(name))} ({number(step["training"].get(name))})'
               for name in signals)] for place, step in enumerate(steps)]
    return section(
        'ladder', 'How far the error falls', plot('ladder-plot', 'error after each step'),
        table(['model', *(_title(name) for name in signals)], rows,
              'Error over the noise floor: held-out data (training data in brackets)'),
        note('Filled marks: held-out data, which no fit has seen. Hollow marks: training data. '
             'The line at 1 is what a perfect model would show. As diagnose judges: without the '
             'worst blocks, single events, which the table of errors below counts.'))


def _title(name: str) -> str:
    return CHANNELS[name].title if name in CHANNELS else name


def found_section(diagnosis: dict) -> Markup:
    """Return the effects that are missing, the unknown, and the test that tells more."""
    parts: list[object] = [effect_card(entry) for entry in diagnosis['effects']]
    if given := diagnosis.get('probability'):
        found = Probability(given['none'], given['unknown'], tuple(
            (tuple(entry['effects']), entry['probability']) for entry in given['sets']),
            given.get('calibrated', False))
        parts.insert(0, element('p', f'P{stated(found)[1:]}.', class_='probability'))
    if diagnosis.get('unknown'):
        parts.append(_unknown(diagnosis['unknown']))
    if diagnosis.get('next_test'):
        test = diagnosis['next_test']
        parts.append(element(
            'div', element('h3', f'To tell {", ".join(test["separates"])} apart'),
            element('p', test['what']), class_='card next'))
    if not diagnosis['effects'] and not diagnosis.get('unknown'):
        parts.append(element('p', 'The model as it stands, calibrated within the tolerances of '
                             f'{_start(diagnosis)}, explains these logs down to the noise.'))
    return section('missing', 'What has changed' if diagnosis.get('since') else 'What is missing',
                   *parts)


def _start(diagnosis: dict) -> str:
    """Return what a unit was calibrated from."""
    return 'the commissioned unit' if diagnosis.get('since') else 'the datasheet'


def effect_card(found: dict) -> Markup:
    """Return a card: equation, meaning, size with interval, source."""
    effect = catalogue(everything=True).get(found['id'])
    if effect is None:
        return element('div', element('h3', found['id']), element(
            'p', 'This effect comes from a package that is not installed here.'), class_='card')
    rows = []
    for parameter in effect.parameters:
        if parameter.name not in found['parameters']:
            continue
        value = found['parameters'][parameter.name]
        (size, unit), (low, _), (high, _) = (
            for_people(value[key], value['unit']) for key in ('value', 'low', 'high'))
        told = not_known(value['low'], value['high'], parameter)
        rows.append([parameter.name, number(size, 4),
                     told or f'{number(low, 4)} to {number(high, 4)}',
                     '' if unit == '1' else unit, parameter.meaning])
    removed = found.get('error_removed')
    rivals = ['a unit that is further off' if entry == UNIT_ALONE else entry
              for entry in found.get('indistinguishable_from') or ()]
    return element(
        'div', element('h3', effect.id.replace('_', ' '), ' ',
                       element('small', f'enters: {effect.enters}')),
        element('p', effect.title[:1].upper() + effect.title[1:] + '.'),
        element('p', equation(effect.equation), class_='equation'),
        table(['parameter', 'size', '95 % interval', 'unit', 'meaning'], rows,
              f'Size of {effect.id}'),
        element('p', f'It removes {100 * removed:.0f} % of the held-out error above the noise.')
        if removed else '',
        element('p', 'These logs do not rule out ', element('strong', ' or '.join(rivals)),
                ' in its place.', class_='warning') if rivals else '',
        element('p', GAUGE_CLASS) if effect.zero_of else '',
        element('p', element('b', 'What the data look like: '), effect.telltale),
        element('p', element('b', 'Term: '), SLOTS[effect.slot].meaning),
        element('p', element('b', 'Source: '), effect.source, class_='source'),
        class_='card effect')


def equation(formula: str) -> Markup:
    """Return an equation of the catalogue with subscripts and dots."""
    found = str(element('span', formula)).replace('*', '·')
    return Markup(re.sub(r'\b([A-Za-z])_([A-Za-z0-9]+)\b', r'<i>\1</i><sub>\2</sub>', found))


def _unknown(unknown: dict) -> Markup:
    formula = unknown.get('formula')
    depends = ', '.join(unknown['depends_on']) or 'nothing that was recorded'
    parts: list[object] = [
        element('h3', 'Something that the catalogue does not hold'),
        element('p', f'It enters at the {unknown["enters"].replace("_", " ")}, is seen in '
                f'{_title(unknown["signal"])}, and depends on {depends}.')]
    if unknown.get('expression'):
        parts.append(element('p', unknown['expression'], class_='equation'))
    if unknown.get('terms'):
        parts.append(element('p', f'The formula explains {100 * unknown["explained"]:.0f} % of '
                             'what is left there.'))
    if formula:
        falls = ', '.join(f'{_title(name)} {number(formula["before"][name])} to '
                          f'{number(formula["after"][name])}' for name in formula['before'])
        parts.append(element('p', f'As a part of the model (adopt --formula) it moves the '
                             f'held-out error over the floor: {falls}.'))
    return element('div', *parts, class_='card unknown')


def rivals_section(diagnosis: dict) -> Markup:
    """Return the rivals and why they lost, and the ranking."""
    rivals = diagnosis.get('rivals') or {}
    parts: list[object] = []
    if rivals:
        parts.append(element('dl', join(
            element('dt', name) + element('dd', f'{reason}.') for name, reason in rivals.items())))
    ranking = diagnosis.get('ranking') or []
    if ranking:
        parts.append(element('details', element('summary', 'Every candidate alone'), table(
            ['effect', 'held-out error over floor', 'evidence (ln likelihood ratio)'],
            [[entry['id'], entry['holdout_noise_ratio'], entry['evidence']]
             for entry in ranking[:_SHOWN]], 'The best candidates, each alone')))
    return section('rivals', 'Rivals, and why they lost', *parts) if parts else Markup('')


def _amount(entry: dict) -> tuple[str, str]:
    """Return a value of a diagnosis as people read it, and its unit."""
    size, unit = for_people(entry['value'], entry['unit'])
    return number(size), '' if unit == '1' else unit


def unit_section(diagnosis: dict) -> Markup:
    """Return what calibration moved, what would have been seen, and what could not."""
    moved = [entry for entry in diagnosis['calibration'] if abs(entry['sigmas']) >= 0.1]
    parts: list[object] = []
    if moved:
        parts.append(table(['quantity', f'factor on {_start(diagnosis)}', 'tolerances',
                            'remark'], [
            [entry['quantity'], f'{entry["factor"]:.4f}', f'{entry["sigmas"]:+.1f}',
             'at its limit' if entry['at_limit'] else ''] for entry in moved],
            f'What calibration moved, within three tolerances of {_start(diagnosis)}'))
    else:
        parts.append(element('p', 'Calibration moved nothing by a tenth of a tolerance.'))
    for key, head, title in (
            ('sensor_zeros', 'reads beyond',
             'Zeros of sensors, in one sigma of what they may be off'),
            ('sensor_delays', 'reads late by',
             'Delays of sensors, in one sigma of how late they may be')):
        off = [entry for entry in diagnosis.get(key) or () if abs(entry['sigmas']) >= 0.5]
        if off:
            parts.append(table(['sensor', head, '', 'sigma'], [
                [entry['channel'], *_amount(entry), f'{entry["sigmas"]:+.1f}'] for entry in off],
                title))
    smallest = diagnosis.get('smallest_visible') or {}
    if smallest:
        rows = []
        for name, entry in sorted(smallest.items()):
            if name in catalogue():
                rows.append([name, catalogue()[name].size.name, *_amount(entry)])
        parts.append(element('details', element(
            'summary', 'The smallest size of each other effect that these logs would have shown'),
            table(['effect', 'parameter', 'size', 'unit'], rows, 'Smallest visible sizes')))
    hidden = diagnosis.get('not_observable_because') or {}
    if hidden:
        parts.append(element('details', element('summary', 'Not observable in these logs'),
                             element('dl', join(element('dt', name) + element('dd', reason)
                                                for name, reason in hidden.items()))))
    return section('unit', f'This unit against {_start(diagnosis)}', *parts)
