# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is fitted, as a vector: factors of the unit and parameters of the effects that are on."""
from __future__ import annotations

from typing import Collection

from hst_drive.diagnose.campaign import Campaign, Model
from hst_drive.effects.formula import FORMULAS
import numpy as np

SIGMAS = 3.0    # tolerances within which the unit's factors are held


class Unknowns:
    """
    The unknowns of a model as a vector.

    A factor counts in tolerances, a parameter of an effect in its typical size (one that is
    typically 0 in the greatest it may have, if that is below 1). What is in
    ``kept``, (effect, parameter) or ('', factor), stays as the model has it.
    """

    def __init__(self, campaign: Campaign, model: Model,
                 kept: Collection[tuple[str, str]] = ()):
        self.tolerances = campaign.tolerances
        self.start = model
        factors = [('', key) for key in campaign.tolerances if ('', key) not in kept]
        self.names = (*factors,
                      *((name, key) for name, values in model.effects.items() for key in values
                        if campaign.fits(name, key) and (values[key] or name not in FORMULAS)
                        and (name, key) not in kept))
        self.factors = len(factors)     # of the unit; they come first
        self._parameter = campaign.parameter
        self.scale = np.array([self._scale(*name) for name in self.names])
        limits = [self._limits(*name) for name in self.names]
        self.bounds = np.array(limits).reshape(-1, 2)       # SI
        self.low, self.high = (self.bounds / self.scale[:, None]).T

    def _scale(self, effect: str, key: str) -> float:
        if not effect:
            return self.tolerances[key]
        parameter = self._parameter(effect, key)
        return abs(parameter.typical) or min(parameter.high, 1.0)

    def _limits(self, effect: str, key: str) -> tuple[float, float]:
        if not effect:
            return -SIGMAS * self.tolerances[key], SIGMAS * self.tolerances[key]
        parameter = self._parameter(effect, key)
        return parameter.low, parameter.high

    def pack(self, model: Model) -> np.ndarray:
        """Return the vector of a model."""
        return np.array([model.factors.get(key, 0.0) if not effect else model.effects[effect][key]
                         for effect, key in self.names]) / self.scale

    def unpack(self, vector: np.ndarray) -> Model:
        """Return the model of a vector."""
        values = np.clip(vector, self.low, self.high) * self.scale
        factors = dict(self.start.factors)
        effects = {name: dict(values) for name, values in self.start.effects.items()}
        for (effect, key), value in zip(self.names, values):
            if effect:
                effects[effect][key] = float(value)
            else:
                factors[key] = float(value)
        return Model(effects, factors)
