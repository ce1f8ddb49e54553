# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Steady-state losses as text and as JSON."""
from __future__ import annotations

from hst_drive.losses import document as doc
from hst_drive.losses.accuracy import cells
from hst_drive.losses.ordinary import sizes
from hst_drive.losses.resistances import Resistances
from hst_drive.losses.study import Study
from hst_drive.losses.table import Bench
from hst_drive.losses.trends import CONTRADICTION, STATED
from hst_drive.losses.verdict import Verdict, verdict
from hst_drive.report.terminal import table
from hst_drive.units import from_si


def as_json(bench: Bench, oil: str, found: Resistances, study: Study | None) -> dict:
    """Return what a bench table says as the verb ``losses --json`` writes it, SI."""
    return {**_head(bench, oil), **(_studied(study) if study else {}),
            'rows': doc.rows(bench, found, study)}


def _head(bench: Bench, oil: str) -> dict:
    """Return what the table is."""
    return {'schema': doc.SCHEMA, 'bench': bench.source, 'rows_used': len(bench), 'oil': oil,
            'units': doc.UNITS, 'motors': list(bench.levels('size')[1]),
            'temperatures': list(bench.levels('temperature')[1]),
            'case_drain_flow': bench.drain is not None, **doc.determined(bench),
            'notes': list(bench.notes)}


def _studied(study: Study) -> dict:
    """Return all that was fitted and judged."""
    ranking, steps = doc.models(study)
    found = verdict(study)
    return {'summary': found.sentence, 'missing_term': found, 'fits': doc.fits(study),
            'heldout': doc.cells_document(cells(study)), 'trends': study.trends,
            'ordinary_terms': [size for entry in study.searches.values()
                               for size in sizes(entry, study.scales.pressure)],
            'contradiction': study.contradiction, 'models': ranking, 'ladder': steps,
            'outliers': [{'line': int(study.bench.lines[place]), 'path': path, 'sigma': sigma}
                         for place, path, sigma in study.outliers]}


def shown(content: dict, bench: Bench, found: Resistances, study: Study | None) -> str:
    """Return the result for people: the sentence first."""
    parts = []
    if study is not None:
        parts.append(content['summary'])
    parts.append(_about(content, bench))
    if study is None:
        return '\n\n'.join([*parts, _rows(bench, found)])
    for entry in content['outliers']:
        parts.append(f'Row {entry["line"]} is an outlier: its {entry["path"]} loss lies '
                     f'{entry["sigma"]:+.0f} standard deviations off; it does not count.')
    parts += [_fits(content), _heldout(content), _trends(content), _models(content),
              _terms(content['missing_term'])]
    return '\n\n'.join(parts)


def _about(content: dict, bench: Bench) -> str:
    motors = ', '.join(f'{from_si(value, "cc/rev"):.4g}' for value in content['motors'])
    degrees = ', '.join(f'{from_si(value, "degC"):.3g}' for value in content['temperatures'])
    lines = [f'{content["rows_used"]} rows, motors of {motors} cc/rev at {degrees} degC, '
             f'{content["oil"]}.', content['why']]
    lines += [f'  determined      {name}: Eq. {how}'
              for name, how in content['determined'].items()]
    lines += [f'  not determined  {name}: {how}'
              for name, how in content['not_determined'].items()]
    return '\n'.join(lines)


def _rows(bench: Bench, found: Resistances) -> str:
    body = [[int(bench.lines[k]), from_si(bench.displacement[k], 'cc/rev'),
             from_si(bench.temperature[k], 'degC'), bench.load_torque[k],
             from_si(bench.speed[k], 'rpm'),
             *(from_si(values[k], 'bar/(L/min)') for values in (
                 found.external, found.inlet, found.internal, found.total))]
            for k in range(len(bench))]
    return table(['row', 'cc/rev', 'degC', 'N.m', 'rpm', 'R_el', 'R_1', 'R_2',
                  'R_total bar/(L/min)'], body)


def _fits(content: dict) -> str:
    body = []
    for name, fit in content['fits'].items():
        held = fit['held_out_error_over_noise']
        body.append([name, fit['formula'], *(held.get(kind) for kind in (
            'speed', 'load', 'temperature', 'size')), 100 * min(
                fit['coverage_of_95_percent'].values())])
    return ('Characteristics; error on left-out levels over the noise of the sensors (1 is '
            'perfect); share of left-out points in their 95 % intervals:\n'
            + table(['', 'formula', 'speed', 'load', 'temperature', 'motor', 'inside %'], body))


