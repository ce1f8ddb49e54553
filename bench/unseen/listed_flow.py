# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Listed effects by which oil goes elsewhere or comes late.

Laminar gaps and orifices: Ivantysyn and Ivantysynova, Hydrostatic Pumps and Motors (2001), ch. 3;
gaps that widen: the cube of the gap height (Reynolds). Temperature: ASTM D341 (Walther), Vogel.
Air: Nykanen et al. (2000), Gholizadeh et al., Int. J. Fluid Power 12 (2011). Accumulator:
polytropic gas. Suction: Merritt, Hydraulic Control Systems (1967). Prime mover: slip line.
"""
from bench.unseen.fault import Fault

FLOW = (
    Fault('leakage_temperature', 'flow', 'motor_speed', 'viscosity_power', '1', 0.05, 2.5, (
        ('walther', lambda s, r, c: (s, {'oil.law': 'walther', 'oil.power': s,
                                         'oil.start': r(36, 64), 'oil.rise': r(6, 16)})),
        ('vogel', lambda s, r, c: (s, {'oil.law': 'vogel', 'oil.power': s,
                                       'oil.start': r(36, 64), 'oil.rise': r(6, 16)})),
    ), 'Leakage follows the viscosity of oil that is not at 50 degC.', {}),
    Fault('elastic_leakage', 'flow', 'motor_inlet_flow', 'gap_growth', '1/Pa', 0.02, 3, (
        ('linear', lambda s, r, c: (s / c.pressure, {'gap_growth': s / c.pressure,
                                                     'gap_linear': 1.0})),
        ('cube', lambda s, r, c: (s / 3 / c.pressure, {'gap_growth': s / 3 / c.pressure,
                                                       'gap_cube': 1.0})),
        ('exponential', lambda s, r, c: (s / c.pressure, {'gap_growth': s / c.pressure,
                                                          'gap_exp': 1.0})),
    ), 'The gaps of the motor widen with pressure.', {}),
    Fault('pump_leakage', 'flow', 'motor_speed', 'gap', 'm^3/(s.Pa)', 0.001, 0.2, (
        ('gap', lambda s, r, c: (s * c.flow / c.pressure, {'pump_gap': s * c.flow / c.pressure})),
        ('table', lambda s, r, c: (s * 40, {'pump_leak_factor': 1 + s * 40})),
        ('stroke', lambda s, r, c: (s * c.flow / c.pressure, {
            'pump_gap': s * c.flow / c.pressure, 'pump_gap_stroke': r(0.3, 1) / c.stroke})),
    ), 'The pump is worn.', {}),
    Fault('motor_leakage', 'flow', 'motor_inlet_flow', 'gap', 'm^3/(s.Pa)', 0.001, 0.2, (
        ('gap', lambda s, r, c: (s * c.flow / c.pressure, {'motor_gap': s * c.flow / c.pressure})),
        ('table', lambda s, r, c: (s * 30, {'motor_leak_factor': 1 + s * 30})),
        ('speed', lambda s, r, c: (s * c.flow / c.pressure, {
            'motor_gap': s * c.flow / c.pressure, 'motor_gap_speed': r(0.01, 0.04)})),
    ), 'The motor is worn.', {}),
    Fault('motor_orifice_leakage', 'flow', 'motor_inlet_flow', 'orifice_gain', 'm^3/(s.Pa^0.5)',
          0.001, 0.25, (
              ('turbulent', lambda s, r, c: (s * c.flow / c.pressure ** 0.5, {
                  'motor_orifice': s * c.flow / c.pressure ** 0.5})),
              ('transition', lambda s, r, c: (s * c.flow / c.pressure ** 0.5, {
                  'motor_orifice': s * c.flow / c.pressure ** 0.5, 'orifice_width': r(3e5, 1e6)})),
          ), 'A scored plate of the motor leaks as an orifice.', {}),
    Fault('entrained_air', 'flow', 'pump_outlet_pressure', 'air_fraction', '1', 1e-5, 0.15, (
        ('polytropic', lambda s, r, c: (s, {'air': s, 'air_exponent': r(1.1, 1.4)})),
        ('isothermal', lambda s, r, c: (s, {'air': s, 'air_exponent': 1.0})),
        ('dissolving', lambda s, r, c: (s, {'air': s, 'air_exponent': r(1.1, 1.4),
                                            'air_dissolved': r(3e6, 8e6)})),
    ), 'Air in the oil makes it soft at low pressure.', {}),
    Fault('compressibility_flow', 'flow', 'motor_speed', 'loss', '1/Pa', 0.0005, 0.15, (
        ('displaced', lambda s, r, c: (s / c.pressure, {'decompression': s / c.pressure})),
        ('dead_volume', lambda s, r, c: (s / c.pressure, {
            'decompression': s / c.pressure, 'dead_stroke': r(0.1, 0.35) * c.stroke})),
    ), 'Oil that the pump has compressed is lost when it opens to the tank side.',
          {'displaced': ('swash_compliance',)}),
    Fault('prv_cracking', 'flow', 'motor_speed', 'crack_gain', 'm^3/(s.Pa)', 0.001, 1.5, (
        ('linear', lambda s, r, c: (s * c.flow / c.pressure, {
            'crack_from': r(0.5, 0.9) * c.pressure, 'crack_slope': s * c.flow / c.pressure})),
        ('spring', lambda s, r, c: (s * c.flow / c.pressure, {
            'crack_from': r(0.4, 0.75) * c.pressure, 'crack_slope': 0.2 * s * c.flow / c.pressure,
            'crack_square': 1.6 * s * c.flow / c.pressure ** 2})),
    ), 'The relief valve passes oil long before its set pressure.', {}),
    Fault('pump_speed_droop', 'flow', 'motor_speed', 'slip_at_full_torque', '1', 0.001, 0.2, (
        ('slip_line', lambda s, r, c: (s, {'droop': s})),
        ('late', lambda s, r, c: (s, {'droop': s, 'prime_lag': r(0.08, 0.25)})),
        ('engine', lambda s, r, c: (s, {'droop': 0.4 * s, 'droop_square': 1.2 * s,
                                        'prime_lag': r(0.03, 0.2)})),
    ), 'The prime mover gives way under torque.', {}),
    Fault('suction_starvation', 'flow', 'motor_speed', 'unfilled_share', '1', 0.01, 0.8, (
        ('share', lambda s, r, c: (s, {'fill_from': r(0.7, 1.0) * c.flow, 'fill_share': s})),
        ('square', lambda s, r, c: (s, {'fill_from': r(0.6, 0.9) * c.flow,
                                        'fill_square': 0.8 * s / c.flow})),
    ), 'The pump no longer fills at large stroke.', {}),
    Fault('line_inertance', 'flow', 'motor_speed', 'inertance', 'kg/m^4', 0.02, 30, (
        ('hose', lambda s, r, c: (s * 2e-5 * c.modulus / c.volume, {
            **_line(s, r, c), 'far_share': r(0.4, 0.6)})),
        ('pipe', lambda s, r, c: (s * 2e-5 * c.modulus / c.volume, {
            **_line(s, r, c), 'far_share': r(0.25, 0.4)})),
    ), 'The oil in a long line swings.', {}, 0.01),
    Fault('accumulator', 'flow', 'pump_outlet_pressure', 'gas_volume', 'm^3', 1e-5, 3, (
        ('open', lambda s, r, c: (s * c.volume, {
            'gas_volume': s * c.volume, 'gas_pressure': r(1e6, 4e6), 'gas_exponent': 1.4})),
        ('slow_gas', lambda s, r, c: (s * c.volume, {
            'gas_volume': s * c.volume, 'gas_pressure': r(1e6, 4e6), 'gas_exponent': 1.05})),
        ('neck', lambda s, r, c: (s * c.volume, {
            'gas_volume': s * c.volume, 'gas_pressure': 2e6, 'gas_exponent': 1.3,
            'gas_neck': 0.0 if s == 0 else r(0.02, 0.08) * 8e6 / (s * c.volume)})),
    ), 'Gas above its precharge gives and takes oil.', {}),
)


def _line(s, r, c) -> dict:
    """Return a line: its waves die out (unsteady friction), its steady loss is small."""
    inertance = s * 2e-5 * c.modulus / c.volume
    return {'inertance': inertance,
            'line_laminar': s * r(2e-4, 6e-4) * c.pressure / c.flow,
            'line_wave': r(0.06, 0.2) * (2 * inertance * c.modulus / c.volume) ** 0.5}
