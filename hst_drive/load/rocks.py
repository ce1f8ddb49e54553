# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Strength of named rocks.

Ranges after E. Hoek and E. T. Brown, Practical estimates of rock mass strength, Int. J. Rock
Mech. Min. Sci. 34(8), 1997, pp. 1165-1186, table of field estimates of the uniaxial
compressive strength: a rock spans the grades (R2 5-25, R3 25-50, R4 50-100, R5 100-250,
R6 above 250 MPa) that name it as an example. The top grade is open; 400 MPa closes it here.
"""
from __future__ import annotations

from difflib import get_close_matches
import math

# Uniaxial compressive strength, Pa.
ROCKS: dict[str, tuple[float, float]] = {name: (low * 1e6, high * 1e6) for name, low, high in (
    ('chalk', 5, 25), ('rocksalt', 5, 25), ('potash', 5, 25),
    ('coal', 25, 50), ('claystone', 25, 50), ('siltstone', 25, 50), ('concrete', 25, 50),
    ('schist', 25, 100), ('shale', 25, 100),
    ('phyllite', 50, 100), ('limestone', 50, 250), ('marble', 50, 250), ('sandstone', 50, 250),
    ('amphibolite', 100, 250), ('gabbro', 100, 250), ('granodiorite', 100, 250),
    ('rhyolite', 100, 250), ('tuff', 100, 250), ('basalt', 100, 400), ('gneiss', 100, 400),
    ('chert', 250, 400), ('diabase', 250, 400), ('granite', 250, 400), ('quartzite', 250, 400),
)}


def typical_strength(rock: str) -> float:
    """
    Return the geometric middle of a rock's range, Pa.

    Raises
    ------
    ValueError
        If the rock is not in the table; suggests the nearest.

    """
    if rock not in ROCKS:
        near = get_close_matches(rock.lower(), ROCKS, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f'known: {", ".join(sorted(ROCKS))}'
        raise ValueError(f"rock '{rock}' is not in the table; {hint} Or state its ucs")
    low, high = ROCKS[rock]
    return math.sqrt(low * high)
