# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Warm oil is thin: the leakage of the tables, measured at one temperature, grows or falls.

``viscosity_ratio`` comes from Walther's equation (``oil.py``) for the rig's oil grade.
"""
from hst_drive.effects.base import Effect, OIL_POWER, Parameter

# What passes a gap follows the oil's viscosity by a power between 0 (orifices) and 1 (laminar
# gaps): the middle, and one standard deviation where any is as plausible.
POWER, POWER_SIGMA = 0.5, 12.0**-0.5
OIL_LAW = 'leakage_temperature'     # how a machine's leakage goes with its oil


def brought(values, ratio):
    """
    Return parameters of a leak that follows the oil as they are at another viscosity.

    Parameters
    ----------
    values : dict of str to float
        Of an effect with ``OIL_POWER``; the first is its size.
    ratio : float
        Of the viscosity to that of the tables.

    """
    power, reference = (values[entry.name] for entry in OIL_POWER)
    size = next(iter(values))
    thinner = (reference / ratio)**power
    return {**values, size: values[size] * thinner, OIL_POWER[1].name: ratio}


def pump_flow_loss(pump_leakage, viscosity_ratio, exponent):
    """Return what the pump leaks beyond its table, m^3/s; less than nothing in cold oil."""
    return pump_leakage * (viscosity_ratio**-exponent - 1.0)


def motor_flow_loss(motor_leakage, viscosity_ratio, exponent):
    """Return what the hydromotor leaks beyond its table, m^3/s."""
    return motor_leakage * (viscosity_ratio**-exponent - 1.0)


EFFECT = Effect(
    id=OIL_LAW,
    title='leakage grows as the oil gets warmer and thinner',
    slot='motor_flow_loss',
    function=motor_flow_loss,
    also=(('pump_flow_loss', pump_flow_loss),),
    equation='Q = Q_table * ((nu(T)/nu(T_table))^-exponent - 1), pump and hydromotor',
    parameters=(
        Parameter('exponent', '1', 0.0, 3.0, 1.0,
                  'power of the viscosity: 1 for laminar gaps, less for orifice-like ones'),
    ),
    telltale='Speed and pump flow fall slowly as the oil warms up, most at high pressure, though '
             'no command changes.',
    source='Viscosity: ASTM D341 (Walther). Laminar slip inversely proportional to viscosity: W. '
           'E. Wilson, Positive-Displacement Pumps and Fluid Motors, Pitman 1950.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'case_drain_flow'),
)
