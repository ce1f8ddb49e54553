# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is fitted, as a vector: factors of the unit and parameters of the effects that are on."""
from __future__ import annotations

from typing import Collection

from hst_drive.effects import effect_of
from hst_drive.effects.formula import FORMULAS
from hst_drive.effects.slots import LEAKS
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.model import Model
import numpy as np

SIGMAS = 3.0    # tolerances within which the unit's factors are held


class Unknowns:
    """
    The unknowns of a model as a vector.

    A factor or a sensor's zero or delay counts in tolerances, a parameter of an effect in its
    typical size (one that is typically 0 in the greatest it may have). What is in ``kept``,
    (effect, parameter) or ('', factor, channel or 'channel.delay'), stays as the model has it; a
    zero of which an effect says all (``Effect.zero_of``) is none.

    Where factors are known together (``Campaign.ties``), the unknowns are those mixtures that are
    independent, each the nearest to its factor: the root of the correlation is symmetric. So the
    prior is one of independent unknowns of size 1 in either case.
    """

    def __init__(self, campaign: Campaign, model: Model,
                 kept: Collection[tuple[str, str]] = ()):
        self.tolerances = campaign.sigmas
        self.start = model
        self._zeros, self._delays = campaign.zeros, campaign.delays
        self._said = {channel for name in model.effects for channel in effect_of(name).zero_of}
        factors = [('', key) for key in self.tolerances
                   if key not in self._said and ('', key) not in kept]
        self.names = (*factors,
                      *((name, key) for name, values in model.effects.items() for key in values
                        if campaign.fits(name, key) and (values[key] or name not in FORMULAS)
                        and (name, key) not in kept))
        self.factors = len(factors)     # of the unit; they come first
        self._added = campaign.commissioned_unit and any(
            key in LEAKS.values() for _, key in factors)
        values, vectors = np.linalg.eigh(np.reshape(
            [campaign.ties.get((one, other), float(one == other))
             for _, one in factors for _, other in factors], (len(factors), -1 if factors else 0)))
        self._root = (vectors * np.sqrt(values)) @ vectors.T
        ranges = np.array([_range(campaign, *name) for name in self.names]).reshape(-1, 3)
        self.scale, self.bounds = ranges[:, 0], ranges[:, 1:]      # SI
        self.low, self.high = (self.bounds / self.scale[:, None]).T

    def mix(self, vectors: np.ndarray) -> np.ndarray:
        """Return values, SI, of vectors of the unknowns, or columns of such vectors."""
        values = np.array(vectors, dtype=float)
        values[:self.factors] = self._root @ values[:self.factors]
        return (values.T * self.scale).T

    def pack(self, model: Model) -> np.ndarray:
        """Return the vector of a model."""
        unit = model.unit
        vector = np.array([unit.get(key, 0.0) if not effect else model.effects[effect][key]
                           for effect, key in self.names]) / self.scale
        vector[:self.factors] = np.linalg.solve(self._root, vector[:self.factors])
        return vector

    def unpack(self, vector: np.ndarray) -> Model:
        """Return the model of a vector."""
        values = self.mix(np.clip(vector, self.low, self.high))
        factors = dict(self.start.factors)
        zeros = {key: value for key, value in self.start.zeros.items() if key not in self._said}
        delays = dict(self.start.delays)
        read = {**dict.fromkeys(self._zeros, zeros), **dict.fromkeys(self._delays, delays)}
        effects = {name: dict(values) for name, values in self.start.effects.items()}
        for (effect, key), value in zip(self.names, values):
            known = effects[effect] if effect else read.get(key, factors)
            known[key] = float(value)
        return Model(effects, factors, zeros, delays, self._added)


def _range(campaign: Campaign, effect: str, key: str) -> tuple[float, float, float]:
    """Return in what an unknown is counted, and its bounds, SI."""
    if not effect:
        sigma = campaign.sigmas[key]
        return sigma, max(-SIGMAS * sigma, campaign.least(key)), SIGMAS * sigma
    entry = campaign.parameter(effect, key)
    return abs(entry.typical) or max(entry.high, -entry.low), entry.low, entry.high
