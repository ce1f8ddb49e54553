# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Ordinary terms that stand out.

Friction in proportion to the load, constant friction and gaps that open in proportion to pressure
belong to every motor and are part of the simple form; by form alone nothing tells an additional
amount of them from the usual one. They are named where the paper's trends would otherwise not
be there (the only cause besides constant resistances) or where they are larger than usual.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.fit import Fit
from hst_drive.losses.forms import Form
from hst_drive.losses.heldout import held_out
from hst_drive.losses.models import held_at_zero
from hst_drive.losses.paths import fit_path, Path
from hst_drive.losses.terms import Search
import numpy as np

# Bent-axis motors lose 1 to 3 % of P D to friction in proportion to the load; the bench of the
# motor-loss paper shows leakage that grows by a fourth per 100 bar beyond proportion.
USUAL_LOAD_FRICTION = 0.04
USUAL_OPENING = 0.6e-7          # 1/Pa
_LEAST_Z = 6.0
_LEAST_SHARE, _ABSENT_SHARE = 0.10, 0.06
_LEAST_OPENING, _ABSENT_SPEED = 0.15, 0.05


class Ordinary(NamedTuple):
    """An ordinary term that stands out; ``reason``: the only cause, or larger than usual."""

    id: str
    title: str
    equation: str
    reason: str
    form: Form
    fit: Fit
    place: int
    sd: float
    error_before: float
    error_after: float


def ordinary(search: Search, pressure_scale: float) -> Ordinary | None:
    """Return the ordinary term of a path that stands out, if any."""
    if search.steps:
        return None
    path = search.path
    name = 'friction' if path.name == 'torque' else 'gap'
    form = next(form for form in path.forms() if form.id == name)
    fit = fit_path(path, form)
    error = held_out(path, form, fit).rms(fit.weights, search.kinds)
    if error > 1.1 * max(search.error, 1.0):
        return None
    sd = np.sqrt(np.diag(fit.covariance))
    found = (_torque(path, form, fit) if name == 'friction'
             else _leakage(path, fit, sd, pressure_scale))
    if found is None:
        return None
    place, key, title, equation, reason = found
    without = held_at_zero(form, {form.own[place].name})
    start = fit.values.copy()
    start[place] = 0.0
    bare = fit_path(path, without, start, fit.weights)
    before = held_out(path, without, bare).rms(fit.weights, search.kinds)
    if before < 1.1 * error:
        return None
    return Ordinary(key, title, equation, reason, form, fit, place, float(sd[place]), before,
                    error)


def _torque(path: Path, form: Form, fit: Fit) -> tuple | None:
    shares, sds = [], []
    whole = float(np.sum(form(fit.values, path.x)))
    for place in range(2):
        without = fit.values.copy()
        without[place] = 0.0
        share = 1.0 - float(np.sum(form(without, path.x))) / whole
        sd = float(np.sqrt(fit.covariance[place, place]))
        # At zero the covariance counts the parameter as held: then the share of one unit counts.
        per_unit = share / fit.values[place] if fit.values[place] > 0 else 0.0
        shares.append(share)
        sds.append(per_unit * sd)
    constant, load = shares
    upper = [share + 1.96 * sd for share, sd in zip(shares, sds)]
    if load >= _LEAST_SHARE and load > _LEAST_Z * sds[1]:
        title = 'load-dependent bearing friction, in proportion to the load'
        if upper[0] < _ABSENT_SHARE:
            return (1, 'bearing_friction', title, 'f D P',
                    'the only friction besides the viscous one')
        ratio = load * whole / float(np.sum(path.x.p * path.x.d))
        if ratio > USUAL_LOAD_FRICTION:
            return (1, 'bearing_friction', title, 'f D P',
                    f'{100 * ratio:.2g} % of P D, where 1 to 3 % are usual')
    if constant >= _LEAST_SHARE and constant > _LEAST_Z * sds[0] and upper[1] < _ABSENT_SHARE:
        return (0, 'constant_friction', 'constant friction torque (Coulomb, seals)', 'T0',
                'the only friction besides the viscous one')
    return None


def _leakage(path: Path, fit: Fit, sd: np.ndarray, pressure_scale: float) -> tuple | None:
    opening, speed = fit.values[3], fit.values[4]
    if opening < _LEAST_Z * sd[3] or opening * path.x.p.max() < _LEAST_OPENING:
        return None
    title = 'gaps that open in proportion to pressure'
    span = float(np.ptp(path.x.w))
    if span > 0.1 and (abs(speed) + 1.96 * sd[4]) * span < _ABSENT_SPEED:
        return (3, 'elastic_leakage', title, 'laminar x (1 + b P)',
                'the only change of the resistance besides viscosity')
    if opening / pressure_scale > USUAL_OPENING:
        return (3, 'elastic_leakage', title, 'laminar x (1 + b P)',
                f'{100 * opening / pressure_scale * 1e7:.2g} % per 100 bar, where 20 to 40 % are '
                'usual')
    return None


def sizes(search: Search, pressure_scale: float) -> list[dict]:
    """
    Return the ordinary terms of a path with their sizes and 95 % intervals.

    Friction: share of ``P D`` (load) or torque in the middle motor, N.m; gaps: 1/Pa.
    """
    path = search.path
    torque = path.name == 'torque'
    form = next(form for form in path.forms() if form.id == ('friction' if torque else 'gap'))
    fit = fit_path(path, form)
    sd = np.sqrt(np.diag(fit.covariance))
    if not torque:
        chosen = [(3, 'opening_gap', 'leakage grows beyond proportion to pressure, relative',
                   1.0 / pressure_scale, '1/Pa')]
    else:
        chosen = [(0, 'constant_friction', 'constant friction in the middle motor', path.unit,
                   'N.m'),
                  (1, 'load_friction', 'friction in proportion to the load, share of P D', 1.0,
                   '1'),
                  (2, 'viscous_friction', 'viscous friction in the middle motor at the middle '
                   'speed and viscosity', path.unit, 'N.m')]
    return [{'id': key, 'path': path.name, 'title': title, 'value': fit.values[place] * unit,
             'low': (fit.values[place] - 1.96 * sd[place]) * unit,
             'high': (fit.values[place] + 1.96 * sd[place]) * unit, 'unit': name}
            for place, key, title, unit, name in chosen]
