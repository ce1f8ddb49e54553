# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What an effect is, listed or not: where it enters, its forms, and how large it may be."""
from collections.abc import Callable
from typing import NamedTuple

from bench.unseen.machine import Machine
import numpy as np


class Scale(NamedTuple):
    """Quantities of one rig by which sizes are measured, so that they fit a rig of any size."""

    pressure: float
    flow: float
    torque: float
    speed: float
    stroke: float
    volume: float
    inertia: float
    modulus: float
    lag: float
    brake_lag: float


def scale_of(m: Machine) -> Scale:
    """Return 100 bar, 10 rad/s, and what the motor takes and gives there."""
    return Scale(1e7, m.displacement * 10, m.displacement * 1e7, 10.0,
                 float(m.stroke_values[-1]), m.volume, m.inertia, m.bulk_modulus, m.stroke_lag,
                 m.loading_lag)


# A form takes its size, a function that gives random numbers of its own (low, high) and the scale
# of the rig. It returns its main value in SI and what it changes: fields of a Machine; of a
# sensor ('sensor.*'), of the oil ('oil.*') or of what happens when ('event').
Form = Callable[[float, Callable[[float, float], float], Scale], tuple[float, dict]]


class Fault(NamedTuple):
    """An effect; a size between `low` and `high` is within what happens to real drives."""

    id: str
    enters: str
    signal: str
    parameter: str
    unit: str
    low: float
    high: float
    forms: tuple[tuple[str, Form], ...]
    note: str
    # By form ('' for all): ids that would be right as well.
    also: dict[str, tuple[str, ...]]
    # Rows no slower than this, s: a slower logger would not see it at all.
    row: float = 0.05


class Drawn(NamedTuple):
    """One effect of one campaign: which form, with which random numbers of its own."""

    fault: Fault
    form: int
    seed: int

    @property
    def form_name(self) -> str:
        """Return the name of the form."""
        return self.fault.forms[self.form][0]

    @property
    def also(self) -> tuple[str, ...]:
        """Return the ids that would be right as well."""
        return self.fault.also.get('', ()) + self.fault.also.get(self.form_name, ())

    def at(self, size: float, scale: Scale) -> tuple[float, dict]:
        """Return the main value and the changes at a size; the same numbers at each call."""
        rng = np.random.default_rng(self.seed)
        return self.fault.forms[self.form][1](
            size, lambda low, high: float(rng.uniform(low, high)), scale)


def draw(fault: Fault, rng: np.random.Generator) -> Drawn:
    """Choose a form and the seed of its random numbers."""
    return Drawn(fault, int(rng.integers(len(fault.forms))), int(rng.integers(2 ** 31)))
