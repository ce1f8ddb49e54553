# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the term of an effect may enter the equations, what it may read; usual numbers."""
from __future__ import annotations

from typing import NamedTuple


class Slot(NamedTuple):
    """A place in the equations: balance it belongs to, unit of the term, what the term does."""

    enters: str
    unit: str
    meaning: str


DRILLING_SPEED = 10.0   # rad/s: about where a drill works, so that size and shape are told apart
USUAL_DAMPING_TIME = 0.002  # s, material damping of a flexible shaft unless an effect moves it
USUAL_SHARE = 0.35      # of the inertia lies behind a flexible shaft unless an effect moves it
USUAL_FAR = 0.5         # of the line's volume lies behind the mass of its oil, unless moved
USUAL_UPSTREAM = 0.3    # of the line's volume lies before its resistance unless an effect moves it

SLOTS: dict[str, Slot] = {
    'pump_command': Slot('pump actuator', 'V', 'added to the pump command'),
    'pump_play': Slot('pump actuator', 'V', 'width of the play between command and swash plate'),
    'pump_play_softness': Slot('pump actuator', '1', 'how softly that play takes hold'),
    'pump_play_spread': Slot('pump actuator', '1', 'how far two halves of that play differ'),
    'pump_lag': Slot('pump actuator', 's', 'added to the displacement lag'),
    'pump_series_lag': Slot('pump actuator', 's', 'lag in series with that of the displacement'),
    'pump_stroke_time': Slot('pump actuator', 's', 'shortest time for the full stroke'),
    'pump_stroke_asymmetry': Slot('pump actuator', '1', 'how much faster up than on average'),
    'pump_yield': Slot('pump actuator', 'm^3/rad', 'taken from the displacement that the command '
                       'asks for'),
    'displacement_at_once': Slot('pump actuator', 'm^3/rad', 'added to the displacement behind '
                                 'its control; `pressure` has its sign there'),
    'valve_command': Slot('pump actuator', 'V', 'added to the command of the valve'),
    'valve_lag': Slot('pump actuator', 's', "added to the valve's lag"),
    'pump_speed': Slot('flow', 'rad/s', 'added to the pump shaft speed'),
    'pump_speed_lag': Slot('flow', 's', 'first-order lag of that change'),
    'pump_flow_loss': Slot('flow', 'm^3/s', 'lost between pump and flow meter'),
    'charge_wear': Slot('flow', '1', "share of the charge pump's delivery that leaks at the "
                        "relief's pressure"),
    'one_line': Slot('flow', '1', 'where compressibility is added: 1 in line A, -1 in line B, '
                     '0 in both'),
    'pump_torque_loss': Slot('torque', 'N.m', 'torque at the pump shaft beyond its sheet'),
    'motor_flow_loss': Slot('flow', 'm^3/s', 'lost in the hydromotor, behind the flow meter'),
    'cross_port_flow': Slot('flow', 'm^3/s', 'passes from the high line to the low one'),
    'charge_pressure': Slot('flow', 'Pa', 'taken from the pressure of the charge relief'),
    'compliance': Slot('flow', '1/Pa', 'added to the compressibility of the oil'),
    'line_inertance': Slot('flow', 'Pa.s^2/m^3', "mass of the line's oil over its area squared"),
    'line_far_share': Slot('flow', '1', f"added to the share of the line's volume ({USUAL_FAR}) "
                           'that lies behind that mass'),
    'line_damping': Slot('flow', '1/s', 'decay of what moves in the line by itself'),
    'line_drop': Slot('torque', 'Pa', 'pressure lost between pump outlet and hydromotor inlet'),
    'line_upstream_share': Slot('torque', '1', 'added to the share of the oil in the line '
                                f'({USUAL_UPSTREAM}) that lies before its resistance'),
    'back_pressure': Slot('torque', 'Pa', 'pressure at the hydromotor outlet'),
    'loss_pressure': Slot('torque', 'Pa', 'added to the pressure with which the hydromotor loses '
                          'torque'),
    'motor_torque_loss': Slot('torque', 'N.m', 'torque that opposes the hydromotor rotation'),
    'motor_torque': Slot('torque', 'N.m', 'torque added to the hydromotor, of either sign; '
                         '`pressure` has the sign of its torque there'),
    'gear_twist': Slot('torque', 'rad/(N.m)', 'turn of the hydromotor against the shaft behind '
                       'its gear, per torque'),
    'gear_angle': Slot('torque', 'rad', 'turn of the hydromotor against that shaft'),
    'shaft_compliance': Slot('torque', 'rad/(N.m)', 'twist of the shaft per torque'),
    'shaft_load_share': Slot('torque', '1', f'added to the share of the inertia ({USUAL_SHARE}) '
                             'that lies behind a flexible shaft'),
    'shaft_damping_time': Slot('torque', 's', 'added to the damping of a flexible shaft over its '
                               f'stiffness ({USUAL_DAMPING_TIME} s)'),
    'load_torque': Slot('load', 'N.m', 'load torque beyond what the loading unit explains'),
    'pressure_reading': Slot('sensor', 'Pa', 'added to the pressure reading'),
    'flow_reading': Slot('sensor', 'm^3/s', 'added to the flow reading'),
    'speed_reading': Slot('sensor', 'rad/s', 'added to the speed reading'),
    'speed_reading_lag': Slot('sensor', 's', 'first-order lag of the speed reading'),
    'speed_reading_series_lag': Slot('sensor', 's', 'lag in series with that of the reading'),
    'torque_reading': Slot('sensor', 'N.m', 'added to the torque reading'),
}

