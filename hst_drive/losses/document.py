# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The result of a study as plain data: what ``losses --json`` writes, SI."""
from __future__ import annotations

from dataclasses import replace

from hst_drive.losses.accuracy import Cell, coverage, RESISTANCE
from hst_drive.losses.efficiency import ideal_speed, performance
from hst_drive.losses.models import catalogue, judge, Judged, ladder
from hst_drive.losses.paths import paths_of
from hst_drive.losses.resistances import Prediction, Resistances
from hst_drive.losses.study import Study
from hst_drive.losses.table import Bench
import numpy as np

SCHEMA = 'hst_drive/losses/1'
UNITS = {'resistance': 'Pa.s/m^3', 'pressure': 'Pa', 'flow': 'm^3/s', 'speed': 'rad/s',
         'torque': 'N.m', 'displacement': 'm^3/rad', 'temperature': 'K', 'slip': '1',
         'efficiency': '1'}
_EQUATIONS = {'R_el': '(2): R_el = P / Q_el', 'R_1': '(3): R_1 = (P - T/D) / (Q - P/R_el)',
              'R_2': '(4): R_2 = (T/D) / ((P - T/D)/R_1 - w D)',
              'R_total': '(12), (13): R_total = P / (Q - w D)'}


def determined(bench: Bench) -> dict:
    """Return what a table determines and what not, with the equations."""
    if bench.drain is not None:
        return {'determined': {name: _EQUATIONS[name] for name in _EQUATIONS},
                'not_determined': {},
                'why': 'Eq. (3) is Eq. (2) solved for R_1, so pressure, flow, torque and speed '
                       'are two equations for three resistances; the case drain flow, '
                       'Q_el = P/R_el, is the third.'}
    return {'determined': {
        'R_total': _EQUATIONS['R_total'],
        'torque_loss': '(14), (15): dT = P D - T'},
        'not_determined': {'R_el': 'Eq. (2) needs the case drain flow, Q_el = P/R_el',
                           'R_2': 'Eq. (4) needs R_1',
                           'R_1': 'Eq. (3) needs R_el; it lies between R_1_low (no leakage to '
                                  'the case) and R_1_high (all leakage to the case)'},
        'why': 'Without case_drain_flow only the total leakage is determined: Eq. (3) is Eq. (2) '
               'solved for R_1, two equations for three resistances. No split is invented.'}


def rows(bench: Bench, found: Resistances, study: Study | None) -> list[dict]:
    """Return measured and predicted values of each row."""
    shown = performance(bench.pressure, bench.flow, bench.speed, bench.load_torque,
                        bench.displacement)
    actual = {'ideal_speed': ideal_speed(bench.flow, bench.displacement), 'slip': shown.slip,
              'torque_loss': shown.torque_loss, 'torque_loss_share': shown.torque_loss_ratio,
              'efficiency': shown.overall}
    columns = {'line': bench.lines, 'motor_displacement': bench.displacement,
               'oil_temperature': bench.temperature, 'load_torque': bench.load_torque,
               'motor_speed': bench.speed, 'supply_pressure': bench.pressure,
               'supply_flow': bench.flow, 'viscosity': bench.viscosity}
    out = [{name: values[k] for name, values in columns.items()} for k in range(len(bench))]
    for k, row in enumerate(out):
        row['resistances'] = _resistances(found, k)
        row['actual'] = {name: values[k] for name, values in actual.items()}
        if study is not None:
            row['fitted_resistances'] = _resistances(study.fitted, k)
            row['predicted'] = _predicted(study.predicted, k, study.split)
            row['outlier'] = bool(study.weights[k] == 0)
    return out


def _resistances(found: Resistances, k: int) -> dict:
    return {'R_el': found.external[k], 'R_1': found.inlet[k], 'R_2': found.internal[k],
            'R_total': found.total[k], 'R_1_low': found.inlet_low[k],
            'R_1_high': found.inlet_high[k]}


