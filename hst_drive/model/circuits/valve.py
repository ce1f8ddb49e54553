# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A hydromotor behind a proportional valve on a supply of constant, or measured, pressure.

An opening above 0 lets oil from the supply into line A and from line B to the return, one edge
each; below 0 the other way. Signs as in ``closed``.
"""
import math

from hst_drive.channels import LINES
from hst_drive.model.circuits.base import Balance, Circuit, Input, OF_A_LEAK, Part, State
from hst_drive.model.circuits.motor_text import (
    capacity, gear, motor_leak, motor_leaks, motor_numbers, SCALED, shaft, SIGN_SPEED,
    TABLES)
from hst_drive.model.compose import CONSTANTS
from hst_drive.model.kernel_template import of_unit
from hst_drive.rig import Rig

_OPEN = 0.05        # of the stroke: a spool nearer to its middle tells nothing of its edges
_EDGES = 0.02       # of the return's pressure: it goes with the square of an edge's opening
_STEP = 0.2         # of the time in which an edge fills a line at a hundredth of the supply
_SMOOTH = 1e-3      # of the supply: a drop below it makes a laminar flow


def hold(valve_command, interval, memory, p, on, cells, layout):
    """Return what holds until the next row: aim of the spool (of its stroke) and its lag, s."""
    valve_lag = p[P_valve_lag]
    # slot valve_command
    # slot valve_lag
    aim = interpolate(valve_command, T_OPENING, cells, layout)
    return aim, max(valve_lag, 1e-4)


def edge(drop, opening, p):
    """Return the flow through an edge, m^3/s: turbulent, laminar about no drop."""
    return p[P_valve_gain] * opening * drop / (drop * drop + p[P_smooth] * p[P_smooth])**0.25


def actuator(opening, line_a_pressure, line_b_pressure, motor_speed, motor_angle, aim, lag,
             supply_measured, oil_temperature, viscosity_ratio, motor_torque_load,
             opposing_torque, motor_displacement_command, p, on, cells, layout):
    """Return the rate of the opening."""
    return (aim - opening) / lag


def equations(opening, line_a_pressure, line_b_pressure, motor_speed, motor_angle, aim, lag,
              supply_measured, oil_temperature, viscosity_ratio, motor_torque_load,
              opposing_torque, motor_displacement_command, p, on, cells, layout):
    """Return the rates of the other states, then the quantities."""
    motor_displacement = p[P_motor_displacement]
    if motor_displacement_command > p[P_switches_at] and p[P_second_displacement] > 0.0:
        motor_displacement = p[P_second_displacement]
    bulk_modulus, line_volume, oil_density = p[P_bulk_modulus], p[P_volume], p[P_oil_density]
    pistons, characterised_at = p[P_pistons], p[P_characterised_at]
    difference = line_a_pressure - line_b_pressure
    side = 1.0 if difference >= 0.0 else -1.0
    pump_pressure, pressure = max(line_a_pressure, line_b_pressure, 0.0), abs(difference)
    forwards = 1.0 if motor_speed >= 0.0 else -1.0
    swept = motor_displacement * motor_speed
    flow = abs(swept)
    line_drop = 0.0
    # slot line_drop
    back_pressure = 0.0
    # slot back_pressure
    a_drained, b_drained = motor_leaks(
        line_a_pressure, line_b_pressure, line_drop, motor_speed, motor_angle, oil_temperature,
        viscosity_ratio, motor_displacement, p, on, cells, layout)
    cross_port_flow = motor_flow_loss_kept = 0.0
    # slot cross_port_flow
    # slot motor_flow_loss kept
    across = side * (cross_port_flow + motor_flow_loss_kept)
    a_loss, b_loss = a_drained + across, b_drained - across
    supply = p[P_supply]
    if not math.isnan(supply_measured):
        supply = supply_measured
    if opening >= 0.0:
        into_a = edge(supply - line_a_pressure, opening, p)
        into_b = edge(back_pressure - line_b_pressure, opening, p)
    else:
        into_a = edge(back_pressure - line_a_pressure, -opening, p)
        into_b = edge(supply - line_b_pressure, -opening, p)
    twisted, gear_angle = gear(
        motor_torque_load, pressure, motor_displacement, p, on, cells, layout)
    a_storage = twisted + capacity(line_a_pressure, 1.0, oil_temperature, p, on, cells, layout)
    b_storage = twisted + capacity(line_b_pressure, -1.0, oil_temperature, p, on, cells, layout)
    a_rate = (into_a - swept - a_loss) / a_storage
    b_rate = (into_b + swept - b_loss) / b_storage
    if line_a_pressure <= CAVITATION_PRESSURE:
        a_rate = max(a_rate, 0.0)
    if line_b_pressure <= CAVITATION_PRESSURE:
        b_rate = max(b_rate, 0.0)
    motor_torque, acceleration = shaft(
        difference - 2.0 * line_drop * forwards, motor_torque_load, opposing_torque, motor_speed,
        motor_angle, oil_temperature, viscosity_ratio, motor_displacement, p, on, cells, layout)
    # What goes back through its edge tells the pressure before it.
    wide = max(abs(opening), 0.01) * p[P_valve_gain]
    a_returns, b_returns = max(-swept - a_loss, 0.0) / wide, max(swept - b_loss, 0.0) / wide
    forth = opening / p[P_open]
    return (a_rate, b_rate, acceleration, motor_speed,
            (into_a - a_loss) / motor_displacement, -(into_b - b_loss) / motor_displacement,
            back_pressure + a_returns * a_returns, back_pressure + b_returns * b_returns,
            2.0 * a_returns / wide * a_storage, 2.0 * b_returns / wide * b_storage,
            motor_torque, a_drained + b_drained, swept + a_drained + side * motor_flow_loss_kept,
            a_storage / motor_displacement, -b_storage / motor_displacement, gear_angle,
            p[P_inertia], forth, -forth)


def numbers(rig: Rig) -> dict[str, float]:
    """Return the parameters of the equations, SI."""
    valve, supply, found = rig.valve, rig.supply.pressure, motor_numbers(rig)
    gain = valve.rated_flow / math.sqrt(valve.rated_pressure_drop)
    full = gain * math.sqrt(supply / 2.0) / found['motor_displacement']
    return {**found, 'valve_lag': valve.lag, 'valve_gain': gain, 'supply': supply,
            'smooth': _SMOOTH * supply, 'open': _OPEN,
            'sign_scale': CONSTANTS['SIGN_WIDTH'] / (SIGN_SPEED * full)}


def steps(found: dict[str, float]) -> tuple[float, float]:
    """Return the longest integration step, s, and the one where all that is fast is measured."""
    steepest = found['valve_gain'] / math.sqrt(0.01 * found['supply'])
    return min(_STEP * found['volume'] / found['bulk_modulus'] / steepest,
               found['valve_lag']), found['valve_lag']


CIRCUIT = Circuit(
    id='valve',
    title='valve circuit: supply, proportional valve, hydromotors',
    hold=hold, actuator=actuator, equations=equations,
    helpers=(of_unit, edge, capacity, gear, motor_leak, motor_leaks, shaft), numbers=numbers,
    steps=steps, sections=('supply', 'valve', 'motor', 'line'),
    keys=('motor.displacement_cc_rev', 'motor.inertia_total_kg_m2', 'line.volume_m3',
          'line.bulk_modulus_Pa'),
    tables={'OPENING': lambda rig: rig.valve.opening, **TABLES},
    scaled={'valve.rated_flow': 'valve_gain', 'valve.lag': 'valve_lag', **SCALED},
    states=(State('opening', '1'),
            State('line_a_pressure', 'Pa', least=CONSTANTS['CAVITATION_PRESSURE']),
            State('line_b_pressure', 'Pa', least=CONSTANTS['CAVITATION_PRESSURE']),
            State('motor_speed', 'rad/s'), State('motor_angle', 'rad')),
    held_inputs=(Input('valve_command'),),
    inputs=(Input('pump_outlet_pressure', math.nan), Input('oil_temperature'),
            Input('viscosity_ratio', 1.0), Input('motor_torque', math.nan),
            Input('opposing_torque'), Input('motor_displacement_command')),
    quantities=('speed_by_a', 'speed_by_b', 'a_return', 'b_return', 'a_settles', 'b_settles',
                'motor_torque', 'case_drain_flow', 'motor_inlet_flow', 'a_storage', 'b_storage',
                'gear_angle', 'inertia', 'forth', 'back'),
    balances=(
        Balance('feeding edge', 'motor_speed', 'flow',
                'oil between valve and hydromotor',
                (Part('speed_by_a', 'forth', 'line_a_pressure', 'a_storage', 'gear_angle'),
                 Part('speed_by_b', 'back', 'line_b_pressure', 'b_storage', 'gear_angle')),
                needs=('valve_command', *LINES), swept=True,
                formula='formula_motor_flow', id='pump_flow'),
        Balance('returning edge A', 'line_a_pressure', 'flow', 'pressure of the return',
                (Part('a_return', 'back', 'line_a_pressure', 'a_settles'),),
                needs=('valve_command', 'motor_speed', 'line_b_pressure'), sheet=_EDGES),
        Balance('returning edge B', 'line_b_pressure', 'flow', 'pressure of the return',
                (Part('b_return', 'forth', 'line_b_pressure', 'b_settles'),),
                needs=('valve_command', 'motor_speed', 'line_a_pressure'), sheet=_EDGES),
        Balance('shaft', 'motor_torque', 'torque', 'torque of the hydromotor',
                (Part('motor_torque', '', 'motor_speed', 'inertia'),),
                needs=('motor_speed', *LINES), formula='formula_torque'),
        Balance('hydromotor flow', 'motor_inlet_flow', 'flow',
                'oil that turns the hydromotor', (Part('motor_inlet_flow'),),
                needs=('motor_speed', *LINES), formula='formula_motor_flow', id='motor_flow'),
        Balance('case drain', 'case_drain_flow', 'flow', 'leakage of the hydromotor',
                (Part('case_drain_flow'),), needs=('motor_speed', *LINES),
                formula='formula_motor_flow', sheet=OF_A_LEAK),
    ),
)
