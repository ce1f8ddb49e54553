# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Judging a formula on rows that it was not fitted to: leave one level out."""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.losses.fit import Fit, predict_sd
from hst_drive.losses.forms import Form
from hst_drive.losses.paths import fit_path, Path
import numpy as np


class HeldOut(NamedTuple):
    """
    Predictions of rows by fits without them, by variable whose levels were left out.

    ``prediction`` and ``sd`` (of the curve, without the sensors' noise) are in the path's scale;
    ``error`` is measured minus predicted over the noise.
    """

    prediction: dict[str, np.ndarray]
    sd: dict[str, np.ndarray]
    error: dict[str, np.ndarray]

    def rms(self, weights: np.ndarray, kinds: tuple[str, ...] | None = None) -> float:
        """Return the error in units of the noise; all (or the chosen) variables count alike."""
        mean = [np.average(_bounded(error)**2, weights=weights)
                for kind, error in self.error.items() if kinds is None or kind in kinds]
        return float(np.sqrt(np.mean(mean)))


def _bounded(error: np.ndarray) -> np.ndarray:
    """Bound errors so that one wild extrapolation does not decide alone."""
    return np.clip(error, -1e3, 1e3)


def held_out(path: Path, form: Form, full: Fit, kinds: tuple[str, ...] | None = None,
             spread: bool = False) -> HeldOut:
    """
    Leave each level of each variable out in turn, and predict it.

    Parameters
    ----------
    path, form, full : Path, Form, Fit
        The loss, the formula, and its fit to all rows (start and row weights).
    kinds : tuple of str, optional
        Variables; by default all of the path.
    spread : bool
        Whether to find ``sd`` as well.

    """
    prediction, sd, error = {}, {}, {}
    for kind, labels in path.groups.items():
        if kinds is not None and kind not in kinds:
            continue
        out, curve = np.full(len(path.y), np.nan), np.full(len(path.y), np.nan)
        for level in range(labels.max() + 1):
            away = labels == level
            fit = fit_path(path, form, full.values, full.weights, ~away, steps=8)
            there = path.x.rows(away)
            out[away] = form(fit.values, there)
            if spread:
                curve[away] = predict_sd(fit, form, there)
        prediction[kind], sd[kind] = out, curve
        error[kind] = (path.y - out) / path.sd
    return HeldOut(prediction, sd, error)


def widening(path: Path, found: HeldOut, weights: np.ndarray, share: float = 0.95) -> float:
    """
    Return by what to widen intervals so that they hold ``share`` of the held-out points.

    The stated interval is 1.96 standard deviations of curve and noise; the factor is at least 1.
    """
    ratios = [np.abs(path.y - found.prediction[kind])[weights > 0]
              / (1.96 * np.hypot(found.sd[kind], path.sd)[weights > 0]) for kind in found.error]
    each = [np.sort(entry)[min(int(np.ceil(share * (len(entry) + 1))) - 1, len(entry) - 1)]
            for entry in ratios if len(entry)]
    return float(max([1.0, *each]))
