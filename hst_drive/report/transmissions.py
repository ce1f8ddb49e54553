# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A table of transmissions tested at one point: what it says, as text and as JSON."""
from __future__ import annotations

from hst_drive.bag.bench_table import PointTable
from hst_drive.losses.document import SCHEMA
from hst_drive.losses.transmission import Spread, Transmissions, transmissions
from hst_drive.report.terminal import table as text_table
from hst_drive.units import from_si


def is_transmissions(table: PointTable) -> bool:
    """Return whether a table holds pump and motor speeds, and no flow or torque."""
    names = {*table.columns, *table.constants}
    return {'pump_speed', 'motor_speed'} <= names and not names & {'supply_flow', 'load_torque'}


def study_transmissions(table: PointTable) -> tuple[dict, str]:
    """Return the result as plain data and as text."""
    found = transmissions(table.columns, table.headers, table.lines, table.constants,
                          table.source)
    sentence = _sentence(found)
    content = {'schema': SCHEMA, 'kind': 'transmissions', 'bench': table.source,
               'summary': sentence, 'missing_term': {
                   'verdict': 'missing_term', 'terms': [{
                       'id': 'leakage', 'title': 'leakage of pump and motor together',
                       'flow': found.leakage and found.leakage._asdict(),
                       'conductance': found.conductance and found.conductance._asdict(),
                       'share_of_flow': found.leakage_share._asdict(),
                       'unit_scatter': found.unit_scatter}]},
               'constants': dict(table.constants), **{
                   key: value._asdict() if isinstance(value, Spread) else value
                   for key, value in found._asdict().items() if key != 'outliers'},
               'outliers': [entry._asdict() for entry in found.outliers],
               'notes': list(table.notes)}
    return content, _text(found, sentence)


def _sentence(found: Transmissions) -> str:
    text = (f'The loss-free model turns at {from_si(found.loss_free_speed, "rpm"):.0f} rpm, the '
            f'{found.units} measured units at {from_si(found.speed.median, "rpm"):.0f} +- '
            f'{from_si(found.speed.sd, "rpm"):.0f} rpm: it is off by '
            f'{100 * found.speed_error_over_loss_free:.1f} % of its own speed, '
            f'{100 * found.speed_error_over_measured:.1f} % of theirs. '
            'The missing effect is leakage of pump and motor together')
    if found.leakage:
        text += f', {from_si(found.leakage.median, "L/min"):.1f} L/min'
    if found.conductance:
        text += (f', {from_si(found.conductance.median, "L/min/bar"):.3f} L/min/bar '
                 f'({found.conductance.median:.3g} m^3/(s.Pa))')
    if found.unit_scatter is not None:
        text += f', scattering by {100 * found.unit_scatter:.1f} % between units'
    return text + '. Torque losses are not determinable from this table.'


def _text(found: Transmissions, sentence: str) -> str:
    rows = [_row('motor speed', found.speed, 'rpm'),
            _row('leakage, share of the pump flow', found.leakage_share, '%')]
    if found.leakage:
        rows.append(_row('leakage', found.leakage, 'L/min'))
    if found.conductance:
        rows.append(_row('leakage conductance', found.conductance, 'L/min/bar'))
    parts = [sentence, text_table(['quantity', 'unit', 'median', '95 % interval', 'sd of units',
                                   'least', 'most'], rows)]
    if found.repeatability is not None:
        parts.append(f'Between units the leakage scatters by {100 * found.unit_scatter:.2g} % '
                     f'(one sigma); forward against reverse differs by '
                     f'{100 * found.repeatability:.2g} % in one unit.')
    parts += [f'Row {entry.line}, column {entry.column!r}: '
              f'{from_si(entry.value, "rpm"):.0f} rpm is an outlier '
              f'({entry.sigma:+.0f} standard deviations'
              + (f', {entry.guess}' if entry.guess else '') + '); it does not count.'
              for entry in found.outliers]
    parts.append('Not determinable:\n' + '\n'.join(
        f'  {name}: {why}' for name, why in found.not_determinable.items()))
    return '\n\n'.join(parts)


def _row(name: str, spread: Spread, unit: str) -> list:
    median, low, high, sd, least, most = (from_si(float(value), unit) for value in spread)
    return [name, unit, f'{median:.5g}', f'{low:.5g} to {high:.5g}', f'{sd:.3g}', f'{least:.5g}',
            f'{most:.5g}']
