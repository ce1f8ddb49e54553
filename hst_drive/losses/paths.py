# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The losses of a table, each with its noise: leakage to the case, between the ports, torque.

A path is what one resistance stands for: ``external`` (``R_el``), ``internal`` (``R_2``),
``total`` (both, where there is no case drain flow) and ``torque`` (``R_1``). Formulas are fitted
to the flow or torque itself, in which the sensors' errors are even, and not to a resistance,
which runs off to infinity where a small loss drowns in noise.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

from hst_drive.losses.fit import Fit, solve
from hst_drive.losses.forms import Form, leakage_forms, Points, points_of, Scales, torque_forms
from hst_drive.losses.table import Bench, VARIABLES
import numpy as np


@dataclass(frozen=True, eq=False)
class Path:
    """
    One loss, in the table's scales.

    Attributes
    ----------
    name : str
        external, internal, total or torque.
    unit : float
        What 1 stands for, m^3/s or N.m.
    x : Points
        Where it was measured.
    y, sd : ndarray, shape (n,)
        Loss and the standard deviation of its noise.
    groups : dict of str to ndarray
        Level of each row by variable; only variables with at least two levels, or 'row' (fifths)
        where there is none.

    """

    name: str
    unit: float
    x: Points
    y: np.ndarray
    sd: np.ndarray
    groups: dict[str, np.ndarray]

    def forms(self) -> list[Form]:
        """Return the paper's trends as laws, each written in three ways."""
        units = self.x.unit.shape[1]
        return (torque_forms(units) if self.name == 'torque'
                else leakage_forms(units, float(self.x.p.max())))


def paths_of(bench: Bench, scales: Scales) -> list[Path]:
    """Return the losses that a table determines, each with its noise."""
    x = points_of(scales, bench.pressure, bench.speed, bench.viscosity, bench.displacement)
    groups = groups_of(bench)
    leakage = bench.flow - bench.displacement * bench.speed
    torque = bench.pressure * bench.displacement - bench.load_torque
    losses = [('torque', torque, scales.torque, bench.pressure * bench.displacement)]
    if bench.drain is None:
        losses = [('total', leakage, scales.flow, bench.flow), *losses]
    else:
        losses = [('external', bench.drain, scales.flow, bench.drain),
                  ('internal', leakage - bench.drain, scales.flow, bench.flow), *losses]
    out = []
    for name, values, unit, level in losses:
        path = Path(name, unit, x, values / unit, np.ones(len(values)), groups)
        out.append(replace(path, sd=_noise(path, level / unit)))
    return out


def groups_of(bench: Bench) -> dict[str, np.ndarray]:
    """Return the level of each row by variable, where there are at least two."""
    found = {name: bench.levels(name)[0] for name in VARIABLES}
    groups = {name: labels for name, labels in found.items() if labels.max() > 0}
    if not set(groups) - {'size'}:
        groups['row'] = np.arange(len(bench)) % 5
    return groups


def _noise(path: Path, level: np.ndarray) -> np.ndarray:
    """
    Estimate the standard deviation of each row from what no smooth function follows.

    What a power law leaves is smoothed per motor by a quadratic in pressure, speed and viscosity;
    the rest is noise, its variance a constant and a part in proportion to the level squared.
    """
    floor = 2e-4 * float(np.median(np.abs(level))) + 1e-12
    size = float(np.median(np.abs(path.y))) + floor
    start = 0.02 * (np.abs(path.y) + 0.3 * size) + floor
    # All forms: what one leaves may be too crooked for a quadratic.
    sd = start
    for _ in range(2):
        fits = [solve(form, form.parameters(), path.x, path.y, sd) for form in path.forms()]
        best = min(fits, key=lambda fit: np.median(np.abs(fit.residuals)))
        rest = _unsmooth(best.residuals * sd, sd, best.weights, path.x)
        if rest is None:
            rest = best.residuals * sd * np.sqrt(len(sd) / max(len(sd) - 6.0, 1.0))
        sd = np.maximum(_variance(rest, level), floor**2)**0.5
    return sd


def _unsmooth(values: np.ndarray, sd: np.ndarray, weights: np.ndarray,
              x: Points) -> np.ndarray | None:
    """Return what a quadratic per motor leaves, freedom counted; None with too few rows."""
    out = np.full(len(values), np.nan)
    for unit in x.unit.T > 0:
        p, w, n = (np.log(entry[unit]) - np.log(entry[unit]).mean() for entry in x[:3])
        columns = [np.ones(unit.sum())]
        for entry, count in ((p, 4), (w, 4), (n, 3)):
            if np.ptp(entry) > 0.02:
                columns += [entry, entry**2] if len(np.unique(entry.round(2))) >= count else [
                    entry]
        columns += [p * w, p * n, w * n]
        design = np.column_stack(columns)
        if unit.sum() < 1.6 * design.shape[1]:
            return None
        scale = np.sqrt(weights[unit]) / sd[unit]
        left, sizes, _ = np.linalg.svd(design * scale[:, None], full_matrices=False)
        left = left[:, sizes > 1e-8 * sizes[0]]
        scaled = values[unit] * scale
        rest = (scaled - left @ (left.T @ scaled))
        free = np.maximum(1.0 - np.sum(left**2, axis=1), 0.2)
        out[unit] = rest / np.sqrt(free) / np.where(scale > 0, scale, np.inf)
    return out


def _variance(rest: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Fit ``a + b level^2``, neither negative, to squared residuals; outliers are clipped."""
    squares = rest**2
    design = np.column_stack([np.ones(len(level)), (level / np.median(np.abs(level)))**2])
    variance = np.full(len(rest), (1.4826 * float(np.median(np.abs(rest))))**2 + 1e-30)
    for _ in range(6):
        weight = 1.0 / variance
        clipped = np.minimum(squares, 9.0 * variance)
        found = [np.maximum(np.linalg.lstsq(design[:, use] * weight[:, None], clipped * weight,
                                            rcond=None)[0], 0.0)
                 for use in ([0, 1], [0], [1])]
        trials = [design @ found[0], design[:, 0] * found[1][0], design[:, 1] * found[2][0]]
        fitting = [trial for k, trial in enumerate(trials)
                   if (trial > 0).all() and (k or found[0].min() > 0)]
        if not fitting:
            break
        variance = 1.03 * min(fitting, key=lambda trial: np.sum(
            np.log(trial) + clipped / trial)) + 1e-30
    return variance


def fit_path(path: Path, form: Form, start: np.ndarray | None = None,
             weights: np.ndarray | None = None, keep: np.ndarray | None = None,
             steps: int = 25) -> Fit:
    """Fit a form to a path, or to some of its rows."""
    keep = slice(None) if keep is None else keep
    return solve(form, form.parameters(), path.x.rows(keep), path.y[keep], path.sd[keep], start,
                 None if weights is None else weights[keep], steps)
