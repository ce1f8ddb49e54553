# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Oil that stiffens under pressure.

The tangent bulk modulus of mineral oil rises in proportion to pressure; ``line.bulk_modulus`` of
the rig is that at atmospheric pressure then.
"""
from hst_drive.effects.base import Effect, Parameter


def compliance(pump_pressure, bulk_modulus, slope):
    """Return what pressure takes from the compressibility of the oil, 1/Pa."""
    rise = slope * max(pump_pressure, 0.0)
    return -rise / (bulk_modulus * (bulk_modulus + rise))


EFFECT = Effect(
    id='bulk_modulus_rise',
    title='the oil gets stiffer as pressure rises',
    slot='compliance',
    function=compliance,
    equation='K = K_0 + slope*P',
    parameters=(
        Parameter('slope', '1', 0.0, 20.0, 10.0,
                  'rise of the bulk modulus per pressure; 9 to 13 for mineral oils without hoses'),
    ),
    telltale='Pressure rings at a higher frequency at high pressure than at low pressure.',
    source='H. E. Merritt, Hydraulic Control Systems, Wiley 1967, ch. 2; H. Gholizadeh, R. '
           'Burton and G. Schoenau, Fluid Bulk Modulus: a Literature Survey, Int. J. Fluid Power '
           '12 (2011).',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed'),
)
