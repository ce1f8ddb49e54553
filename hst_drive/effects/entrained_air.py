# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Free air in the oil: a soft spring at low pressure, hardly there at high pressure.

``fraction`` is the volume of free air over that of oil at atmospheric pressure. How much heat
bubbles exchange while they are compressed depends on their size. Where they stay under pressure
they go into solution.
"""
from hst_drive.effects.base import Effect, Parameter

ATMOSPHERE = 101325.0   # Pa
LEAST = 1000.0          # Pa absolute: below it the oil itself boils
ISOTHERMAL, ADIABATIC = 1.0, 1.4


def compliance(pump_pressure, fraction, solution, exponent):
    """Return what the air adds to the compressibility of the oil, 1/Pa."""
    expansion = ATMOSPHERE / max(pump_pressure + ATMOSPHERE, LEAST)
    free = fraction * max(1.0 - solution * max(pump_pressure, 0.0), 0.0)
    return free / (exponent * ATMOSPHERE) * expansion**(1.0 + 1.0 / exponent)


EFFECT = Effect(
    id='entrained_air',
    title='free air lowers the bulk modulus at low pressure',
    slot='compliance',
    function=compliance,
    equation='1/K = 1/K_oil + fraction * max(1 - solution*P, 0) * (p0/p)^(1/n) / (n*p), '
             'n = exponent, p absolute',
    parameters=(
        Parameter('fraction', '1', 0.0, 0.2, 0.015,
                  'volume of free air at atmospheric pressure over that of the oil'),
        Parameter('solution', '1/Pa', 0.0, 1e-6, 0.0,
                  'one over the pressure at which all of it has gone into solution',
                  usual=(0.0,)),
        Parameter('exponent', '1', ISOTHERMAL, ADIABATIC, ADIABATIC,
                  'polytropic exponent of the bubbles: 1 isothermal, 1.4 adiabatic',
                  neutral=ADIABATIC, usual=(ADIABATIC, ISOTHERMAL)),
    ),
    telltale='At low pressure, pressure follows the commands slowly and rings at a low '
             'frequency; at high pressure all is as it should be.',
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967, ch. 2: effective bulk modulus; '
           'models compared by H. Gholizadeh, R. Burton and G. Schoenau, Fluid Bulk Modulus: '
           'Comparison of Low Pressure Models, Int. J. Fluid Power 13 (2012), solution after Ruan '
           'and Burton among them.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
    starts=({'solution': 3e-7}, {'fraction': 0.05, 'solution': 3e-7}),
)
