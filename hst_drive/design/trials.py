# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Tests that a rig can play: load and command profiles within its limits.

A trial is a row of segments, each of a family (load steps at several speeds, standstill under
load, ...) with parameters drawn from a seed, and becomes a scenario that ``load_profile`` and
``controller`` play.
"""
from __future__ import annotations

from typing import Callable, NamedTuple

from hst_drive.design.families import DRAWN, Knots, Pen, STEP
from hst_drive.errors import InputError
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
from hst_drive.units import from_si
import numpy as np

LONGEST = 120.0         # s
SPIN_UP = 3.0           # s, lightly loaded, before the first segment
MARGIN = 0.65           # of the relief valve's set pressure: what steady load may ask for
_WARM_EASE = 0.8        # warming the oil takes time and a heater
_BRAKE = 0.5            # of what the light load takes: the line stays filled
_SLOWEST = 10.0         # s from the highest speed to standstill, where there is hardly a load
_LIGHT = 0.1            # of the greatest load: below, tables are steep and units differ most
_WARMING = 15.0         # K either side of the temperature at which the tables were measured


class Limits(NamedTuple):
    """
    Speeds (rad/s) and PPRV commands (V) between which a trial stays; 0 speed is standstill.

    ``brake`` is how fast it slows down at most, rad/s^2: quicker than the load stops the drive,
    its line runs empty.
    """

    slow: float
    fast: float
    light: float
    heavy: float
    brake: float


class Segment(NamedTuple):
    """Family, seed of its parameters and duration (s)."""

    family: str
    seed: int
    duration: float


class Trial(NamedTuple):
    """Segments one after the other, at constant oil temperature or while it warms up."""

    segments: tuple[Segment, ...]
    warming: bool = False

    @property
    def duration(self) -> float:
        """Of the whole, s."""
        return SPIN_UP + sum(segment.duration for segment in self.segments)

    @property
    def words(self) -> str:
        """The trial for people."""
        told = ', then '.join(dict.fromkeys(DRAWN[part.family].words for part in self.segments))
        return told + (f', while the oil warms up by {2 * _WARMING:.0f} K' if self.warming else '')


def limits(rig: Rig) -> Limits:
    """
    Return what a rig can do with a margin to its relief valve, pump and tables.

    Raise InputError if the rig lacks a section.
    """
    if rig.circuit == OPEN and not rig.whole:
        raise InputError(f'{rig.source or rig.name}: describes a part of a drive; tests are '
                         'designed for whole drives; what to record of a part is said by the '
                         'diagnosis of its logs')
    rig.require('pump', 'motor', 'line', 'relief_valve', 'loading', 'controller',
                purpose='the design of a test')
    pump, motor = rig.pump, rig.motor
    pressure = MARGIN * rig.relief_valve.set_pressure
    sensor = rig.sensors.get('pump_outlet_pressure')
    if sensor and sensor.range:
        pressure = min(pressure, 0.95 * sensor.range[1])
    flow = 0.85 * float(pump.displacement(rig.controller.output_limits[1])) * pump.shaft_speed
    fast = min(flow / motor.displacement, float(motor.leakage.y[-1]))
    torque = motor.displacement * pressure * float(motor.mechanical_efficiency(pressure, fast))
    unit = LoadingUnit.of(rig.loading)
    commands = np.linspace(unit.command[0], unit.command[-1], 101)
    fitting = [value for value in commands if unit.torque_of_command(value, fast) <= torque]
    heavy = float(max(fitting, default=commands[0]))
    slow = 0.12 * fast
    least = _LIGHT * unit.torque_of_command(heavy, fast)
    # The load grows with the speed: what is light must be a load at the lowest speed, too.
    light = float(min(next((value for value in commands
                            if unit.torque_of_command(value, slow) >= least), heavy), heavy))
    brake = _BRAKE * unit.torque_of_command(light, slow) / motor.inertia
    return Limits(slow, fast, light, heavy, max(brake, fast / _SLOWEST))


def plain_drilling(duration: float) -> Trial:
    """Return what everybody has recorded."""
    return Trial((Segment('drilling', 0, duration - SPIN_UP),))


def ease(trial: Trial) -> float:
    """Return what an expected significance is worth, at most 1."""
    families = {segment.family for segment in trial.segments}
    return float(np.prod([DRAWN[name].ease for name in families])) * (
        _WARM_EASE if trial.warming else 1.0)


def scenario(trial: Trial, rig: Rig, closed_loop: bool, title: str = 'Test') -> dict:
    """Return a trial as the mapping of a scenario file."""
    bounds = limits(rig)
    pen = Pen(bounds.brake)
    pen.speed.append((0.0, 0.0))
    pen.load.append((0.0, bounds.light))
    pen.go(0.4 * bounds.fast, bounds.light, SPIN_UP - STEP, 2.0)
    start = SPIN_UP
    for segment in trial.segments:
        pen.time = max(pen.time, start)
        DRAWN[segment.family].draw(pen, np.random.default_rng(segment.seed), bounds,
                                   segment.duration)
        start += segment.duration
    base = float(from_si(rig.characterised_at, 'degC'))
    content: dict = {
        'title': title, 'description': f'{trial.words[0].upper()}{trial.words[1:]}.',
        'mode': 'closed_loop' if closed_loop else 'open_loop',
        'duration_s': round(trial.duration, 2)}
    speed, load = _tidy(pen.speed, start), _tidy(pen.load, start)
    if closed_loop:
        content['speed_setpoint'] = _ramps(
            speed, 'speed_rpm', lambda time, value: from_si(value, 'rpm'), 2)
    else:
        command = _commands(rig, load)
        content['pump_command'] = _ramps(speed, 'command_V', command, 3)
    content['pprv_command'] = _ramps(load, 'command_V', lambda time, value: value, 3)
    content['oil_temperature'] = {
        'kind': 'ramps', 'time_s': [0, round(trial.duration, 2)],
        'temperature_degC': [round(base - _WARMING, 2), round(base + _WARMING, 2)],
    } if trial.warming else {'temperature_degC': round(base, 2)}
    return content


def _tidy(knots: Knots, end: float) -> Knots:
    """Drop what lies beyond the end, and knots on a level between others."""
    kept: Knots = []
    for time, value in knots:
        if kept and time <= kept[-1][0] + 1e-3 or time > end + 1e-9:
            continue
        if len(kept) > 1 and kept[-1][1] == value == kept[-2][1]:
            kept.pop()
        kept.append((round(float(time), 3), float(value)))
    return kept


def _ramps(knots: Knots, key: str, convert: Callable[[float, float], float],
           digits: int) -> dict:
    return {'kind': 'ramps', 'time_s': [time for time, _ in knots],
            key: [round(float(convert(time, value)), digits) for time, value in knots]}


def _commands(rig: Rig, load: Knots) -> Callable[[float, float], float]:
    """Return the pump command (V) that gives a speed (rad/s) under the load at that time."""
    pump, motor, unit = rig.pump, rig.motor, LoadingUnit.of(rig.loading)
    table = pump.displacement
    rising = np.concatenate([np.diff(table.y) > 0, [True]])
    times, values = zip(*load)

    def command(time: float, speed: float) -> float:
        if speed <= 0.0:
            return rig.controller.output_limits[0]
        torque = unit.torque_of_command(float(np.interp(time, times, values)), speed)
        pressure, asked = torque / motor.displacement, 0.0
        for _ in range(8):
            pressure = torque / (motor.displacement * max(
                float(motor.mechanical_efficiency(pressure, speed)), 0.1))
            flow = (motor.displacement * speed + float(motor.leakage(pressure, speed))
                    + float(pump.leakage(pressure, asked)))
            asked = float(np.interp(flow / pump.shaft_speed, table.y[rising], table.x[rising]))
        return float(np.clip(asked, *rig.controller.output_limits))

    return command
