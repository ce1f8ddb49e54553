# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Hydromotors alike on a common gear, seen from the shaft behind it: one motor that does all."""
from __future__ import annotations

from dataclasses import replace

from hst_drive.rig.rig import Gear, Motor
from hst_drive.rig.tables import Surface


def at_measured_shaft(motor: Motor, gear: Gear | None) -> Motor:
    """
    Return the one hydromotor that acts as all of them do at the measured shaft.

    Displacement and leakage count as often as there are motors; speeds are those of that shaft,
    and of the torque the gear takes its share.
    """
    ratio, efficiency = (gear.ratio, gear.efficiency) if gear else (1.0, 1.0)
    if motor.count == 1 and ratio == efficiency == 1.0:
        return motor
    many = motor.count * ratio
    leakage, mechanical = motor.leakage, motor.mechanical_efficiency
    losses = motor.torque_loss
    if losses:
        coulomb, viscous, share = losses
        losses = (coulomb * many * efficiency, viscous * many * ratio * efficiency,
                  1.0 - (1.0 - share) * efficiency)
    return replace(
        motor, displacement=motor.displacement * many,
        second_displacement=motor.second_displacement * many,
        leakage=Surface(leakage.x, leakage.y / ratio, leakage.z * motor.count),
        mechanical_efficiency=Surface(mechanical.x, mechanical.y / ratio,
                                      mechanical.z * efficiency),
        torque_loss=losses, pistons=motor.pistons * ratio)
