# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as text; ``hst_drive.diagnose.result`` has its JSON."""
from __future__ import annotations

from hst_drive.diagnose.result import Diagnosis, not_known, Unknown
from hst_drive.diagnose.sentence import stated
from hst_drive.effects import catalogue
from hst_drive.report.terminal import MISSING, size, table

GAUGE_CLASS = ('If a gauge of its class may be so far off, say so in the rig file (zero_std_bar '
               'of the sensor).')


def text(result: Diagnosis, short: bool = False) -> str:
    """Return the diagnosis for a terminal; the short form stops after what was found."""
    lines = [result.sentence.strip(), '', stated(result.probability), '']
    if result.effects:
        lines += [_effects(result), '']
    lines += ['error over the noise floor, held-out data (training data in brackets):',
              _ladder(result)]
    if result.unknown and result.unknown.expression:
        unknown = result.unknown
        lines += ['', f'the unknown enters at: {unknown.enters.replace("_", " ")}, seen in '
                  f'{unknown.signal}', *_described(unknown)]
    if short:
        return '\n'.join(lines)
    if result.rivals:
        lines += ['', 'the next best effects, each alone, and why they are not the answer:',
                  *(f'  {name}: {reason}' for name, reason in result.rivals.items())]
    if result.next_test:
        lines += ['', f'to tell {", ".join(result.next_test.separates)} apart: '
                  f'{result.next_test.what}']
    lines += [line for entry in result.effects if catalogue()[entry.id].zero_of
              for line in ('', f'{entry.id}: {GAUGE_CLASS}')]
    moved = [entry for entry in result.calibration if abs(entry.sigmas) >= 0.5]
    if moved:
        against = 'what it was when commissioned' if result.since else 'its datasheet'
        oil = ', from what the oil of these logs lets expect' if result.since else ''
        lines += ['', f'this unit against {against} (half a tolerance or more{oil}):',
                  _calibration(moved)]
    for title, head, found in (
            ('zeros of sensors (off', 'reads beyond', result.zeros),
            ('delays of sensors (late, or early,', 'reads late by', result.delays)):
        off = [entry for entry in found if abs(entry.sigmas) >= 0.5]
        if off:
            lines += ['', f'{title} by half of what they may be, one sigma, or more):',
                      _sensors(off, head)]
    same = [entry.quantity for entry in result.calibration if entry not in moved]
    if result.since and same:
        beside = ', beside what was found' if result.effects else ''
        lines += ['', f'the same as then{beside}, as far as these logs show: '
                  f'{", ".join(sorted(same))}']
    if result.smallest and result.verdict in ('none', 'missing_effect', 'ambiguous'):
        lines += ['', 'the smallest size of each other effect that these logs would have shown:',
                  _smallest(result)]
    if result.not_observable:
        lines += ['', 'not observable in these logs:',
                  *(f'  {name}: {reason}' for name, reason in result.not_observable.items())]
    return '\n'.join(lines)


def _effects(result: Diagnosis) -> str:
    rows = []
    for entry in result.effects:
        parameters = [parameter for parameter in catalogue()[entry.id].parameters
                      if parameter.name in entry.parameters]
        for place, parameter in enumerate(parameters):
            value = entry.parameters[parameter.name]
            (middle, unit), (low, _), (high, _) = (size(each, value.unit) for each in value[:3])
            rows.append([entry.id if place == 0 else '', parameter.name, middle,
                         not_known(value.low, value.high, parameter) or f'{low} to {high}', unit,
                         '' if place else f'{100 * entry.error_removed:.0f} %'
                         if entry.error_removed else MISSING])
    return table(['effect', 'parameter', 'value', '95 % interval', 'unit', 'error removed'], rows)


def _ladder(result: Diagnosis) -> str:
    signals = list(result.ladder[0].holdout)
    rows = [[('+ ' if place > 1 else '') + step.added,
             *(f'{step.holdout[name]:.2f} ({_ratio(step.training.get(name))})'
               for name in signals)] for place, step in enumerate(result.ladder)]
    return table(['model', *signals], rows)


def _ratio(value: float | None) -> str:
    return MISSING if value is None else f'{value:.2f}'


def _calibration(moved) -> str:
    return table(['quantity', 'factor', 'tolerances', 'remark'],
                 [[entry.quantity, f'{entry.factor:.4f}', f'{entry.sigmas:+.1f}',
                   'at its limit' if entry.at_limit else ''] for entry in moved])


def _sensors(off, head: str) -> str:
    return table(['sensor', head, 'unit', 'sigma'],
                 [[entry.channel, *size(entry.value, entry.unit), f'{entry.sigmas:+.1f}']
                  for entry in off])


def _smallest(result: Diagnosis) -> str:
    rows = []
    for name, smallest in sorted(result.smallest.items()):
        parameter = catalogue()[name].size
        rows.append([name, parameter.name, *size(smallest, parameter.unit, 3)])
    return table(['effect', 'parameter', 'size', 'unit'], rows)


def _described(unknown: Unknown) -> list[str]:
    """Say on what the unknown depends and what formula holds, as far as that is known."""
    on = [f'depends on: {", ".join(unknown.depends_on)}'] if unknown.depends_on else []
    if not unknown.terms and not unknown.formula:
        return [*on, f'what it is: {unknown.expression}']
    return [*on, f'formula: {unknown.expression}',
            *([f'it explains {100 * unknown.explained:.0f} % of the error that is left there']
              if unknown.terms else []), _worth(unknown)]


def _worth(unknown: Unknown) -> str:
    """Say what the formula does to the error when it becomes part of the model."""
    formula = unknown.formula
    if formula is None:
        return ('no formula of these variables, as a part of the model, takes away a tenth of its '
                'held-out squared error: nothing to adopt')
    falls = ', '.join(f'{name} {formula.before[name]:.2f} to {formula.after[name]:.2f}'
                      for name in formula.before
                      if abs(formula.before[name] - formula.after[name]) >= 0.05)
    return (f"'adopt --formula' puts it into the model ({formula.id}); held-out error over the "
            f'noise then falls: {falls}')
