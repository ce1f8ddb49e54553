# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Layered ground: rock strength over depth becomes bit torque over time.

The energy balance of rotary drilling, R. Teale, The concept of specific energy in rock drilling,
Int. J. Rock Mech. Min. Sci. 2, 1965, pp. 57-73::

    e = F / A + 2 pi n T / (A u)

with specific energy e (Pa), thrust F, bit area A, speed n, torque T and penetration rate u. At
its best e is near the compressive strength of the rock, in practice a multiple of it:
``e = UCS / efficiency``; about 0.35 is what F. E. Dupriest and W. L. Koederitz (SPE/IADC 92194,
2005) take for bits in good order. The bit takes a depth of cut ``d = u / n`` per revolution
that thrust and rock set, not the speed. So::

    T = T_free + (UCS / efficiency - F / A) * A * d / (2 pi)

T_free turns the string in the hole without drilling: measured rig torque never starts at zero.
"""
from __future__ import annotations

from dataclasses import dataclass
import math

from hst_drive.load.profiles import Points, Profile
import numpy as np

_REV = 2.0 * math.pi
_FINEST = 200_000  # depth steps: enough for a deep hole, small enough to build in a second


@dataclass(frozen=True)
class Layer:
    """
    A layer of rock.

    Attributes
    ----------
    rock : str
        Name.
    thickness : float
        m.
    ucs : float
        Uniaxial compressive strength, Pa.
    roughness : float
        Standard deviation of the strength relative to ``ucs``.
    roughness_length : float
        Depth over which the strength's deviation falls to 1/e in correlation, m.

    """

    rock: str
    thickness: float
    ucs: float
    roughness: float = 0.0
    roughness_length: float = 1e-3


@dataclass(frozen=True)
class Bit:
    """
    A bit and how it is driven.

    Attributes
    ----------
    diameter : float
        m.
    depth_of_cut : float
        Per revolution in rock of ``at_strength``, m/rev.
    at_strength : float
        Pa.
    strength_exponent : float
        ``d = depth_of_cut * (at_strength / UCS) ** strength_exponent``. 0: constant feed rate.
        0.61: constant thrust, the exponent of UCS for rotary blast hole drills in
        S. Kahraman, Int. J. Rock Mech. Min. Sci. 36, 1999, pp. 981-989.
    efficiency : float
        UCS over specific energy.
    weight : float
        Thrust on the bit, N.
    height : float
        Depth over which the bit passes from one rock into the next, m.
    free_torque : float
        Torque that turns the string without drilling, N.m.

    """

    diameter: float
    depth_of_cut: float
    at_strength: float = 60e6
    strength_exponent: float = 0.0
    efficiency: float = 0.35
    weight: float = 0.0
    height: float = 2e-3
    free_torque: float = 0.0

    @property
    def area(self) -> float:
        """Area of the hole, m^2."""
        return 0.25 * math.pi * self.diameter**2

    def cut(self, strength):
        """Return the depth of cut per revolution, m, in rock of a strength in Pa."""
        return self.depth_of_cut * (self.at_strength / strength)**self.strength_exponent

    def cutting_torque(self, strength):
        """Return the torque above ``free_torque``, N.m; 0 where the thrust alone breaks it."""
        work = np.maximum(strength / self.efficiency - self.weight / self.area, 0.0)
        return work * self.area * self.cut(strength) / _REV


class Ground(Points):
    """
    Bit torque over time in layered ground, at the hydromotor shaft, N.m.

    Parameters
    ----------
    layers : sequence of Layer
        From the top; the last one goes on below its thickness.
    bit : Bit
        How it is drilled.
    speed : Profile
        Speed of the bit, rad/s: the set point.
    duration : float
        s.
    start : float
        When the bit touches the rock, s. Before, ``bit.free_torque``.
    seed : int
        Of the roughness; the same seed gives the same rock.
    scale : float
        Rig torque over bit torque, for a rig smaller than the drill it stands for.

    Attributes
    ----------
    time, depth, strength, torque : ndarray, shape (n,)
        s, m, Pa, N.m; torque is what the profile returns.
    layers : tuple of Layer
        The ground.
    notes : tuple of str
        What the reader should know.

    """

    def __init__(self, layers: list[Layer], bit: Bit, speed: Profile, duration: float, *,
                 start: float = 0.0, seed: int = 0, scale: float = 1.0):
        self.layers = tuple(layers)
        # 10 ms: several times below the PPRV's lag. Long runs get a coarser grid.
        count = int(min(max(duration / 0.01, 100.0), 500_000.0))
        self.time = np.linspace(0.0, duration, count + 1)
        turning = np.where(self.time > start, np.maximum(speed.sample(self.time), 0.0), 0.0)
        angle = _cumulative(turning, self.time)
        deepest = max(bit.cut(layer.ucs) for layer in layers) * angle[-1] / _REV
        top = float(sum(layer.thickness for layer in layers))
        # Soft spots are drilled faster than the mean: leave room below.
        grid, rock = _strength(layers, bit, max(1.5 * deepest, top) + bit.height, seed)
        turned = _cumulative(_REV / bit.cut(rock), grid)
        self.depth = np.interp(angle, turned, grid)
        self.strength = np.interp(self.depth, grid, rock)
        self.torque = scale * (bit.free_torque + np.where(
            turning > 0.0, bit.cutting_torque(self.strength), 0.0))
        super().__init__(self.time, self.torque)
        self.notes: tuple[str, ...] = ()
        if self.depth[-1] > top:
            self.notes = (f'the bit leaves the described ground at {top:.4g} m; the last layer '
                          f'is drilled on to {self.depth[-1]:.4g} m',)


def _cumulative(rate: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the integral from the first point to each point (trapezia)."""
    return np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(x))))


def _strength(layers: list[Layer], bit: Bit, depth: float,
              seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return depth grid and the strength that the bit meets there."""
    finest = min([bit.height / 8.0, depth / 2000.0,
                  *(layer.roughness_length / 4.0 for layer in layers if layer.roughness > 0.0)])
    grid = np.linspace(0.0, depth, min(max(int(depth / finest), 2000), _FINEST))
    step = grid[1]
    bottoms = np.cumsum([layer.thickness for layer in layers])
    index = np.minimum(np.searchsorted(bottoms, grid, side='right'), len(layers) - 1)
    rock = np.array([layer.ucs for layer in layers])[index]
    # The bit is in the new rock with the share of its height that is below the boundary.
    width = max(int(round(bit.height / step)), 1)
    rock = np.convolve(np.concatenate((np.full(width - 1, rock[0]), rock)),
                       np.full(width, 1.0 / width), mode='valid')
    for number, layer in enumerate(layers):
        inside = index == number
        if layer.roughness > 0.0 and inside.any():
            deviation = _coloured(int(inside.sum()), step / layer.roughness_length, seed, number)
            rock[inside] *= np.maximum(1.0 + layer.roughness * deviation, 0.1)
    return grid, rock


def _coloured(count: int, step: float, seed: int, number: int) -> np.ndarray:
    """Return a stationary Gauss-Markov sequence of unit variance, correlation exp(-step)."""
    white = np.random.default_rng([seed, number]).standard_normal(count).tolist()
    keep = math.exp(-step)
    fresh = math.sqrt(1.0 - keep * keep)
    values = [white[0]]
    for value in white[1:]:
        values.append(keep * values[-1] + fresh * value)
    return np.array(values)
