# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
THE table of channels: what a log may hold. A line here declares all of a channel.

Logs, topics, keys of sensors in rig files, the documentation and the signals that a diagnosis may
use go by it.
"""
from __future__ import annotations

from typing import NamedTuple

from hst_drive.units import si_unit


class Channel(NamedTuple):
    """
    A quantity that a log may hold.

    Attributes
    ----------
    name, title : str
        For files and for people.
    display : str
        Unit for people.
    frame : str
        Where it is measured.
    hold : str
        What lies between two samples: commands stay ('zero'), analogue signals move on a
        straight line ('linear').
    publisher : str
        The node that publishes it; 'rig': only a real one does.
    on : bool
        Published by default.
    joint : str
        Topic of the JointState that carries it; without one it has a topic of its own.
    slow : bool
        Changes in minutes: gaps are bridged, and its sensor's noise is no motion.
    noise : float
        Of a sensor of the usual kind, as a share of the largest value that the drive reaches.

    """

    name: str
    display: str
    title: str
    frame: str
    hold: str = 'linear'
    publisher: str = 'plant'
    on: bool = False
    joint: str = ''
    slow: bool = False
    noise: float = 0.0

    @property
    def unit(self) -> str:
        """SI unit."""
        return si_unit(self.display)

    @property
    def sensor(self) -> tuple[str, str]:
        """Suffix of its sensor's keys in a rig file, and their unit: that of a difference."""
        unit = 'K' if self.display == 'degC' else self.display
        return unit.replace('/', '_').replace('.', '_'), unit


def _command(name: str, unit: str, title: str, frame: str, publisher: str, on: bool) -> Channel:
    return Channel(name, unit, title, frame, 'zero', publisher, on)


CHANNELS: dict[str, Channel] = {entry.name: entry for entry in (
    _command('pump_command', 'V', 'pump displacement command', 'pump', 'controller', True),
    _command('pprv_command', 'V', 'PPRV command', 'pprv', 'load_profile', True),
    _command('speed_setpoint', 'rpm', 'speed set point', 'motor', 'load_profile', True),
    Channel('oil_temperature', 'degC', 'oil temperature', 'oil', on=True, slow=True),
    Channel('pump_speed', 'rpm', 'pump shaft speed', 'pump', joint='pump', noise=1e-4),
    Channel('pump_outlet_pressure', 'bar', 'pump outlet pressure', 'pump_outlet', on=True,
            noise=6e-4),
    Channel('motor_inlet_pressure', 'bar', 'hydromotor inlet pressure', 'motor_inlet',
            noise=6e-4),
    Channel('motor_outlet_pressure', 'bar', 'hydromotor outlet pressure', 'motor_outlet',
            noise=6e-4),
    Channel('motor_inlet_flow', 'L/min', 'hydromotor inlet flow', 'motor_inlet', on=True,
            noise=1.2e-3),
    Channel('case_drain_flow', 'L/min', 'case drain flow', 'motor_case', noise=2.5e-4),
    Channel('motor_speed', 'rpm', 'hydromotor speed', 'motor', on=True, joint='motor',
            noise=7.3e-4),
    Channel('load_torque', 'N.m', 'load torque', 'motor', on=True, joint='motor', noise=1.5e-3),
    Channel('pump_displacement', 'cc/rev', 'pump displacement', 'pump', noise=7e-4),
    Channel('motor_torque', 'N.m', 'hydromotor shaft torque', 'motor'),
    Channel('pump_torque', 'N.m', 'pump shaft torque', 'pump', publisher='rig'),
    Channel('pump_power', 'kW', 'pump shaft power', 'pump', publisher='rig'),
    Channel('line_a_pressure', 'bar', 'pressure of line A', 'line_a'),
    Channel('line_b_pressure', 'bar', 'pressure of line B', 'line_b'),
    Channel('charge_pressure', 'bar', 'charge pressure', 'charge'),
    _command('valve_command', 'V', 'valve command', 'valve', 'rig', False),
    _command('motor_displacement_command', 'V', 'hydromotor displacement command', 'motor',
             'rig', False),
)}

COMMANDS = ('pump_command', 'pprv_command')
LINES = ('line_a_pressure', 'line_b_pressure')
PRESSURES = ('motor_inlet_pressure', 'pump_outlet_pressure')    # of the line under pressure
TORQUES = ('motor_torque', 'load_torque')