# Places where oil leaves a line, and the factor of the unit on what its table leaks there.
LEAKS = {'pump_flow_loss': 'pump.leakage', 'motor_flow_loss': 'motor.leakage'}
# Places that the open circuit has not.
OF_OTHER_CIRCUITS = frozenset({'cross_port_flow', 'charge_pressure', 'charge_wear', 'one_line',
                               'gear_twist', 'gear_angle', 'valve_command', 'valve_lag',
                               'displacement_at_once'})

# What an effect may read: name -> unit. Constants of the rig stand beside signals.
READABLE: dict[str, str] = {
    'displacement': 'm^3/rad', 'pump_speed': 'rad/s', 'pump_pressure': 'Pa', 'pressure': 'Pa',
    'motor_speed': 'rad/s', 'motor_angle': 'rad', 'pump_command': 'V', 'pprv_command': 'V',
    'oil_temperature': 'K', 'viscosity_ratio': '1', 'load_torque': 'N.m', 'flow': 'm^3/s',
    'twist': 'rad', 'pump_leakage': 'm^3/s', 'motor_leakage': 'm^3/s',
    'motor_displacement': 'm^3/rad',
    'max_displacement': 'm^3/rad', 'line_volume': 'm^3', 'bulk_modulus': 'Pa',
    'oil_density': 'kg/m^3', 'relief_pressure': 'Pa', 'pistons': '1', 'characterised_at': 'K',
    'nominal_speed': 'rad/s', 'rated_pressure': 'Pa', 'cross_port_pressure': 'Pa',
    'valve_command': 'V', 'high_line': '1',
}

# What is known where a slot lies: the equations are evaluated in order.
_COMMANDS = frozenset({'displacement', 'pump_pressure', 'motor_speed', 'motor_angle',
                       'pump_command', 'pprv_command', 'oil_temperature', 'viscosity_ratio',
                       'nominal_speed', 'max_displacement'})
_BALANCES = frozenset(READABLE) - {
    'pump_speed', 'load_torque', 'twist', 'valve_command', 'high_line'}
_KNOWN: dict[str, frozenset[str]] = {
    'line_drop': _BALANCES, 'pump_speed': _BALANCES,
    'motor_flow_loss': _BALANCES | {'high_line'},
    'pump_flow_loss': _BALANCES | {'pump_speed', 'high_line'},
    'compliance': _BALANCES | {'pump_speed'},
    **dict.fromkeys(('back_pressure', 'loss_pressure', 'cross_port_flow'),
                    _BALANCES | {'pump_speed'}),
    'charge_pressure': frozenset({'pump_speed', 'oil_temperature', 'viscosity_ratio'}),
    'gear_twist': frozenset({'pressure', 'motor_displacement'}),
    'gear_angle': frozenset({'load_torque'}),
    **dict.fromkeys(('valve_command', 'valve_lag'), frozenset({'valve_command'})),
    'pump_torque_loss': _COMMANDS | {'pump_speed'},
    **dict.fromkeys(('motor_torque_loss', 'motor_torque'), frozenset(READABLE) - {'high_line'}),
    'shaft_compliance': frozenset({'twist'}),
    # A replay asks for the speed behind a reading before it simulates anything.
    'speed_reading': frozenset({'motor_speed', 'oil_temperature'}),
    **dict.fromkeys(('charge_wear', 'one_line', 'shaft_load_share', 'shaft_damping_time',
                     'line_inertance', 'line_far_share', 'line_damping', 'speed_reading_lag',
                     'speed_reading_series_lag'), frozenset()),
    'displacement_at_once': _COMMANDS | {'pressure'},
    'load_torque': frozenset({'load_torque', 'motor_speed', 'motor_angle', 'pprv_command',
                              'oil_temperature', 'pistons'}),
    'torque_reading': frozenset({'load_torque', 'motor_angle', 'oil_temperature'}),
    **dict.fromkeys(('pressure_reading', 'flow_reading'),
                    _COMMANDS | {'pressure', 'flow', 'load_torque', 'pump_speed'}),
}


def readable(slot: str) -> frozenset[str]:
    """Return the names of ``READABLE`` that are known where a slot lies."""
    return _KNOWN.get(slot, _COMMANDS)
