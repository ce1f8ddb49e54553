# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of flow, torque and actuator that the list does not hold."""
from bench.unseen.fault import Fault

ORIFICE = 'm^3/(s.Pa^0.5)'

FLOW = (
    Fault('valve_dirt_bursts', 'flow', 'motor_speed', 'orifice_gain', ORIFICE, 0.003, 0.8, (
        ('orifice', lambda s, r, c: (s * c.flow / c.pressure ** 0.5, {
            'hole': s * c.flow / c.pressure ** 0.5, 'event': 'bursts'})),
    ), 'Dirt holds the seat of the relief valve open for a second or two, now and then.', {}),
    Fault('flushing_circuit_opens', 'flow', 'motor_speed', 'flow', 'm^3/s', 0.002, 0.4, (
        ('regulator', lambda s, r, c: (s * c.flow, {'burst': s * c.flow, 'event': 'period'})),
    ), 'A timer opens a flushing circuit that takes a constant flow, whatever the pressure.', {}),
    Fault('hose_bursts_slowly', 'flow', 'motor_speed', 'orifice_gain', ORIFICE, 0.002, 0.5, (
        ('crack', lambda s, r, c: (s * c.flow / c.pressure ** 0.5, {
            'hole': s * c.flow / c.pressure ** 0.5, 'event': 'growing'})),
    ), 'A crack in the hose grows log by log.', {'': ('pump_leakage',)}),
    Fault('hose_creeps', 'flow', 'motor_speed', 'compliance', 'm^3/Pa', 0.05, 40, (
        ('kelvin_voigt', lambda s, r, c: (s * c.volume / c.modulus, {
            'creep': s * c.volume / c.modulus, 'creep_time': r(0.5, 3)})),
    ), 'A soft hose swells late: it takes oil for seconds after a step of pressure.',
          {'': ('accumulator',)}),
    Fault('dead_pump_piston', 'flow', 'motor_speed', 'lost_share', '1', 0.002, 0.2, (
        ('check', lambda s, r, c: (s, {'dead_piston': s})),
    ), 'One piston of the pump delivers less: flow is short and swings once a turn.', {}),
    Fault('one_leaky_cylinder', 'flow', 'motor_inlet_flow', 'gap', 'm^3/(s.Pa)', 0.005, 0.8, (
        ('lobe', lambda s, r, c: (s * c.flow / c.pressure, {'lobe_gap': s * c.flow / c.pressure})),
    ), 'One cylinder of the motor leaks over its part of each turn.', {'': ('motor_leakage',)},
          0.02),
)

TORQUE = (
    Fault('bent_shaft', 'torque', 'motor_speed', 'torque', 'N.m', 0.003, 0.4, (
        ('once', lambda s, r, c: (s * c.torque, {'bent_torque': s * c.torque, 'bent_order': 1.0})),
        ('twice', lambda s, r, c: (s * c.torque, {'bent_torque': s * c.torque,
                                                  'bent_order': 2.0})),
    ), 'A bent rod or a worn joint rubs once or twice a turn.', {}, 0.02),
    Fault('whirl_band', 'torque', 'pump_outlet_pressure', 'torque', 'N.m', 0.003, 0.6, (
        ('band', lambda s, r, c: (s * c.torque, {
            'band_torque': s * c.torque, 'band_at': r(7, 12), 'band_width': r(0.6, 1.5)})),
    ), 'The string whirls in a band of speed and takes torque only there.', {}),
    Fault('chips_jam', 'torque', 'motor_speed', 'torque', 'N.m', 0.005, 0.8, (
        ('jolts', lambda s, r, c: (s * c.torque, {'jolt': s * c.torque, 'event': 'jolts'})),
    ), 'Chips jam the bearing for fractions of a second.', {}),
    Fault('grease_warms', 'torque', 'pump_outlet_pressure', 'torque', 'N.m', 0.002, 0.4, (
        ('fading', lambda s, r, c: (s * c.torque, {
            'coulomb': s * c.torque, 'coulomb_fades': r(0.8, 1.0), 'heat_time': r(3, 10)})),
    ), 'Stiff grease yields as the bearing turns and warms.', {'': ('bearing_friction',)}),
    Fault('bearing_grips_warm', 'torque', 'pump_outlet_pressure', 'torque', 'N.m', 0.002, 0.4, (
        ('heat', lambda s, r, c: (s * c.torque, {'heat_torque': s * c.torque,
                                                 'heat_time': r(8, 20)})),
    ), 'A bearing without play grips as it gets warm.', {}),
)

ACTUATOR = (
    Fault('stop_screw', 'pump_actuator', 'motor_speed', 'lost_stroke', '1', 0.02, 0.75, (
        ('stop', lambda s, r, c: (s, {'stroke_stop': 1.02 * (1 - s) * c.stroke})),
    ), 'A stop screw holds the plate short of its full angle.', {}),
    Fault('plate_hunts', 'pump_actuator', 'motor_speed', 'amplitude', 'V', 0.003, 0.8, (
        ('hunt', lambda s, r, c: (s, {'hunt': s, 'hunt_hz': r(0.6, 4)})),
    ), 'The inner loop of the plate hunts.', {}),
    Fault('slow_return', 'pump_actuator', 'motor_speed', 'extra_return_lag', 's', 0.003, 3, (
        ('return', lambda s, r, c: (s, {'return_lag': c.lag + s})),
    ), 'The plate comes back slower than it goes out: a blocked orifice.',
          {'': ('pump_lag', 'pump_rate_limit')}),
    Fault('command_gain', 'pump_actuator', 'motor_speed', 'gain', '1', 0.0005, 0.12, (
        ('low', lambda s, r, c: (1 - s, {'command_gain': 1 - s})),
        ('high', lambda s, r, c: (1 + s, {'command_gain': 1 + s})),
    ), 'The amplifier of the pump has a wrong gain.', {'': ('pump_command_offset',)}),
    Fault('dead_spot', 'pump_actuator', 'motor_speed', 'height', 'm^3/rad', 0.003, 0.5, (
        ('spot', lambda s, r, c: (s * c.stroke, {
            'spot_height': s * c.stroke, 'spot_at': r(4.5, 6.2), 'spot_width': r(0.25, 0.6)})),
    ), 'The feedback of the plate has a worn spot: the curve has a bump.', {}),
    Fault('command_drops', 'pump_actuator', 'motor_speed', 'share', '1', 0.02, 1, (
        ('contact', lambda s, r, c: (s, {'dropout': s, 'event': 'blinks'})),
    ), 'A loose contact takes the command away for a tenth of a second.', {}),
    Fault('plate_sticks_and_jumps', 'pump_actuator', 'motor_speed', 'breakaway', 'V', 0.005, 1, (
        ('jump', lambda s, r, c: (s, {'stick': s})),
    ), 'The plate rests until the pull is enough, then jumps the whole way.',
          {'': ('pump_hysteresis',)}),
)
