# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which keys a rig file has, in which unit, and what is physically possible.

A key carries its unit as a suffix (``shaft_speed_rpm``). This table is all that the loader
knows of a rig; ranges are wide: they catch slips of the unit, not unusual machines.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.effects.oil import GRADES


class Number(NamedTuple):
    """
    A scalar: attribute of the section, unit in the file, plausible range in that unit.

    ``optional`` in any file; see ``PART`` for what only a file of a part may leave out.
    """

    attribute: str
    unit: str
    low: float
    high: float
    optional: bool = False


class Table(NamedTuple):
    """
    A table: attribute, axes (key, unit), value key, unit and plausible range.

    ``rising`` where the drive inverts the table, so that its values must not fall. One with
    ``coefficients`` may be those keys of a model (``characteristic``) instead; one over two axes
    may be one number. ``optional`` in any file.
    """

    attribute: str
    axes: tuple[tuple[str, str], ...]
    value: str
    unit: str
    low: float
    high: float
    rising: bool = False
    coefficients: tuple[str, ...] = ()
    optional: bool = False


class Limits(NamedTuple):
    """A pair low, high."""

    attribute: str
    unit: str


class Word(NamedTuple):
    """A text, one of those known."""

    attribute: str
    known: tuple[str, ...]


_PRESSURE = ('pressure_bar', 'bar')
_COMMAND = ('command_V', 'V')
_SPEED = ('speed_rpm', 'rpm')
# Coefficients that may stand in the place of a table.
LEAKAGE = ('laminar_L_min_per_bar', 'turbulent_L_min_per_sqrt_bar')
TORQUE = ('coulomb_N_m', 'viscous_N_m_s_per_rad', 'pressure_share')
# What a unit may be off its datasheet, and where the oil's equations hold.
FACTORS = (0.1, 10.0)
OIL_TEMPERATURES = (-50.0, 200.0)   # degC

