# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One thing that is wrong with a machine, with one number that says how much."""
from collections.abc import Callable
from dataclasses import dataclass

from bench.frozen.sensors import Fault
import numpy as np


def nothing(size: float) -> dict:
    """Change nothing."""
    return {}


@dataclass(frozen=True)
class Kind:
    """
    What is wrong.

    Attributes
    ----------
    id : str
        Of EFFECTS.md, or an own name.
    enters : str
        flow, torque, pump_actuator, load or sensor.
    low, high : float
        Bounds of the size that a machine can plausibly have.
    plant : Callable
        Size to changed numbers of the Plant.
    sensor, word : Callable
        Size to faults of readings: before noise, and of the converter after it.
    shake : Callable, optional
        Generator and time [s] of each millisecond to the disturbance of a log.
    needs : tuple of str
        Channels that must be in the log.
    parameters : Callable
        Size to what truth.json tells besides the changed numbers.
    wide : bool
        The oil's temperature changes much.
    heavy : bool
        The rock must be hard.
    slowest_ms : int
        Rows may not be further apart than this.
    effects : tuple of str
        Listed effects that are a true, if partial, name of it.
    neutral : float
        The size at which nothing is wrong.
    sizes : tuple of float
        Where only these sizes are possible.
    note : str
        What it is.

    """

    id: str
    enters: str
    low: float
    high: float
    plant: Callable[[float], dict] = nothing
    sensor: Callable[[float], dict[str, Fault]] = nothing
    word: Callable[[float], dict[str, Fault]] = nothing
    shake: Callable[[np.random.Generator, np.ndarray], np.ndarray] | None = None
    needs: tuple[str, ...] = ()
    parameters: Callable[[float], dict] = nothing
    wide: bool = False
    heavy: bool = False
    slowest_ms: int = 50
    effects: tuple[str, ...] = ()
    neutral: float = 0.0
    sizes: tuple[float, ...] = ()
    note: str = ''