def _predicted(found: Prediction, k: int, split: bool) -> dict:
    return {'speed': found.speed[k], 'speed_eq1_as_printed': found.speed_eq1[k] if split else None,
            'load_torque': found.load_torque[k], 'torque_loss': found.torque_loss[k],
            'slip': found.slip[k], 'efficiency': found.efficiency[k]}


def fits(study: Study) -> dict:
    """Return the characteristics: formula, parameters with 95 % intervals, held-out errors."""
    shares = coverage(study)
    out = {}
    for name, entry in study.searches.items():
        form, fit, _ = entry.best
        sd = np.sqrt(np.diag(fit.covariance)) * study.widen[name]
        held = study.held[name]
        good = study.weights > 0
        out[RESISTANCE[name]] = {
            'path': name, 'formula': form.text, 'title': form.title,
            'scales': {'pressure': study.scales.pressure, 'speed': study.scales.speed,
                       'viscosity': study.scales.viscosity,
                       'displacement': study.scales.displacement, 'loss': entry.path.unit},
            'parameters': {parameter.name: {'value': value, 'low': value - 1.96 * width,
                                            'high': value + 1.96 * width}
                           for parameter, value, width in zip(form.parameters(), fit.values, sd)},
            'noise_median': float(np.median(entry.path.sd) * entry.path.unit),
            'interval_widening': study.widen[name], 'coverage_of_95_percent': shares[name],
            'held_out_error_over_noise': {
                kind: float(np.sqrt(np.mean(error[good]**2)))
                for kind, error in held.error.items()},
            'forms_tried': dict(entry.forms)}
    return out


def models(study: Study) -> tuple[list[dict], dict[str, list[dict]]]:
    """Return the models of the field, ranked, and the ladder of ordinary terms by path."""
    whole = study.searches.get('total')
    if whole is None:
        leakage = paths_of(replace(study.bench, drain=None), study.scales)[0]
    else:
        leakage = whole.path
    torque = study.searches['torque'].path
    ranking = []
    for model in catalogue(len(study.scales.sizes)):
        parts = [judge(leakage, model.leakage, study.weights),
                 judge(torque, model.torque, study.weights)]
        ranking.append({'id': model.id, 'title': model.title, **_errors(study, *parts),
                        'leakage_formula': model.leakage.text,
                        'torque_formula': model.torque.text})
    ranking.sort(key=lambda entry: entry['error'])
    steps = {'leakage': ladder(leakage, study.weights), 'torque': ladder(torque, study.weights)}
    return ranking, {name: [{'added': key, 'title': title, 'held_out_error': error}
                            for key, title, error in entry] for name, entry in steps.items()}


def _errors(study: Study, leakage: Judged, torque: Judged) -> dict:
    """Return the held-out errors of a model: over the noise, and in slip and efficiency."""
    bench, good = study.bench, study.weights > 0
    slip, efficiency = [], []
    for kind in leakage.held.error:
        lost = leakage.held.prediction[kind] * study.scales.flow
        friction = torque.held.prediction[kind] * study.scales.torque
        speed = (bench.flow - lost) / bench.displacement
        gain = (bench.pressure * bench.displacement - friction) * speed
        slip.append((lost / bench.flow - 1.0 + bench.displacement * bench.speed
                     / bench.flow)[good])
        efficiency.append(((gain - bench.load_torque * bench.speed)
                           / (bench.pressure * bench.flow))[good])
    return {'error': float(np.sqrt(0.5 * (leakage.error**2 + torque.error**2))),
            'leakage_error': leakage.error, 'torque_error': torque.error,
            'slip_rms': float(np.sqrt(np.mean(np.square(slip)))),
            'efficiency_rms': float(np.sqrt(np.mean(np.square(efficiency))))}


def cells_document(found: list[Cell]) -> list[dict]:
    """Return the errors per motor and temperature."""
    return [{'motor_displacement': cell.displacement, 'oil_temperature': cell.temperature,
             'motor_left_out': cell.unseen, 'rows': cell.rows, 'errors': cell.errors,
             'noise': cell.noise, 'scatter': cell.scatter,
             'within_2_5_percent': cell.within} for cell in found]