SECTIONS: dict[str, dict[str, Number | Table | Limits | Word]] = {
    'pump': {
        'shaft_speed_rpm': Number('shaft_speed', 'rpm', 50, 20000),
        'max_displacement_cc_rev': Number('max_displacement', 'cc/rev', 0.1, 5000),
        'displacement_vs_command': Table(
            'displacement', (_COMMAND,), 'displacement_cc_rev', 'cc/rev', -5000, 5000, True),
        'displacement_lag_s': Number('displacement_lag', 's', 1e-4, 10),
        'leakage_L_min': Table(
            'leakage', (_PRESSURE, _COMMAND), 'table', 'L/min', 0, 500, coefficients=LEAKAGE),
        'mechanical_efficiency': Table(
            'mechanical_efficiency', (_PRESSURE, _SPEED), 'table', '1', 0.01, 1, optional=True),
    },
    'motor': {
        'displacement_cc_rev': Number('displacement', 'cc/rev', 0.1, 50000),
        'count': Number('count', '1', 1, 12, optional=True),
        'second_displacement_cc_rev': Number('second_displacement', 'cc/rev', 0, 50000,
                                             optional=True),
        'inertia_total_kg_m2': Number('inertia', 'kg.m^2', 1e-6, 1e5),
        'leakage_L_min': Table('leakage', (_PRESSURE, _SPEED), 'table', 'L/min', 0, 500,
                               coefficients=LEAKAGE),
        'mechanical_efficiency': Table(
            'mechanical_efficiency', (_PRESSURE, _SPEED), 'table', '1', 0.01, 1,
            coefficients=TORQUE),
        'pistons': Number('pistons', '1', 3, 101, optional=True),
    },
    'line': {
        'bulk_modulus_Pa': Number('bulk_modulus', 'Pa', 1e7, 5e9),
        'volume_m3': Number('volume', 'm^3', 1e-7, 10),
        'oil_density_kg_m3': Number('oil_density', 'kg/m^3', 500, 2000),
        'oil_grade': Word('oil_grade', tuple(GRADES)),
    },
    'relief_valve': {
        'set_pressure_bar': Number('set_pressure', 'bar', 1, 1500),
        'reference_pressure_bar': Number('reference_pressure', 'bar', 0, 1500, optional=True),
        'discharge_coefficient': Number('discharge_coefficient', '1', 0.1, 1),
        'area_m2': Number('area', 'm^2', 1e-9, 1e-2),
    },
    'loading': {
        'gear_ratio': Number('gear_ratio', '1', 0.01, 1000),
        'pump_displacement_cc_rev': Number('pump_displacement', 'cc/rev', 0.1, 5000),
        'pump_mechanical_efficiency': Table(
            'pump_mechanical_efficiency', (_PRESSURE,), 'efficiency', '1', 0.01, 1),
        'pprv_pressure_vs_command': Table(
            'pprv_pressure', (_COMMAND,), 'pressure_bar', 'bar', 0, 1500, True),
        'pprv_lag_s': Number('pprv_lag', 's', 1e-4, 10),
        'pprv_override_bar_per_L_min': Number('pprv_override', 'bar/(L/min)', 0, 1000),
        'pprv_reference_flow_L_min': Number('pprv_reference_flow', 'L/min', 0, 10000),
    },
    'gear': {
        'ratio': Number('ratio', '1', 0.01, 1000),
        'efficiency': Number('efficiency', '1', 0.1, 1, optional=True),
    },
    'cross_port_relief': {
        'set_pressure_bar': Number('set_pressure', 'bar', 1, 1500),
        'override_bar_per_L_min': Number('override', 'bar/(L/min)', 1e-4, 1000),
    },
    'charge': {
        'pump_displacement_cc_rev': Number('pump_displacement', 'cc/rev', 0.1, 5000),
        'relief_pressure_bar': Number('relief_pressure', 'bar', 1, 200),
        'relief_override_bar_per_L_min': Number('relief_override', 'bar/(L/min)', 1e-4, 1000),
        'check_valve_bar_per_L_min': Number('check_valve', 'bar/(L/min)', 1e-4, 1000),
        'flushing_L_min': Number('flushing', 'L/min', 0, 1000, optional=True),
    },
    'supply': {
        'pressure_bar': Number('pressure', 'bar', 1, 1500),
    },
    'valve': {
        'rated_flow_L_min': Number('rated_flow', 'L/min', 1e-3, 10000),
        'rated_pressure_drop_bar': Number('rated_pressure_drop', 'bar', 0.1, 1000),
        'opening_vs_command': Table('opening', (_COMMAND,), 'opening', '1', -1, 1, True),
        'lag_s': Number('lag', 's', 1e-4, 10),
    },
    'controller': {
        'kp_V_per_rad_s': Number('kp', 'V.s/rad', 0, 1000),
        'ki_V_per_rad': Number('ki', 'V/rad', 0, 1000),
        'sample_time_s': Number('sample_time', 's', 1e-4, 10),
        'output_limits_V': Limits('output_limits', 'V'),
    },
}

# What the file of a part (a section of the drive is missing) may leave out: no leakage table
# means no leakage, no efficiency table an efficiency of 1, no displacement curve a pump of fixed
# displacement, no volume of the line one that takes no oil, no numbers of the oil those of
# a mineral oil; the balances that need one of the other numbers are then not judged.
PART: dict[str, tuple[str, ...]] = {
    'pump': ('shaft_speed_rpm', 'max_displacement_cc_rev', 'displacement_vs_command',
             'displacement_lag_s', 'leakage_L_min'),
    'motor': ('displacement_cc_rev', 'inertia_total_kg_m2', 'leakage_L_min',
              'mechanical_efficiency'),
    'line': ('bulk_modulus_Pa', 'volume_m3', 'oil_density_kg_m3', 'oil_grade'),
}

