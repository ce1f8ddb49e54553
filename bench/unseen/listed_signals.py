# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Listed effects of the pump's actuator and of the sensors.

Play: Krasnosel'skii and Pokrovskii (1983), one play or a Prandtl-Ishlinskii sum of several.
Actuators: Manring, Hydraulic Control Systems (2005), ch. 6: lag, saturation of the control valve,
deflection under swash torque.
"""
from bench.unseen.fault import Fault
from bench.unseen.machine import NEVER

ACTUATOR = (
    Fault('pump_command_offset', 'pump_actuator', 'motor_speed', 'offset', 'V', 0.001, 0.8, (
        ('late', lambda s, r, c: (s, {'command_shift': s})),
        ('early', lambda s, r, c: (-s, {'command_shift': -s})),
        ('dead_band', lambda s, r, c: (s, {'command_shift': s, 'shift_fades': r(0.2, 0.5)})),
    ), 'The displacement curve lies elsewhere along the command.', {}),
    Fault('pump_hysteresis', 'pump_actuator', 'motor_speed', 'play', 'V', 0.005, 1.5, (
        ('play', lambda s, r, c: (s, {'play': s})),
        ('spread', lambda s, r, c: (s, {'play': s, 'play_spread': 1.0})),
        ('part', lambda s, r, c: (s, {'play': s, 'play_share': r(0.6, 0.9)})),
    ), 'Play between the command and the plate.', {}),
    Fault('pump_rate_limit', 'pump_actuator', 'motor_speed', 'rate_limit', 'm^3/(rad.s)',
          0.03, 40, (
              ('hard', lambda s, r, c: (_rate(s, c), {'rate_limit': _rate(s, c)})),
              ('smooth', lambda s, r, c: (_rate(s, c), {
                  'rate_smooth': 0.0 if s == 0 else _rate(s, c)})),
          ), 'The plate moves no faster than its control valve lets it.', {}),
    Fault('pump_lag', 'pump_actuator', 'motor_speed', 'extra_lag', 's', 0.001, 1.5, (
        ('second_lag', lambda s, r, c: (s, {'extra_lag': s})),
        ('two_lags', lambda s, r, c: (s, {
            'extra_lag': 0.3 * s, 'stroke_lag': c.lag + 0.7 * s, 'return_lag': c.lag + 0.7 * s})),
    ), 'The actuator is slower than its datasheet.', {}),
    Fault('swash_compliance', 'pump_actuator', 'motor_speed', 'yield', '1/Pa', 0.001, 0.3, (
        ('share', lambda s, r, c: (s / c.pressure, {'yield_share': s / c.pressure})),
        ('stroke', lambda s, r, c: (s / c.pressure, {
            'yield_stroke': 0.5 * s * c.stroke / c.pressure})),
        ('limiter', lambda s, r, c: (2 * s / c.pressure, {
            'yield_share': 2 * s / c.pressure, 'yield_from': r(0.3, 0.7) * c.pressure})),
    ), 'The plate gives way to the pressure.', {'share': ('compressibility_flow',)}),
)

SENSOR = (
    Fault('pressure_sensor_bias', 'sensor', 'pump_outlet_pressure', 'bias', 'Pa', 0.001, 0.2, (
        ('above', lambda s, r, c: (s * c.pressure, {'sensor.pressure_bias': s * c.pressure})),
        ('below', lambda s, r, c: (-s * c.pressure, {'sensor.pressure_bias': -s * c.pressure})),
    ), 'The pressure reading is off by a constant.',
          {'above': ('bearing_friction', 'back_pressure', 'constant_torque'),
           'below': ('constant_torque',)}),
    Fault('speed_sensor_lag', 'sensor', 'motor_speed', 'lag', 's', 0.001, 1.5, (
        ('filter', lambda s, r, c: (s, {'speed_lag': s})),
        ('two_filters', lambda s, r, c: (s, {'speed_lag': 0.6 * s, 'speed_lag_2': 0.4 * s})),
        ('mean', lambda s, r, c: (s, {'sensor.speed_mean': 2 * s})),
    ), 'The speed reading is smoothed.', {}),
    Fault('torque_sensor_scale', 'sensor', 'load_torque', 'scale', '1', 0.001, 0.4, (
        ('high', lambda s, r, c: (1 + s, {'sensor.torque_scale': 1 + s})),
        ('low', lambda s, r, c: (1 - s, {'sensor.torque_scale': 1 - s})),
        ('bent', lambda s, r, c: (1 + s, {'sensor.torque_scale': 1 + s,
                                          'sensor.torque_bend': 0.15 * s / (3 * c.torque)})),
    ), 'The torque reading is off by a factor.', {}),
    Fault('flow_sensor_scale', 'sensor', 'motor_inlet_flow', 'scale', '1', 0.001, 0.4, (
        ('high', lambda s, r, c: (1 + s, {'sensor.flow_scale': 1 + s})),
        ('low', lambda s, r, c: (1 - s, {'sensor.flow_scale': 1 - s})),
    ), 'The flow reading is off by a factor.', {}),
)


def _rate(s, c) -> float:
    """Return the plate's limit: none for a perfect one."""
    return NEVER if s == 0 else 0.6 * c.stroke / s
