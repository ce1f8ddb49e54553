# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Small functions of the equations: look-up on even grids, a round corner, orifice, oil."""
import math

from bench.frozen.jit import njit


@njit
def along(values, top, x):
    """Look a curve on an even grid from 0 to top up."""
    at = min(max(x / top, 0.0), 1.0) * (len(values) - 1)
    i = min(int(at), len(values) - 2)
    return values[i] + (at - i) * (values[i + 1] - values[i])


@njit
def over(values, top, top_across, x, y):
    """Look a chart on an even grid up."""
    at = min(max(x / top, 0.0), 1.0) * (values.shape[0] - 1)
    across = min(max(y / top_across, 0.0), 1.0) * (values.shape[1] - 1)
    i = min(int(at), values.shape[0] - 2)
    j = min(int(across), values.shape[1] - 2)
    a, b = at - i, across - j
    low = values[i, j] + b * (values[i, j + 1] - values[i, j])
    high = values[i + 1, j] + b * (values[i + 1, j + 1] - values[i + 1, j])
    return low + a * (high - low)


@njit
def ramp(x):
    """Return x above 0 and 0 below, with a round corner of width 1."""
    if x > 30.0:
        return x
    if x < -30.0:
        return 0.0
    return math.log1p(math.exp(x))


@njit
def root(p, density):
    """Flow speed [m/s] through an orifice; laminar below 0.5 bar."""
    return p * math.sqrt(2.0 / density) / (p * p + 2.5e9) ** 0.25


@njit
def thinner(oil):
    """How many times thinner the oil is than at 50 degC (ASTM D341, ISO VG 46)."""
    x = 10.0 ** (10.0 ** (9.417992555 - 3.684441498 * math.log10(oil + 273.15))) - 0.7
    return 29.97299 / x