# Sections that one circuit alone has.
ONLY_IN: dict[str, str] = {'charge': 'closed', 'cross_port_relief': 'closed',
                           'supply': 'valve', 'valve': 'valve', 'loading': 'open',
                           'relief_valve': 'open'}

# Suffix of a sensor's keys, and their unit, by channel.
SENSOR_UNITS: dict[str, tuple[str, str]] = {
    name: entry.sensor for name, entry in CHANNELS.items() if entry.hold == 'linear'}

# A unit's displacement curve parts from its sheet's in waves: so many halves along the commands.
WAVES: tuple[str, ...] = tuple(f'pump.displacement_wave_{halves}' for halves in (1, 2, 3))

# So does its hydromotor's efficiency along the pressure, and all that it loses of its torque may
# differ from the sheet's.
BENDS: tuple[str, ...] = ('motor.efficiency_tilt', 'motor.efficiency_bend')
LOSSES: tuple[str, ...] = ('motor.torque_loss', *BENDS)

# What a unit of the same make may differ in: the quantity's name and what it scales.
TOLERANCES: tuple[str, ...] = (
    'motor.displacement', 'motor.inertia', 'line.bulk_modulus', 'pump.displacement_vs_command',
    'pump.displacement_lag', 'pump.leakage', 'motor.leakage', 'motor.mechanical_efficiency',
    'loading.pump_mechanical_efficiency', 'loading.pprv_pressure', 'loading.pprv_lag',
    'loading.pprv_override', 'charge.relief_pressure', 'charge.pump_displacement',
    'gear.efficiency', 'valve.rated_flow', 'valve.lag', 'line.compressibility_under_pressure',
    'pump.displacement_between_points', 'loading.pprv_between_points',
    'pump.displacement_series_lag', *WAVES, *LOSSES,
)
# What a datasheet does not tell and differs in any machine, by so much unless a file says
# otherwise. The bulk modulus of mineral oil rises by 0 to 13 times the pressure; between its
# points a curve is anything from straight to smooth; before the plate stands a valve or an
# amplifier, and one lag is told for both.
UNTOLD: dict[str, float] = {'line.compressibility_under_pressure': 0.07,
                            'pump.displacement_between_points': 0.2,
                            'loading.pprv_between_points': 0.2,
                            'pump.displacement_series_lag': 0.05}
# What is none at 1, and never less than none.
ONE_SIDED: tuple[str, ...] = ('pump.displacement_series_lag',)
# Where the balances of an open drive are judged one by one: a flow is measured to 0.5 % (ISO 4409,
# class A), and so much are all the waves of a curve off together.
UNTOLD_WAVES: dict[str, float] = dict.fromkeys(WAVES, 0.003)
# Where fewer effects may do for a machine. With three times as large waves a suction_starvation of
# 1.3 % hides in an open drive (test_of_another_generator).
DOUBTED: dict[str, float] = {**dict.fromkeys(WAVES, 0.001), **dict.fromkeys(BENDS, 0.005)}

# Written suffix -> unit of the table in units.py, to recognise a key in another unit.
SUFFIXES: dict[str, str] = {
    'rpm': 'rpm', 'rad_s': 'rad/s', 'cc_rev': 'cc/rev', 'm3_rad': 'm^3/rad', 'bar': 'bar',
    'Pa': 'Pa', 'psi': 'psi', 'MPa': 'MPa', 'kPa': 'kPa', 'L_min': 'L/min', 'm3_s': 'm^3/s',
    'V': 'V', 'mV': 'mV', 's': 's', 'ms': 'ms', 'N_m': 'N.m', 'kg_m2': 'kg.m^2', 'm2': 'm^2',
    'mm2': 'mm^2', 'm3': 'm^3', 'L': 'L', 'K': 'K', 'kg_m3': 'kg/m^3', 'in3_rev': 'in^3/rev',
    'bar_per_L_min': 'bar/(L/min)', 'V_per_rad_s': 'V.s/rad', 'V_per_rad': 'V/rad',
}
