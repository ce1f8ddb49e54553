# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is fitted: the effects that are on, and how this unit is off its datasheet."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
import math

from hst_drive.effects.slots import LEAKS

_HALF = 0.5     # of a leakage: below, it falls by its logarithm


def _linear(share: float) -> float:
    return 1.0 + share if share >= -_HALF else _HALF * math.exp((share + _HALF) / _HALF)


@dataclass(frozen=True)
class Model:
    """
    Effects that are on and how this unit is off its datasheet.

    Attributes
    ----------
    effects : dict of str to dict of str to float
        Id to parameters, SI.
    factors : dict of str to float
        Natural logarithm of the factor on each quantity of ``rig.tolerances``.
    zeros : dict of str to float
        What each sensor reads beyond the truth throughout, by channel, SI.
    delays : dict of str to float
        How late each sensor reads, by 'channel.delay', s.
    added : bool
        Whether leakages are off by shares instead: of a machine that was commissioned. They add
        up, and where their sum alone is known, moving along it must not change it.

    """

    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)
    zeros: dict[str, float] = field(default_factory=dict)
    delays: dict[str, float] = field(default_factory=dict)
    added: bool = False

    @property
    def unit(self) -> dict[str, float]:
        """All that tells this unit, and its sensors, from their datasheets."""
        return {**self.factors, **self.zeros, **self.delays}

    @property
    def scales(self) -> dict[str, float]:
        """Factor on each quantity."""
        return {key: _linear(value) if self.added and key in LEAKS.values() else math.exp(value)
                for key, value in self.factors.items()}

    def with_effect(self, name: str, values: dict[str, float]) -> Model:
        """Return a model with one effect more, or with other parameters for it."""
        return replace(self, effects={**self.effects, name: dict(values)})

    def without(self, *names: str) -> Model:
        """Return a model without some effects."""
        return replace(self, effects={key: value for key, value in self.effects.items()
                                      if key not in names})
