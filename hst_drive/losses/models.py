# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Loss models of the field, judged alike on left-out rows.

References
----------
W. E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman, 1950: laminar slip and a
    constant one; viscous, pressure-proportional and constant torque.
W. M. J. Schloesser, Ein mathematisches Modell fuer Verdraengerpumpen und -motoren,
    Oelhydraulik und Pneumatik 5, 1961: besides, turbulent slip and torque with speed squared.
M. Ivantysynova, J. Ivantysyn, Hydrostatic Pumps and Motors, Akademia Books, 2001: losses as
    polynomials in pressure, speed and the oil's state.

"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.fit import Parameter
from hst_drive.losses.forms import Form, leakage_forms, Points, Term, torque_forms
from hst_drive.losses.heldout import held_out, HeldOut
from hst_drive.losses.paths import fit_path, Path
import numpy as np

_LAMINAR = Term('laminar', 'laminar leakage', lambda c, x: c * x.p / x.n, 'c P/nu', -0.5)
_CONSTANT = Term('constant', 'constant', lambda c, x: c * np.ones_like(x.p), 'c')
_ORIFICE = Term('orifice', 'turbulent leakage', lambda c, x: c * np.sqrt(x.p), 'c P^0.5',
                2.0 / 3.0)
_VISCOUS = Term('viscous', 'viscous torque', lambda c, x: c * x.n * x.w, 'c nu w')
_LOAD = Term('load', 'friction in proportion to pressure', lambda c, x: c * x.p, 'c P')
_SQUARE = Term('square', 'torque with speed squared', lambda c, x: c * x.w**2, 'c w^2', 5.0 / 3.0)


class Model(NamedTuple):
    """A loss model: what it is called and its two formulas."""

    id: str
    title: str
    leakage: Form
    torque: Form


class Judged(NamedTuple):
    """A formula on a path: held-out errors over the noise, each, and together."""

    held: HeldOut
    error: float


def _sum(units: int, *terms: Term) -> Form:
    """Return a sum of terms with coefficients that are not negative."""
    return Form('sum', 'sum of terms', (), lambda v, x, within: np.zeros_like(x.p),
                ' + '.join(term.text for term in terms), units, terms)


def _polynomial(units: int, fluidity: bool) -> Form:
    """Return the full quadratic in pressure, speed and viscosity (or its reciprocal)."""
    powers = [(i, j, k) for i in range(3) for j in range(3) for k in range(3) if i + j + k <= 2]
    own = [Parameter('size', -0.5 if fluidity else 1.0, -3.0, 4.0, 1.5 if units > 1 else 1e-6)]
    own += [Parameter('c{}{}{}'.format(*power), 0.01 if sum(power) == 1 else 0.0, -50.0, 50.0,
                      2.0) for power in powers]

    def value(v, x: Points, within):
        oil = 1.0 / x.n if fluidity else x.n
        return x.d**v[0] * sum(c * x.p**i * x.w**j * oil**k
                               for c, (i, j, k) in zip(v[1:], powers))

    return Form('polynomial', 'full quadratic', tuple(own), value,
                'D^a sum c_ijk P^i w^j nu^' + ('-k' if fluidity else 'k'), units)


def catalogue(units: int) -> list[Model]:
    """Return the models for a table of so many motors."""
    gap, _, power = leakage_forms(units)
    friction, _, power_torque = torque_forms(units)
    return [
        Model('constant_resistances', "paper's form, resistances of the oil's viscosity alone",
              _sum(units, _LAMINAR), _sum(units, _VISCOUS)),
        Model('wilson', 'Wilson', _sum(units, _LAMINAR, _CONSTANT),
              _sum(units, _VISCOUS, _LOAD, _CONSTANT)),
        Model('schloesser', 'Schloesser', _sum(units, _LAMINAR, _ORIFICE),
              _sum(units, _VISCOUS, _LOAD, _SQUARE, _CONSTANT)),
        Model('polynomial', 'polynomial (after Ivantysyn and Ivantysynova)',
              _polynomial(units, True), _polynomial(units, False)),
        Model('paper_power', "paper's form, resistances as power laws", power, power_torque),
        Model('paper_laws', "paper's form, its trends as laws (opening gap, sum of frictions)",
              gap, friction),
    ]


def judge(path: Path, form: Form, weights: np.ndarray) -> Judged:
    """
    Fit a form to a path and judge it on left-out speeds, loads, temperatures and motors.

    The weights of the rows are given, so that no model calls an outlier what it cannot follow.
    """
    coefficients = {term.id for term in form.terms}
    start = np.array([0.02 if entry.name in coefficients else entry.start
                      for entry in form.parameters()])
    held = held_out(path, form, fit_path(path, form, start, weights))
    return Judged(held, held.rms(weights))


def ladder(path: Path, weights: np.ndarray) -> list[tuple[str, str, float]]:
    """
    Add the ordinary terms to constant resistances one by one, the best first.

    Returns
    -------
    list of (id, title, float)
        Name of what was added and the held-out error, over the noise, with it and all before.

    """
    units = path.x.unit.shape[1]
    if path.name == 'torque':
        form = torque_forms(units)[0]
        steps = {'constant_friction': ('constant', 'constant friction: seals, Coulomb'),
                 'load_friction': ('load', 'friction in proportion to the load: bearings, '
                                           'pistons')}
    else:
        form = leakage_forms(units)[0]
        steps = {'pressure_dependent_gap': ('pressure', 'leakage grows faster than pressure: '
                                                        'gaps open, oil warms in them'),
                 'speed_dependent_gap': ('speed', 'leakage falls (or grows) with speed')}
    left = dict(steps)
    fixed = {name for name, _ in steps.values()}
    out = [('constant_resistances', "resistances of the oil's viscosity alone",
            judge(path, held_at_zero(form, fixed), weights).error)]
    while left:
        tried = {key: judge(path, held_at_zero(form, fixed - {name}), weights).error
                 for key, (name, _) in left.items()}
        best = min(tried, key=tried.__getitem__)
        fixed -= {left[best][0]}
        out.append((best, left.pop(best)[1], tried[best]))
    return out


def held_at_zero(form: Form, names: set[str]) -> Form:
    """Return a form with some of its own parameters held at zero."""
    own = tuple(Parameter(entry.name, 0.0, -1e-12, 1e-12, 1e-6) if entry.name in names else entry
                for entry in form.own)
    return Form(form.id, form.title, own, form.base, form.text, form.units, form.terms)
