# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines, hydromotor and its shaft in any circuit with two lines: text for ``circuit_code``."""
import math

from hst_drive.model.parameters import LOST


def capacity(pump_pressure, line, oil_temperature, p, on, cells, layout):
    """Return the oil that a line takes per pressure, m^3/Pa; ``line`` is 1 for A, -1 for B."""
    bulk_modulus, line_volume = p[P_bulk_modulus], p[P_volume]
    bend = (p[P_compressibility_under_pressure] - 1.0) / OIL_BENDS_AT
    compliance = (1.0 + bend * pump_pressure) / bulk_modulus
    one_line = 0.0
    # slot one_line
    if line * one_line >= 0.0:
        # slot compliance
        pass
    return line_volume * compliance


def gear(load_torque, pressure, motor_displacement, p, on, cells, layout):
    """
    Return what a play of the gear takes per pressure, m^3/Pa, or how far it was passed, rad.

    A torque that is measured behind the gear tells it without the hydromotor's own inertia.
    """
    gear_twist = gear_angle = 0.0
    if math.isnan(load_torque):
        # slot gear_twist
        pass
    else:
        # slot gear_angle
        pass
    return motor_displacement * motor_displacement * gear_twist, gear_angle


def motor_leak(pressure, motor_speed, motor_angle, oil_temperature, viscosity_ratio,
               motor_displacement, p, on, cells, layout):
    """Return what the hydromotor leaks into its case from a line under a pressure, m^3/s."""
    bulk_modulus, line_volume, oil_density = p[P_bulk_modulus], p[P_volume], p[P_oil_density]
    pistons, characterised_at = p[P_pistons], p[P_characterised_at]
    motor_leakage = p[P_motor_leakage_scale] * interpolate2(
        pressure, abs(motor_speed), T_MOTOR_LEAKAGE, cells, layout)
    flow = motor_displacement * abs(motor_speed) + motor_leakage
    motor_flow_loss = 0.0
    # slot motor_flow_loss
    return motor_leakage + motor_flow_loss


def motor_leaks(line_a_pressure, line_b_pressure, line_drop, motor_speed, motor_angle,
                oil_temperature, viscosity_ratio, motor_displacement, p, on, cells, layout):
    """
    Return what the hydromotor leaks into its case from line A and from line B, m^3/s.

    A line loses in the sense of the flow: before a hydromotor that drives, behind a braking one.
    What a formula takes it takes once, from the high line.
    """
    ahead = line_drop if motor_speed >= 0.0 else -line_drop
    a_drained = motor_leak(max(line_a_pressure - ahead, 0.0), motor_speed, motor_angle,
                           oil_temperature, viscosity_ratio, motor_displacement, p, on, cells,
                           layout)
    b_drained = motor_leak(max(line_b_pressure + ahead, 0.0), motor_speed, motor_angle,
                           oil_temperature, viscosity_ratio, motor_displacement, p, on, cells,
                           layout)
    pressure = abs(line_a_pressure - line_b_pressure)
    high_line = 1.0 if line_a_pressure >= line_b_pressure else -1.0
    motor_flow_loss_free = 0.0
    # slot motor_flow_loss free
    if high_line > 0.0:
        a_drained += motor_flow_loss_free
    else:
        b_drained += motor_flow_loss_free
    return a_drained, b_drained


def shaft(difference, measured, opposing_torque, motor_speed, motor_angle, oil_temperature,
          viscosity_ratio, motor_displacement, p, on, cells, layout):
    """
    Return torque and acceleration of the shaft, which a ``measured`` torque (or NaN) brakes.

    What is lost brakes, whether oil drives the shaft or the shaft the oil.
    """
    oil_density, pistons = p[P_oil_density], p[P_pistons]
    characterised_at = p[P_characterised_at]
    direction = smooth_sign(motor_speed * p[P_sign_scale])
    ideal, pressure = difference * motor_displacement, abs(difference)
    if p[P_by_coefficients] > 0.0:
        efficiency = 1.0 - p[P_torque_share]
        friction = p[P_torque_loss] * (p[P_coulomb] + p[P_viscous] * abs(motor_speed))
    else:
        efficiency = interpolate2(
            pressure, abs(motor_speed), T_MOTOR_EFFICIENCY, cells, layout)
        friction = 0.0
    efficiency = of_unit(
        efficiency, pressure, p[P_rated_pressure], p[P_motor_efficiency_scale], p[P_torque_loss],
        p[P_efficiency_tilt], p[P_efficiency_bend])
    drive = ideal - ((1.0 - efficiency) * abs(ideal) + friction) * direction
    load_torque = abs(drive)
    whole_load_torque = 0.0
    # slot load_torque
    motor_torque_loss = motor_torque = 0.0
    # slot motor_torque_loss
    pressure = difference   # what does not brake goes with the sense of the torque
    # slot motor_torque
    torque = motor_torque + drive - (motor_torque_loss + whole_load_torque) * direction
    braking = opposing_torque * direction + (0.0 if math.isnan(measured) else measured)
    return torque, (torque - braking) / p[P_inertia]


def motor_numbers(rig):
    """Return the parameters of this text, SI."""
    motor, line = rig.motor, rig.line
    coulomb, viscous, share = motor.torque_loss or (0.0, 0.0, 0.0)
    return {
        'motor_displacement': motor.displacement,
        'second_displacement': motor.second_displacement, 'switches_at': SWITCHES_AT,
        'inertia': motor.inertia,
        'motor_leakage_scale': 1.0, 'motor_efficiency_scale': 1.0,
        'rated_pressure': rig.rated_pressure, **dict.fromkeys(LOST.values(), 1.0),
        'pistons': float(motor.pistons), 'coulomb': coulomb, 'viscous': viscous,
        'torque_share': share, 'by_coefficients': float(motor.torque_loss is not None),
        'bulk_modulus': line.bulk_modulus, 'compressibility_under_pressure': 1.0,
        'volume': line.volume, 'oil_density': line.oil_density,
        'characterised_at': rig.characterised_at}


SCALED = {'motor.displacement': 'motor_displacement', 'motor.inertia': 'inertia',
          'line.bulk_modulus': 'bulk_modulus',
          'line.compressibility_under_pressure': 'compressibility_under_pressure',
          'motor.leakage': 'motor_leakage_scale',
          'motor.mechanical_efficiency': 'motor_efficiency_scale',
          'gear.efficiency': 'motor_efficiency_scale', **LOST}
TABLES = {'MOTOR_LEAKAGE': lambda rig: rig.motor.leakage,
          'MOTOR_EFFICIENCY': lambda rig: rig.motor.mechanical_efficiency}
SWITCHES_AT = 5.0   # V: a higher command switches to the second displacement
SIGN_SPEED = 0.01   # of the full speed, over which friction changes its sign