def _heldout(content: dict) -> str:
    cell_list = content['heldout']
    names = list(dict.fromkeys(name for cell in cell_list for name in cell['errors']))
    body = [[f'{from_si(cell["motor_displacement"], "cc/rev"):.4g}',
             f'{from_si(cell["oil_temperature"], "degC"):.3g}',
             'unseen' if cell['motor_left_out'] else 'known',
             *(_plus_minus(cell, name) for name in names), cell['within_2_5_percent']]
            for cell in cell_list]
    inside = sum(cell['within_2_5_percent'] for cell in cell_list)
    return ('Predictions of left-out rows, mean error in percent +- what the noise leaves '
            '(unseen: the motor itself was left out):\n'
            + table(['cc/rev', 'degC', 'motor', *names, 'within 2.5 %'], body)
            + f'\nWithin 2.5 % (noise counted): {inside} of {len(cell_list)}.')


def _plus_minus(cell: dict, name: str) -> str:
    if name not in cell['errors']:
        return '-'
    return f'{100 * cell["errors"][name]:+.2f} +- {100 * cell["noise"][name]:.2f}'


def _trends(content: dict) -> str:
    body = [[STATED[trend.quantity][0], f'{trend.stated} with {trend.variable}', trend.verdict,
             trend.reason] for trend in content['trends']]
    both = content['contradiction']
    said = (f'Here R_1 rising with size {both["R_1_with_size"]}, torque loss in percent falling '
            f'with size {both["torque_loss_with_size"]}')
    if both['size_exponent_of_R_1'] is not None:
        said += f'; R_1 goes as D^{both["size_exponent_of_R_1"]:.2f}'
    return ('Trends that the paper states:\n'
            + table(['quantity', 'stated', 'verdict', 'found'], body)
            + f'\nCannot hold together: {CONTRADICTION} {said}.')


def _models(content: dict) -> str:
    body = [[entry['title'], entry['leakage_error'], entry['torque_error'],
             100 * entry['slip_rms'], 100 * entry['efficiency_rms']]
            for entry in content['models']]
    out = ('Loss models, ranked by the error on left-out rows over the noise; rms of slip and '
           'efficiency in points:\n'
           + table(['model', 'leakage', 'torque', 'slip', 'efficiency'], body))
    out += '\nOrdinary terms, which the simple form has: ' + '; '.join(
        f'{entry["title"]} ({entry["path"]}) {_sized(entry)}'
        for entry in content['ordinary_terms']) + '.'
    for name, steps in content['ladder'].items():
        out += f'\nAdd a term, watch the error of the {name} fall: ' + ', then '.join(
            f'{step["title"]}: {step["held_out_error"]:.2f}' for step in steps) + '.'
    return out


def _sized(entry: dict) -> str:
    value, low, high = (entry[key] * {'1/Pa': 1e9, '1': 100.0}.get(entry['unit'], 1.0)
                        for key in ('value', 'low', 'high'))
    unit = {'1/Pa': '% per 100 bar', '1': '%'}.get(entry['unit'], entry['unit'])
    return f'{value:.3g} {unit} (95 %: {low:.3g} to {high:.3g})'


def _terms(found: Verdict) -> str:
    if not found.terms:
        limits = [[place, name, 100 * share] for place, terms in found.would_show.items()
                  for name, share in terms.items()]
        return ('Smallest share of a loss from which a term would have been named:\n'
                + table(['path', 'term', '%'], limits))
    body = []
    for term in found.terms:
        unit = 'N.m' if term.unit == 'N.m' else 'L/min'
        size, low, high = (from_si(value, unit) for value in (term.size, term.low, term.high))
        body.append([term.id, term.path, term.equation, size, f'{low:.3g} to {high:.3g}', unit,
                     100 * term.share, term.error_before, term.error_after,
                     ', '.join(term.rivals) or '-'])
    return ('Missing terms (size at the highest pressure and speed in the middle motor):\n'
            + table(['term', 'path', 'formula', 'size', '95 % interval', 'unit', '% of loss',
                     'error before', 'after', 'rivals'], body))
