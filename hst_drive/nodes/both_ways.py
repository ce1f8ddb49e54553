# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a controller has to know of a pump over centre. No ROS here."""
from __future__ import annotations

from hst_drive.errors import InputError
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
import numpy as np

_NOTHING = 1e-3     # of the largest displacement


def dead_band_of(rig: Rig) -> float:
    """
    Return how far (V) to both sides of 0 V the pump gives nothing; 0 on the open circuit.

    Raises
    ------
    InputError
        If 0 V is no zero stroke: a stop could not end there.

    """
    if rig.circuit == OPEN:
        return 0.0
    law, limits = rig.pump.displacement, rig.controller.output_limits
    if abs(law(0.0)) > _NOTHING * rig.pump.max_displacement:
        raise InputError(f'{rig.source}: pump.displacement_vs_command: is not 0 at 0 V, where a '
                         'stop ends; shift the commands so that zero stroke is at 0 V')
    commands = np.linspace(0.0, min(abs(limit) for limit in limits if limit), 1001)
    gives = np.maximum(np.abs(law(commands)), np.abs(law(-commands)))
    some = np.flatnonzero(gives > _NOTHING * rig.pump.max_displacement)
    return float(commands[max(some[0] - 1, 0)]) if len(some) else 0.0
