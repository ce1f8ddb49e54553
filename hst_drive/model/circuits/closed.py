# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The closed circuit: over-centre pump, two lines, charge pump, cross-port reliefs, hydromotors.

Signs as in ISO 4391: stroke, flow, speed and torque are positive in the drilling direction, where
line A carries the pressure. What leaks goes to the cases, from each line at its pressure. The
equations refer to the measured shaft, behind the gear if there is one.
"""
import math

from hst_drive.channels import LINES
from hst_drive.model.circuits.base import (
    Balance, Circuit, Input, OF_A_FLOW, OF_A_LEAK, Part, State)
from hst_drive.model.circuits.motor_text import (
    capacity, gear, motor_leak, motor_leaks, motor_numbers, SCALED, shaft, SIGN_SPEED,
    TABLES)
from hst_drive.model.compose import CONSTANTS
from hst_drive.model.kernel_template import of_unit, waved
from hst_drive.model.lags import held_share
from hst_drive.model.parameters import ACTUATOR, actuator_numbers
from hst_drive.rig import Rig

_MARGIN = 0.015     # of the relief pressure: so far above the charge pressure a line is high
_STEP = 2.0         # of the time in which the check valves fill the low line
_EMPTY = CONSTANTS['CAVITATION_PRESSURE']
_STROKE = 'pump_command|pump_displacement'


def hold(pump_command, interval, memory, p, on, cells, layout):
    """
    Return what holds until the next row: aim of the plate (m^3/rad), lag, rates, command.

    ``memory`` keeps both halves of a play, the last command and what stands before the plate.
    """
    pump_play = pump_play_softness = pump_play_spread = 0.0
    pump_lag = p[P_displacement_lag]
    pump_series_lag = max(p[P_displacement_series_lag] - 1.0, 0.0) * pump_lag
    pump_stroke_time = pump_stroke_asymmetry = 0.0
    max_displacement = p[P_max_displacement]
    # slot pump_command
    # slot pump_play
    # slot pump_play_softness
    # slot pump_play_spread
    # slot pump_lag
    # slot pump_series_lag
    # slot pump_stroke_time
    # slot pump_stroke_asymmetry
    if math.isnan(memory[0]):
        memory[0] = memory[1] = memory[2] = pump_command
    whole_command = pump_command
    if pump_play > 0.0:
        memory[0] = played(memory[0], memory[2], whole_command,
                           0.5 * pump_play * (1.0 - pump_play_spread), pump_play_softness)
        memory[1] = played(memory[1], memory[2], whole_command,
                           0.5 * pump_play * (1.0 + pump_play_spread), pump_play_softness)
        pump_command = 0.5 * (memory[0] + memory[1])
    memory[2] = whole_command
    aim = p[P_displacement_scale] * waved(
        interpolate(pump_command, T_DISPLACEMENT, cells, layout),
        pump_command, p[P_lowest_command], p[P_command_range],
        p[P_displacement_wave_1], p[P_displacement_wave_2], p[P_displacement_wave_3])
    if math.isnan(memory[3]):
        memory[3] = aim
    if pump_series_lag > 0.0 and interval > 0.0:
        # What stands before the plate moves until the next row.
        ahead = memory[3] - aim
        memory[3] = aim + ahead * math.exp(-interval / pump_series_lag)
        aim += ahead * held_share(pump_series_lag, max(pump_lag, 1e-4), interval)
    rate = back_rate = 0.0
    if pump_stroke_time > 0.0:
        rate = max_displacement / pump_stroke_time * (1.0 + pump_stroke_asymmetry)
        back_rate = max_displacement / pump_stroke_time * (1.0 - pump_stroke_asymmetry)
    return aim, max(pump_lag, 1e-4), rate, back_rate, pump_command


def charged(low, high, flow, relief, spilled, drawn):
    """
    Return the charge pressure at which check valves and relief take the charge pump's flow.

    ``spilled`` and ``drawn`` are the flows through relief and check valve per pressure.
    """
    charge = (flow + low * drawn + relief * spilled) / (drawn + spilled)
    if charge < relief:
        charge = low + flow / drawn                 # the relief is shut
    if charge < low:
        charge = relief + flow / spilled            # both check valves are
    if charge > high:
        charge = (flow + (low + high) * drawn + relief * spilled) / (2.0 * drawn + spilled)
        if charge < relief:
            charge = 0.5 * (low + high + flow / drawn)
    return charge


def pump_leak(pump_pressure, displacement, pump_speed, pump_command, flow, pressure, motor_speed,
              oil_temperature, viscosity_ratio, p, on, cells, layout):
    """Return what the pump leaks into its case from a line under a pressure, m^3/s."""
    max_displacement, nominal_speed = p[P_max_displacement], p[P_pump_shaft_speed]
    bulk_modulus, line_volume, oil_density = p[P_bulk_modulus], p[P_volume], p[P_oil_density]
    characterised_at, rated_pressure = p[P_characterised_at], p[P_rated_pressure]
    pump_leakage = p[P_pump_leakage_scale] * interpolate2(
        pump_pressure, abs(pump_command), T_PUMP_LEAKAGE, cells, layout)
    pump_flow_loss = 0.0
    # slot pump_flow_loss
    return pump_leakage + pump_flow_loss


def actuator(stroke, line_a_pressure, line_b_pressure, motor_speed, motor_angle, drive_speed, aim,
             lag, rate, back_rate, pump_command, charge_measured, oil_temperature,
             viscosity_ratio, motor_torque_load, opposing_torque, motor_displacement_command, p,
             on, cells, layout):
    """Return the rate of the stroke."""
    max_displacement, displacement = p[P_max_displacement], abs(stroke)
    # What the pistons press on the plate changes its sign with the line under pressure.
    pump_pressure = math.copysign(1.0, aim) * (line_a_pressure - line_b_pressure)
    pump_yield = 0.0
    # slot pump_yield
    settled = aim
    if abs(aim) > 0.0:
        settled = math.copysign(max(abs(aim) - pump_yield, 0.0), aim)
    stroke_rate = (settled - stroke) / lag
    if rate > 0.0:
        stroke_rate = min(max(stroke_rate, -back_rate), rate)
    return stroke_rate


def equations(stroke, line_a_pressure, line_b_pressure, motor_speed, motor_angle, drive_speed, aim,
              lag, rate, back_rate, pump_command, charge_measured, oil_temperature,
              viscosity_ratio, motor_torque_load, opposing_torque, motor_displacement_command, p,
              on, cells, layout):
    """Return the rates of the other states, then the quantities."""
    max_displacement, nominal_speed = p[P_max_displacement], p[P_pump_shaft_speed]
    bulk_modulus, line_volume, oil_density = p[P_bulk_modulus], p[P_volume], p[P_oil_density]
    pistons, characterised_at = p[P_pistons], p[P_characterised_at]
    cross_port_pressure = rated_pressure = p[P_rated_pressure]
    motor_displacement = p[P_motor_displacement]
    if motor_displacement_command > p[P_switches_at] and p[P_second_displacement] > 0.0:
        motor_displacement = p[P_second_displacement]
    difference = line_a_pressure - line_b_pressure
    # Between equal lines the way that the pump is going to deliver decides.
    a_high = difference > 0.0 or difference == 0.0 and aim >= 0.0
    high_line = 1.0 if a_high else -1.0
    low, high = min(line_a_pressure, line_b_pressure), max(line_a_pressure, line_b_pressure)
    displacement, pressure = abs(stroke), difference
    displacement_at_once = 0.0
    # slot displacement_at_once
    stroke += displacement_at_once
    way = 1.0 if stroke >= 0.0 else -1.0
    pump_pressure = way * difference    # of its outlet over its inlet: below 0 where it brakes
    displacement, speed = abs(stroke), abs(motor_speed)
    pump_speed = nominal_speed
    # slot pump_speed
    pump_speed_lag = 0.0
    # slot pump_speed_lag
    drive_rate = (pump_speed - drive_speed) / max(pump_speed_lag, PUMP_SPEED_AT_ONCE)
    pump_speed = drive_speed
    pressure = abs(difference)
    forwards = 1.0 if motor_speed >= 0.0 else -1.0
    flow = motor_displacement * speed
    line_drop = 0.0
    # slot line_drop
    a_drained, b_drained = motor_leaks(
        line_a_pressure, line_b_pressure, line_drop, motor_speed, motor_angle, oil_temperature,
        viscosity_ratio, motor_displacement, p, on, cells, layout)
    cross_port_flow = motor_flow_loss_kept = pump_flow_loss_kept = pump_flow_loss_free = 0.0
    # slot cross_port_flow
    # slot motor_flow_loss kept
    # slot pump_flow_loss kept
    # slot pump_flow_loss free
    across = high_line * (cross_port_flow + motor_flow_loss_kept
                          + max(pressure - cross_port_pressure, 0.0) * p[P_relief_gain])
    a_loss = a_drained + across + pump_leak(
        max(line_a_pressure, 0.0), displacement, pump_speed, pump_command, flow, pressure,
        motor_speed, oil_temperature, viscosity_ratio, p, on, cells, layout)
    b_loss = b_drained - across + pump_leak(
        max(line_b_pressure, 0.0), displacement, pump_speed, pump_command, flow, pressure,
        motor_speed, oil_temperature, viscosity_ratio, p, on, cells, layout)
    if a_high:
        a_loss += pump_flow_loss_free
    else:
        b_loss += pump_flow_loss_free
    low_loss = b_loss if a_high else a_loss
    delivered = stroke * pump_speed - way * pump_flow_loss_kept
    swept = motor_displacement * motor_speed

    charge_pressure = 0.0
    # slot charge_pressure
    relief = max(p[P_charge_relief] - charge_pressure, 1.0)
    charge_wear = 0.0
    # slot charge_wear
    made = p[P_charge_displacement] * pump_speed
    # A worn pump leaks in proportion to its pressure; with less than that it holds less.
    charge_flow = made
    if charge_wear > 0.0:
        charge_flow *= 1.0 - charge_wear * min(max(low / relief, 0.0), 1.0)
    flushed = p[P_flushing] * max(low, 0.0) / p[P_charge_relief]
    lacking = flushed + high_line * (delivered - swept) + low_loss
    held = p[P_charge_override] * (made * (1.0 - charge_wear) - lacking)
    settled_charge = CAVITATION_PRESSURE + p[P_check_valve] * lacking
    if held > 0.0:
        settled_charge = relief + held
    elif charge_wear > 0.0:
        settled_charge = max(settled_charge, relief * (1.0 - lacking / made) / charge_wear)
    charge = charged(low, high, charge_flow, relief, p[P_charge_gain], p[P_check_gain])
    held_at = settled_charge
    if not math.isnan(charge_measured):
        charge = held_at = charge_measured
    low_side = max(held_at - p[P_check_valve] * lacking, CAVITATION_PRESSURE)
    a_made_up = max(charge - line_a_pressure, 0.0) * p[P_check_gain]
    b_made_up = max(charge - line_b_pressure, 0.0) * p[P_check_gain]
    a_made_up -= 0.0 if a_high else flushed
    b_made_up -= flushed if a_high else 0.0
    twisted, gear_angle = gear(
        motor_torque_load, pressure, motor_displacement, p, on, cells, layout)
    a_storage = twisted + capacity(line_a_pressure, 1.0, oil_temperature, p, on, cells, layout)
    b_storage = twisted + capacity(line_b_pressure, -1.0, oil_temperature, p, on, cells, layout)
    a_rate = (delivered - swept - a_loss + a_made_up) / a_storage
    b_rate = (swept - delivered - b_loss + b_made_up) / b_storage
    if line_a_pressure <= CAVITATION_PRESSURE:
        a_rate = max(a_rate, 0.0)
    if line_b_pressure <= CAVITATION_PRESSURE:
        b_rate = max(b_rate, 0.0)

    motor_torque, acceleration = shaft(
        difference - 2.0 * line_drop * forwards, motor_torque_load, opposing_torque, motor_speed,
        motor_angle, oil_temperature, viscosity_ratio, motor_displacement, p, on, cells, layout)
    pump_torque_loss = 0.0
    # slot pump_torque_loss
    taken, charging = stroke * difference, p[P_charge_displacement] * held_at
    pump_torque = taken + charging + pump_torque_loss + (abs(taken) + charging) * (
        1.0 / interpolate2(pressure, pump_speed, T_PUMP_EFFICIENCY, cells, layout) - 1.0)
    # Above the charge pressure no check valve lets oil into a line.
    far, above = difference / p[P_margin], (high - held_at) / p[P_margin]
    per_turn = 1.0 / motor_displacement
    # Elsewhere the charge pump does not hold the low side: its oil's spring decides. Between equal
    # lines the shuttle of a flushing valve stands in the middle and lets nothing through.
    fed = 1.0 if 0.0 < lacking < 0.9 * made else 0.0
    return (a_rate, b_rate, acceleration, motor_speed, drive_rate,
            (delivered - a_loss) * per_turn, (delivered + b_loss) * per_turn, low_side,
            settled_charge, motor_torque, pump_torque, pump_torque * pump_speed,
            a_drained + b_drained,
            swept + a_drained + high_line * motor_flow_loss_kept, a_storage * per_turn,
            -b_storage * per_turn, gear_angle, p[P_inertia], high_line * above,
            -high_line * above, -far * fed, far * fed, abs(far) * fed)


def numbers(rig: Rig) -> dict[str, float]:
    """Return the parameters of the equations, SI."""
    pump, charge, relief = rig.pump, rig.charge, rig.cross_port_relief
    return {
        **motor_numbers(rig), **actuator_numbers(pump.displacement),
        'pump_shaft_speed': pump.shaft_speed, 'max_displacement': pump.max_displacement,
        'displacement_lag': pump.displacement_lag, 'displacement_scale': 1.0,
        'pump_leakage_scale': 1.0,
        'relief_gain': 1.0 / relief.override if relief else 0.0,
        'charge_relief': charge.relief_pressure, 'charge_override': charge.relief_override,
        'charge_displacement': charge.pump_displacement, 'check_valve': charge.check_valve,
        'check_gain': 1.0 / charge.check_valve, 'charge_gain': 1.0 / charge.relief_override,
        'flushing': charge.flushing, 'margin': _MARGIN * rig.rated_pressure,
        'sign_scale': CONSTANTS['SIGN_WIDTH'] / (SIGN_SPEED * max(rig.full_speed, 1e-6)),
    }


def steps(found: dict[str, float]) -> tuple[float, float]:
    """Return the longest integration step, s, and the one where all that is fast is measured."""
    spring = found['volume'] / found['bulk_modulus']
    stiffest = min(found['check_valve'], 1.0 / max(2.0 * found['relief_gain'], 1e-30))
    return min(_STEP * stiffest * spring, found['displacement_lag']), found['displacement_lag']


def complete(rig: Rig, channels: dict) -> dict:
    """Return the command that goes with a measured stroke where none was recorded."""
    if 'pump_command' in channels or 'pump_displacement' not in channels:
        return {}
    return {'pump_command': rig.pump.command_of(channels['pump_displacement'])}


CIRCUIT = Circuit(
    id='closed',
    title='closed circuit: over-centre pump, two lines, charge pump, hydromotors',
    hold=hold, actuator=actuator, equations=equations,
    helpers=(of_unit, waved, held_share, charged, pump_leak, capacity, gear, motor_leak,
             motor_leaks, shaft),
    numbers=numbers, sections=('pump', 'motor', 'line', 'charge'), complete=complete, steps=steps,
    keys=('pump.shaft_speed_rpm', 'pump.max_displacement_cc_rev', 'pump.displacement_vs_command',
          'pump.displacement_lag_s', 'motor.displacement_cc_rev', 'motor.inertia_total_kg_m2',
          'line.volume_m3', 'line.bulk_modulus_Pa'),
    tables={'DISPLACEMENT': lambda rig: rig.pump.displacement,
            'PUMP_LEAKAGE': lambda rig: rig.pump.leakage,
            'PUMP_EFFICIENCY': lambda rig: rig.pump.mechanical_efficiency, **TABLES},
    scaled={'pump.displacement_vs_command': 'displacement_scale',
            'pump.displacement_lag': 'displacement_lag', 'pump.leakage': 'pump_leakage_scale',
            'charge.relief_pressure': 'charge_relief',
            'charge.pump_displacement': 'charge_displacement', **SCALED, **ACTUATOR},
    states=(State('pump_displacement', 'm^3/rad'),
            State('line_a_pressure', 'Pa', 'charge_relief', least=_EMPTY),
            State('line_b_pressure', 'Pa', 'charge_relief', least=_EMPTY),
            State('motor_speed', 'rad/s'), State('motor_angle', 'rad'),
            State('pump_speed', 'rad/s', 'pump_shaft_speed', moved_by='pump_speed')),
    held_inputs=(Input('pump_command'),),
    inputs=(Input('charge_pressure', math.nan), Input('oil_temperature'),
            Input('viscosity_ratio', 1.0), Input('motor_torque', math.nan),
            Input('opposing_torque'), Input('motor_displacement_command')),
    quantities=('speed_by_a', 'speed_by_b', 'low_side', 'charge_pressure', 'motor_torque',
                'pump_torque', 'pump_power', 'case_drain_flow', 'motor_inlet_flow', 'a_storage',
                'b_storage', 'gear_angle', 'inertia', 'a_high', 'b_high', 'a_held', 'b_held',
                'either_held'),
    balances=(
        Balance('high line', 'motor_speed', 'flow', 'oil between pump and hydromotor',
                (Part('speed_by_a', 'a_high', 'line_a_pressure', 'a_storage', 'gear_angle'),
                 Part('speed_by_b', 'b_high', 'line_b_pressure', 'b_storage', 'gear_angle')),
                needs=(*LINES, _STROKE), swept=True, formula='formula_pump_flow',
                sheet=OF_A_FLOW, id='pump_flow'),
        Balance('low line A', 'line_a_pressure', 'flow', 'pressure of the low side',
                (Part('low_side', 'a_held'),), needs=('motor_speed', 'line_b_pressure', _STROKE)),
        Balance('low line B', 'line_b_pressure', 'flow', 'pressure of the low side',
                (Part('low_side', 'b_held'),), needs=('motor_speed', 'line_a_pressure', _STROKE)),
        Balance('charge line', 'charge_pressure', 'flow', 'charge pressure',
                (Part('charge_pressure', 'either_held'),), needs=('motor_speed', *LINES, _STROKE)),
        Balance('shaft', 'motor_torque', 'torque', 'torque of the hydromotor',
                (Part('motor_torque', '', 'motor_speed', 'inertia'),),
                needs=('motor_speed', *LINES), formula='formula_torque'),
        Balance('stroke', 'pump_displacement', 'pump_actuator',
                'displacement of the pump', (Part('pump_displacement'),), needs=('pump_command',)),
        Balance('pump torque', 'pump_torque', 'torque', 'torque of the pump',
                (Part('pump_torque'),), needs=(*LINES, _STROKE)),
        Balance('pump power', 'pump_power', 'torque', 'power of the pump',
                (Part('pump_power'),), needs=(*LINES, _STROKE)),
        Balance('hydromotor flow', 'motor_inlet_flow', 'flow',
                'oil that turns the hydromotor', (Part('motor_inlet_flow'),),
                needs=('motor_speed', *LINES), formula='formula_motor_flow', id='motor_flow'),
        Balance('case drain', 'case_drain_flow', 'flow', 'leakage of the hydromotor',
                (Part('case_drain_flow'),), needs=('motor_speed', *LINES),
                formula='formula_motor_flow', sheet=OF_A_LEAK),
    ),
)
