# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A gas accumulator in the line, wanted or not: it gives and takes oil above its precharge.

Below its precharge it is closed. ``exponent``: 1 where the gas keeps the temperature of the oil,
1.4 where it has no time to, above that with nitrogen at high pressure.
"""
from hst_drive.effects.base import Effect, Parameter

ATMOSPHERE = 101325.0   # Pa
OPENING = 0.2           # of the precharge, over which the gas takes hold


def compliance(pump_pressure, line_volume, gas_volume, precharge, exponent):
    """Return what the gas adds to the compressibility of the oil in the line, 1/Pa."""
    absolute, closed = pump_pressure + ATMOSPHERE, precharge + ATMOSPHERE
    if absolute <= closed:
        return 0.0
    opened = min((absolute / closed - 1.0) / OPENING, 1.0)
    gas = opened**2 * (3.0 - 2.0 * opened) * gas_volume * (closed / absolute)**(1.0 / exponent)
    return gas / (exponent * absolute * line_volume)


def one_line(gas_volume, where):
    """Return the line that it stands on."""
    return where if gas_volume > 0.0 else 0.0


EFFECT = Effect(
    id='accumulator',
    title='a gas accumulator gives and takes oil above its precharge',
    slot='compliance',
    function=compliance,
    also=(('one_line', one_line),),
    equation='1/K = 1/K_oil + gas_volume * (p0/p)^(1/n) / (n*p*V) where p > p0, smooth from p0 '
             'to 1.2 p0; p0 = precharge, n = exponent, p absolute',
    parameters=(
        Parameter('gas_volume', 'm^3', 0.0, 5e-3, 2e-5, 'gas at its precharge'),
        Parameter('precharge', 'Pa', 2e5, 2.5e7, 3e6, 'gauge pressure at which oil comes in',
                  neutral=3e6),
        Parameter('exponent', '1', 1.0, 1.6, 1.4, 'polytropic exponent of the gas',
                  neutral=1.4, usual=(1.4, 1.0)),
        Parameter('where', '1', -1.0, 1.0, 0.0, 'in a closed circuit: 1 on line A, -1 on line B, '
                  '0 on both', fixed=True),
    ),
    telltale='Above some pressure the drive is soft: pressure follows slowly and swings at a low '
             'frequency; below it all is as it should be.',
    source='Gas accumulators: H. E. Merritt, Hydraulic Control Systems, Wiley 1967; polytropic '
           'exponent and heat: A. Pourmovahed and D. R. Otis, An experimental thermal time '
           'constant correlation for hydraulic accumulators, J. Dyn. Sys. Meas. Control 112 '
           '(1990).',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    starts=({'precharge': 1e6}, {'precharge': 6e6}, {'precharge': 1e7},
            {'gas_volume': 3e-4}, {'where': 1.0}, {'where': -1.0}),
)
