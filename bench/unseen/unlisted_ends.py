# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the load, the sensors and the logger that the list does not hold."""
from bench.unseen.fault import Fault

LOAD = (
    Fault('brake_valve_sticks', 'load', 'load_torque', 'play', 'V', 0.01, 2, (
        ('play', lambda s, r, c: (s, {'v_play': s})),
        ('jump', lambda s, r, c: (s, {'v_stick': s})),
    ), 'The spool of the proportional relief valve sticks.', {}),
    Fault('brake_valve_chatters', 'load', 'load_torque', 'share', '1', 0.002, 0.5, (
        ('chatter', lambda s, r, c: (s, {'chatter': s, 'chatter_hz': r(2, 7),
                                         'chatter_from': r(0.1, 0.35) * c.pressure})),
    ), 'The proportional relief valve chatters above a pressure.', {}, 0.02),
    Fault('brake_pump_starves', 'load', 'load_torque', 'share', '1', 0.01, 1.5, (
        ('starve', lambda s, r, c: (s, {'starved': s, 'starved_from': r(7, 10)})),
    ), 'The loading pump does not fill above a speed.', {}),
    Fault('coil_warms', 'load', 'load_torque', 'share', '1', 0.002, 0.4, (
        ('drift', lambda s, r, c: (s, {'coil_drift': s, 'coil_time': r(15, 50)})),
    ), 'The coil of the proportional valve gets warm and its pressure falls with time.', {}),
    Fault('clutch_slips', 'load', 'load_torque', 'lost_share', '1', 0.02, 0.9, (
        ('slip', lambda s, r, c: ((1 - s) * 1.7 * c.torque, {
            'slip_torque': (1 - s) * 1.7 * c.torque})),
    ), 'A clutch before the gear slips above a torque.', {}),
    Fault('brake_filter_clogs', 'load', 'load_torque', 'resistance', 'Pa.s^2/m^6', 0.002, 0.5, (
        ('square', lambda s, r, c: (s * c.pressure / c.flow ** 2, {
            'clogged': s * c.pressure / c.flow ** 2})),
    ), 'The filter behind the loading pump is clogged.', {}),
    Fault('amplifier_sags', 'load', 'load_torque', 'lost', 'V', 0.02, 6, (
        ('clip', lambda s, r, c: (6.5 - s, {'amplifier_limit': 6.5 - s})),
    ), 'The amplifier of the proportional valve cannot give its full current.', {}),
    Fault('brake_valve_closes_late', 'load', 'load_torque', 'extra_lag', 's', 0.005, 4, (
        ('rise', lambda s, r, c: (s, {'rise_lag': c.brake_lag + s})),
    ), 'The proportional valve builds pressure late but drops it at once.', {}),
)

SENSOR = (
    Fault('pressure_gauge_clips', 'sensor', 'pump_outlet_pressure', 'lost_share', '1', 0.02, 0.9, (
        ('clip', lambda s, r, c: ((1 - s) * 2.2 * c.pressure, {
            'sensor.pressure_limit': (1 - s) * 2.2 * c.pressure})),
    ), 'A pressure sensor of too small a range.', {}),
    Fault('pressure_snubber', 'sensor', 'pump_outlet_pressure', 'lag', 's', 0.002, 3, (
        ('snubber', lambda s, r, c: (s, {'sensor.pressure_lag': s})),
    ), 'A clogged snubber before the pressure sensor.', {}),
    Fault('pressure_spikes', 'sensor', 'pump_outlet_pressure', 'height', 'Pa', 0.01, 2, (
        ('spikes', lambda s, r, c: (s * c.pressure, {'sensor.pressure_spikes': s * c.pressure,
                                                     'event': 'blinks'})),
    ), 'Switching nearby throws spikes on the pressure channel.', {}),
    Fault('toothed_wheel_off_centre', 'sensor', 'motor_speed', 'share', '1', 0.002, 0.3, (
        ('eccentric', lambda s, r, c: (s, {'eccentric': s})),
    ), 'The wheel of the speed sensor sits off centre: an error once a turn.', {}, 0.02),
    Fault('wrong_tooth_count', 'sensor', 'motor_speed', 'scale', '1', 0.001, 0.15, (
        ('more', lambda s, r, c: (1 + s, {'speed_scale': 1 + s})),
        ('fewer', lambda s, r, c: (1 - s, {'speed_scale': 1 - s})),
    ), 'The speed reading is off by a factor.', {}),
    Fault('speed_channel_freezes', 'sensor', 'motor_speed', 'longest', 's', 0.02, 4, (
        ('hold', lambda s, r, c: (s, {'sensor.speed_hold': s})),
    ), 'The bus stands still now and then: the speed keeps its last value.', {}),
    Fault('flow_meter_slow', 'sensor', 'motor_inlet_flow', 'lag', 's', 0.003, 3, (
        ('lag', lambda s, r, c: (s, {'sensor.flow_lag': s})),
    ), 'The wheel of the flow meter is heavy with dirt.', {}),
    Fault('flow_meter_stalls', 'sensor', 'motor_inlet_flow', 'from', 'm^3/s', 0.03, 0.9, (
        ('floor', lambda s, r, c: (s * c.flow, {'sensor.flow_floor': s * c.flow})),
    ), 'The wheel of the flow meter stands still below a flow.', {}),
    Fault('flow_channel_late', 'sensor', 'motor_inlet_flow', 'delay', 's', 0.003, 1.5, (
        ('delay', lambda s, r, c: (s, {'sensor.flow_delay': s})),
    ), 'The flow comes over another bus, late.', {}),
    Fault('torque_zero_drifts', 'sensor', 'load_torque', 'drift', 'N.m', 0.002, 0.3, (
        ('drift', lambda s, r, c: (s * c.torque, {'sensor.torque_drift': s * c.torque})),
    ), 'The zero of the torque sensor drifts with time.', {'': ('constant_torque',)}),
    Fault('torque_cell_hysteresis', 'sensor', 'load_torque', 'width', 'N.m', 0.003, 0.4, (
        ('play', lambda s, r, c: (s * c.torque, {'sensor.torque_play': s * c.torque})),
    ), 'The torque reading hangs behind the torque: a loose hub of the sensor.', {}),
    Fault('speed_leaks_into_torque', 'sensor', 'load_torque', 'torque', 'N.m', 0.002, 0.3, (
        ('crosstalk', lambda s, r, c: (s * c.torque, {'sensor.torque_speed': s * c.torque})),
    ), 'The slip rings of the torque sensor add to it with speed squared.', {}),
)
