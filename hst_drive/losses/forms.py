# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Formulas for leakage and torque loss over pressure, speed, viscosity and size.

All in the table's own scales (``Scales``), so that parameters are about 1. A coefficient of a term
goes with a power of the displacement whose exponent is fitted (one motor: held at that of
geometric similarity), and each motor may be off the law of sizes by a factor near 1.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from hst_drive.losses.fit import Parameter
from hst_drive.losses.table import Bench, VARIABLES
import numpy as np

UNIT_SCATTER = 0.10     # a motor's losses about the law of sizes, one sigma, relative


class Scales(NamedTuple):
    """What 1 stands for: Pa, rad/s, m^2/s, m^3/rad; displacements of the fitted motors."""

    pressure: float
    speed: float
    viscosity: float
    displacement: float
    sizes: tuple[float, ...]

    @property
    def flow(self) -> float:
        """Flow of the middle motor at the middle speed, m^3/s."""
        return self.displacement * self.speed

    @property
    def torque(self) -> float:
        """Ideal torque of the middle motor at the middle pressure, N.m."""
        return self.displacement * self.pressure


class Points(NamedTuple):
    """Scaled pressure, speed, viscosity, size; ``unit[i, k]`` is 1 where row i is motor k."""

    p: np.ndarray
    w: np.ndarray
    n: np.ndarray
    d: np.ndarray
    unit: np.ndarray

    def rows(self, keep) -> Points:
        """Return some of the points."""
        return Points(*(entry[keep] for entry in self))


def scales_of(bench: Bench) -> Scales:
    """Return scales at the middle of a table."""
    _, sizes = bench.levels('size')
    return Scales(*(float(np.exp(np.mean(np.log(values)))) for values in (
        bench.pressure, bench.speed, bench.viscosity)), float(np.exp(np.mean(np.log(sizes)))),
        tuple(map(float, sizes)))


def points_of(scales: Scales, pressure, speed, viscosity, displacement) -> Points:
    """Scale physical values (SI); a displacement that no fitted motor has belongs to none."""
    pressure, speed, viscosity, displacement = np.broadcast_arrays(*(
        np.atleast_1d(np.asarray(value, dtype=float))
        for value in (pressure, speed, viscosity, displacement)))
    sizes = np.array(scales.sizes)
    near = np.abs(displacement[:, None] / sizes - 1.0)
    unit = (near < VARIABLES['size'][2]) & (near == near.min(axis=1, keepdims=True))
    return Points(pressure / scales.pressure, speed / scales.speed,
                  viscosity / scales.viscosity, displacement / scales.displacement,
                  unit.astype(float))


@dataclass(frozen=True)
class Term:
    """
    A physical term ``d^exponent * shape(coefficient, points)``, coefficient not negative.

    ``within`` multiplies the laminar leakage by ``1 + shape`` instead; ``needs`` is the variable
    of which a table must have three levels for the term to show by its form.
    """

    id: str
    title: str
    shape: Callable[[float, Points], np.ndarray]
    text: str
    exponent: float = 1.0
    within: bool = False
    signed: bool = False
    needs: str = ''

    def parameters(self, several: bool) -> list[Parameter]:
        """Return coefficient and exponent of the size."""
        low = -20.0 if self.signed else 0.0
        own = [Parameter(self.id, 0.0, low, 20.0)]
        if self.within:
            return own
        return own + [Parameter(f'{self.id}.size', self.exponent, self.exponent - 2.0,
                                self.exponent + 2.0, 0.7 if several else 1e-6)]


@dataclass(frozen=True)
class Form:
    """A formula: parameters, function of (values, points), and how people read it."""

    id: str
    title: str
    own: tuple[Parameter, ...]
    base: Callable
    text: str
    units: int
    terms: tuple[Term, ...] = ()

    @property
    def several(self) -> bool:
        """Whether the table has motors of several sizes."""
        return self.units > 1

    def parameters(self) -> list[Parameter]:
        """Return the parameters: the form's, those of its terms, each motor's own factor."""
        out = list(self.own)
        for term in self.terms:
            out += term.parameters(self.several)
        if self.several:
            out += [Parameter(f'motor {k + 1}', 0.0, -0.7, 0.7, UNIT_SCATTER)
                    for k in range(self.units)]
        return out

    def __call__(self, values: np.ndarray, x: Points) -> np.ndarray:
        place = len(self.own)
        within, added = 0.0, 0.0
        for term in self.terms:
            if term.within:
                within = within + term.shape(values[place], x)
                place += 1
            else:
                added = added + x.d**values[place + 1] * term.shape(values[place], x)
                place += 2
        factor = np.exp(x.unit @ values[place:]) if self.several else 1.0
        return factor * (self.base(values[:len(self.own)], x, within) + added)

    def with_terms(self, *terms: Term) -> Form:
        """Return the form with further terms."""
        return Form('+'.join([self.id, *(term.id for term in terms)]), self.title, self.own,
                    self.base, ' + '.join([self.text, *(term.text for term in terms)]),
                    self.units, (*self.terms, *terms))


