# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How far predictions of left-out rows are off, per motor and temperature."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.study import Study
import numpy as np

AGREED = 0.025      # the paper's resistances agree with its tests within 2 to 2.5 %
RESISTANCE = {'external': 'R_el', 'internal': 'R_2', 'total': 'R_total', 'torque': 'R_1'}


class Cell(NamedTuple):
    """
    Errors of predictions of left-out rows of a motor at a temperature, relative.

    ``errors``: by quantity the mean over the cell (predicted over measured, minus 1);
    ``noise``: what the sensors' noise alone leaves in that mean, one sigma; ``scatter``: rms over
    single rows, noise included. ``unseen``: the motor itself was left out.
    """

    displacement: float
    temperature: float
    unseen: bool
    rows: int
    errors: dict[str, float]
    noise: dict[str, float]
    scatter: dict[str, float]

    @property
    def within(self) -> bool:
        """Whether all means lie within 2.5 %, or are not told from that by the noise."""
        return all(abs(value) <= AGREED + 2.0 * self.noise[name]
                   for name, value in self.errors.items())


def cells(study: Study) -> list[Cell]:
    """Return the errors of left-out rows per motor and temperature."""
    bench = study.bench
    motor, sizes = bench.levels('size')
    warmth, degrees = bench.levels('temperature')
    kinds = next(iter(study.held.values())).error
    known = [kind for kind in kinds if kind != 'size']
    out = []
    for unseen, chosen in ((False, known), (True, [kind for kind in kinds if kind == 'size'])):
        if not chosen:
            continue
        losses = {name: np.mean([held.prediction[kind] for kind in chosen], axis=0)
                  * study.searches[name].path.unit for name, held in study.held.items()}
        for k, size in enumerate(sizes):
            for j, degree in enumerate(degrees):
                rows = (motor == k) & (warmth == j) & (study.weights > 0)
                if rows.any():
                    out.append(_cell(study, losses, rows, float(size), float(degree), unseen))
    return out


def _cell(study: Study, losses: dict[str, np.ndarray], rows: np.ndarray, size: float,
          degree: float, unseen: bool) -> Cell:
    bench, count = study.bench, int(rows.sum())
    errors, noise, scatter = {}, {}, {}

    def add(name: str, measured: np.ndarray, predicted: np.ndarray, sd: np.ndarray,
            turned: bool) -> None:
        """Compare sums; a resistance is the drive over the loss, so its error is turned."""
        over, under = float(np.sum(predicted)), float(np.sum(measured))
        if min(over, under) <= 0:
            return
        errors[name] = (under / over if turned else over / under) - 1.0
        noise[name] = float(np.sqrt(np.sum(sd**2))) / under
        scatter[name] = float(np.sqrt(np.mean((predicted - measured)**2)) / (under / count))

    for name, entry in study.searches.items():
        unit = entry.path.unit
        add(RESISTANCE[name], entry.path.y[rows] * unit, losses[name][rows],
            entry.path.sd[rows] * unit, True)
    leakage = losses['total'] if 'total' in losses else losses['external'] + losses['internal']
    slip = 1.0 - bench.displacement * bench.speed / bench.flow
    sd = study.noise
    add('slip', slip[rows], (leakage / bench.flow)[rows], sd['slip'][rows], False)
    torque = bench.pressure * bench.displacement - losses['torque']
    speed = (bench.flow - leakage) / bench.displacement
    power = bench.pressure * bench.flow
    add('efficiency', (bench.load_torque * bench.speed / power)[rows],
        (torque * speed / power)[rows], sd['efficiency'][rows], False)
    return Cell(size, degree, unseen, count, errors, noise, scatter)


def coverage(study: Study) -> dict[str, dict[str, float]]:
    """Return the share of left-out points inside their 95 % intervals, by path and variable."""
    out: dict[str, dict[str, float]] = {}
    for name, held in study.held.items():
        path, good = study.searches[name].path, study.weights > 0
        out[name] = {kind: float(np.mean(
            (np.abs(path.y - held.prediction[kind]) <= 1.96 * study.widen[name]
             * np.hypot(held.sd[kind], path.sd))[good])) for kind in held.error}
    return out
