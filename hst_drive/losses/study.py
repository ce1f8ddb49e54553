# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Everything that a bench table says, from its rows to the missing term."""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hst_drive.errors import InputError
from hst_drive.losses import resistances as eq
from hst_drive.losses.fit import predict_sd
from hst_drive.losses.forms import points_of, Scales, scales_of, UNIT_SCATTER
from hst_drive.losses.heldout import held_out, HeldOut, widening
from hst_drive.losses.paths import paths_of
from hst_drive.losses.table import Bench
from hst_drive.losses.terms import Search, search
from hst_drive.losses.trends import contradiction, Trend, trends
import numpy as np

LEAST_ROWS = 8          # below this no curve is fitted
OUTLIER = 6.0           # standard deviations


@dataclass(frozen=True, eq=False)
class Curves:
    """
    Losses that the fitted formulas give at operating points, SI.

    ``leakage_sd`` and ``torque_sd`` are those of the curves (widened so that they hold on
    left-out rows), without the sensors' noise.
    """

    external: np.ndarray | None
    internal: np.ndarray | None
    leakage: np.ndarray
    torque_loss: np.ndarray
    leakage_sd: np.ndarray
    torque_sd: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """A bench table and what was fitted to it; ``searches`` by path."""

    bench: Bench
    scales: Scales
    searches: dict[str, Search]

    @property
    def split(self) -> bool:
        """Whether the leakage is split, by the case drain flow."""
        return 'external' in self.searches

    @cached_property
    def found(self) -> eq.Resistances:
        """The resistances of each row, Eqs. (2) to (4)."""
        return eq.identify(self.bench)

    @cached_property
    def held(self) -> dict[str, HeldOut]:
        """Predictions of left-out rows by path, with the named terms."""
        return {name: held_out(entry.path, entry.best[0], entry.best[1], spread=True)
                for name, entry in self.searches.items()}

    @cached_property
    def widen(self) -> dict[str, float]:
        """By what each path's intervals are widened to hold on left-out rows."""
        return {name: widening(entry.path, self.held[name], self.weights)
                for name, entry in self.searches.items()}

    @cached_property
    def outliers(self) -> list[tuple[int, str, float]]:
        """Rows that no smooth curve follows: place, path, standard deviations."""
        out = []
        for name, entry in self.searches.items():
            for place in np.flatnonzero(np.abs(entry.best[1].residuals) > OUTLIER):
                out.append((int(place), name, float(entry.best[1].residuals[place])))
        return out

    @cached_property
    def weights(self) -> np.ndarray:
        """0 for outlying rows, else 1."""
        weights = np.ones(len(self.bench))
        weights[[place for place, _, _ in self.outliers]] = 0.0
        return weights

    def curves(self, pressure, speed, viscosity, displacement) -> Curves:
        """Return the losses at operating points (SI)."""
        x = points_of(self.scales, pressure, speed, viscosity, displacement)
        values, spread = {}, {}
        for name, entry in self.searches.items():
            form, fit, _ = entry.best
            values[name] = form(fit.values, x) * entry.path.unit
            curve = predict_sd(fit, form, x)
            if form.several:
                # A motor that was not on the bench is off the law of sizes by its own scatter.
                stranger = x.unit.sum(axis=1) == 0
                curve = np.hypot(curve, stranger * UNIT_SCATTER * np.abs(form(fit.values, x)))
            spread[name] = curve * self.widen[name] * entry.path.unit
        if self.split:
            leakage = values['external'] + values['internal']
            leakage_sd = np.hypot(spread['external'], spread['internal'])
        else:
            leakage, leakage_sd = values['total'], spread['total']
        return Curves(values.get('external'), values.get('internal'), leakage,
                      values['torque'], leakage_sd, spread['torque'])

    def operate(self, speed, load_torque, viscosity, displacement) -> dict[str, np.ndarray]:
        """
        Return what a motor needs and gives at a speed under a load.

        Pressure (Pa), flow (m^3/s), slip, torque_loss (N.m), torque_loss_share, efficiency and
        its ``efficiency_sd``. Pressure follows from ``P D = T + dT(P)``, Eqs. (14) and (15).
        """
        speed, load_torque, viscosity, displacement = np.broadcast_arrays(*(
            np.atleast_1d(np.asarray(value, dtype=float))
            for value in (speed, load_torque, viscosity, displacement)))
        pressure = 1.05 * load_torque / displacement + 1e4
        for _ in range(30):
            lost = self.curves(pressure, speed, viscosity, displacement)
            after = (load_torque + lost.torque_loss) / displacement
            if np.allclose(after, pressure, rtol=1e-9):
                break
            pressure = after
        lost = self.curves(pressure, speed, viscosity, displacement)
        flow = displacement * speed + lost.leakage
        efficiency = load_torque * speed / (pressure * flow)
        return {'pressure': pressure, 'flow': flow, 'slip': lost.leakage / flow,
                'torque_loss': lost.torque_loss,
                'torque_loss_share': lost.torque_loss / (pressure * displacement),
                'efficiency': efficiency, 'efficiency_sd': efficiency * np.hypot(
                    lost.leakage_sd / flow, lost.torque_sd / (pressure * displacement))}

    @cached_property
    def at_rows(self) -> Curves:
        """The fitted losses at the rows."""
        bench = self.bench
        return self.curves(bench.pressure, bench.speed, bench.viscosity, bench.displacement)

    @cached_property
    def fitted(self) -> eq.Resistances:
        """The resistances of the characteristics, at the rows."""
        bench, lost = self.bench, self.at_rows
        return eq.of_losses(bench, lost.torque_loss / bench.displacement, lost.leakage,
                            lost.external, lost.internal)

    @cached_property
    def predicted(self) -> eq.Prediction:
        """
        What the characteristics predict at the rows, Eqs. (1) and (6) to (10).

        Without the case drain flow the whole leakage is taken to lie between the ports: speed,
        slip and efficiency do not depend on the split.
        """
        bench, lost = self.bench, self.at_rows
        external = lost.external if self.split else np.full(len(bench), 1e-30)
        internal = lost.internal if self.split else lost.leakage
        drop = lost.torque_loss / bench.displacement
        return eq.predict(bench.pressure, bench.flow, bench.load_torque, bench.displacement,
                          bench.pressure / external, drop / (bench.flow - external),
                          bench.load_torque / bench.displacement / internal)

    @cached_property
    def noise(self) -> dict[str, np.ndarray]:
        """Standard deviation of each stated quantity at the rows, from the sensors' noise."""
        bench, fitted, lost = self.bench, self.fitted, self.at_rows
        sd = {name: entry.path.sd * entry.path.unit for name, entry in self.searches.items()}
        leakage = sd['internal'] if self.split else sd['total']
        ideal = bench.pressure * bench.displacement
        return {
            'R_el': fitted.external * sd['external'] / np.abs(lost.external) if self.split
            else fitted.external,
            'R_2': fitted.internal * sd['internal'] / np.abs(lost.internal) if self.split
            else fitted.internal,
            'R_1': fitted.inlet_low * sd['torque'] / np.abs(lost.torque_loss),
            'slip': leakage / bench.flow, 'torque_loss': sd['torque'] / ideal,
            'efficiency': np.hypot(leakage / bench.flow, sd['torque'] / ideal)}

    @cached_property
    def trends(self) -> list[Trend]:
        """A verdict on each trend that the paper states."""
        return trends(self.bench, self.found, self.noise, self.weights)

    @cached_property
    def contradiction(self) -> dict:
        """What the table says on the two stated trends that exclude each other."""
        return contradiction(self.bench, self.trends, self.found)


def study(bench: Bench) -> Study:
    """
    Fit the characteristics of a bench table and look for missing terms.

    Raises
    ------
    InputError
        If there are too few rows for any curve.

    """
    if len(bench) < LEAST_ROWS:
        raise InputError(f'{bench.source}: has {len(bench)} usable rows; a curve of a loss needs '
                         f'at least {LEAST_ROWS}; measure more operating points')
    scales = scales_of(bench)
    return Study(bench, scales, {path.name: search(path) for path in paths_of(bench, scales)})