def leakage_forms(units: int, top: float = 2.0) -> list[Form]:
    """
    Return the forms of a leakage path: the paper's trends as laws, written in three ways.

    ``top`` is the highest pressure, scaled: up to there the conductance of the exponential form
    grows by two thirds at most. More is what the term elastic_leakage is for.
    """
    size = Parameter('size', -0.5, -3.0, 3.0, 1.5 if units > 1 else 1e-6)
    oil = Parameter('viscosity', 1.0, -0.5, 2.0, 0.3)
    start = Parameter('log conductance', -3.0, -25.0, 5.0)

    def gap(v, x, within):
        return (np.exp(v[0]) * x.d**v[1] * x.n**-v[2] * x.p * (1.0 + v[3] * x.p + within)
                / np.maximum(1.0 + v[4] * (x.w - 1.0), 0.02))

    def exponential(v, x, within):
        return (np.exp(v[0] + v[3] * x.p - v[4] * (x.w - 1.0)) * x.d**v[1] * x.n**-v[2] * x.p
                * (1.0 + within))

    def power(v, x, within):
        return (np.exp(v[0]) * x.d**v[1] * x.n**-v[2] * x.p**(1.0 + v[3]) * x.w**-v[4]
                * (1.0 + within))

    return [
        Form('gap', 'laminar gap that opens with pressure', (
            start, size, oil, Parameter('pressure', 0.1, -0.3, 20.0, 3.0),
            Parameter('speed', 0.0, -0.6, 2.0, 0.5)), gap,
            'K D^a nu^-m P (1 + b P) / (1 + c (w - w0))', units),
        Form('exponential', 'exponential', (
            start, size, oil, Parameter('pressure', 0.05, -1.0, 0.5 / top, 1.0),
            Parameter('speed', 0.0, -1.0, 2.0, 0.5)), exponential,
            'K D^a nu^-m P exp(b P - c w)', units),
        Form('power', 'power law', (
            start, size, oil, Parameter('pressure', 0.1, -0.8, 4.0, 1.0),
            Parameter('speed', 0.0, -1.0, 2.0, 0.5)), power,
            'K D^a nu^-m P^(1+b) w^-c', units)]


def torque_forms(units: int) -> list[Form]:
    """Return the forms of the torque loss: sums of frictions, and R_1 as a power law."""
    spread = 0.7 if units > 1 else 1e-6

    def friction(v, x, within):
        return (v[0] * x.d**v[3] + v[1] * x.d**v[4] * x.p
                + v[2] * x.d**v[5] * x.n**v[6] * x.w)

    def film(v, x, within):
        return (v[0] * x.d**v[3] + v[1] * x.d**v[4] * x.p
                + v[2] * x.d**v[5] * (x.n * x.w)**v[6])

    def power(v, x, within):
        return np.exp(v[0]) * x.d**v[1] * x.p**v[2] * x.w**v[3] * x.n**v[4]

    three = (Parameter('constant', 0.02, 0.0, 5.0), Parameter('load', 0.02, 0.0, 5.0),
             Parameter('viscous', 0.02, 0.0, 5.0),
             Parameter('constant size', 1.0, -2.0, 4.0, spread),
             Parameter('load size', 1.0, -2.0, 4.0, spread),
             Parameter('viscous size', 1.0, -2.0, 4.0, spread))
    return [
        Form('friction', 'constant, load and viscous friction', (
            *three, Parameter('viscosity', 0.75, 0.0, 1.5, 0.3)), friction,
            'T0 D^a + f D^b P + c D^e nu^k w', units),
        # Films that warm and thin out drag less than in proportion to speed, never more.
        Form('film', 'constant, load and film friction', (
            *three, Parameter('film', 0.7, 0.3, 1.0, 0.25)), film,
            'T0 D^a + f D^b P + c D^e (nu w)^m', units),
        Form('power', 'power law', (
            Parameter('log resistance', -3.0, -20.0, 3.0),
            Parameter('size', 1.0, -2.0, 4.0, 1.0 if units > 1 else 1e-6),
            Parameter('pressure', 0.5, -1.0, 3.0, 1.0), Parameter('speed', 0.4, -2.0, 3.0, 1.0),
            Parameter('viscosity', 0.3, -1.0, 2.0, 0.3)), power,
            'K D^a P^b w^c nu^k', units)]
