# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Readings of the machine: channel, noise, resolution, and the CSV file."""
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from bench.frozen import equations as eq
from bench.frozen.plant import BAR, CC, LPM, RPM
import numpy as np


class Sensor(NamedTuple):
    """A reading: column of the solver's rows, unit of the log, noise and resolution in it."""

    column: int
    unit: str
    si: float           # SI units in one unit of the log
    noise: float
    step: float


#: Name of a fault of a sensor: what it makes of the clean reading (unit of the log).
Fault = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
#: Channels that each log has besides the readings.
INPUTS = ('time[s]', 'pump_command[V]', 'pprv_command[V]', 'speed_setpoint[rpm]')


def sensors(sheet: dict) -> dict[str, Sensor]:
    """Return the sensors of a rig; those that its datasheet does not list are of usual quality."""
    given = sheet['sensors']
    shaft = sheet['pump']['shaft_speed_rpm']
    stroke = sheet['pump']['max_displacement_cc_rev']

    def listed(name: str, unit: str, column: int, log_unit: str, si: float) -> Sensor:
        return Sensor(column, log_unit, si, float(given[name][f'noise_std_{unit}']),
                      float(given[name][f'resolution_{unit}']))

    outlet = listed('pump_outlet_pressure', 'bar', eq.O_P, 'bar', BAR)
    flow = listed('motor_inlet_flow', 'L_min', eq.O_FLOW, 'L/min', LPM)
    return {
        'oil_temperature': listed('oil_temperature', 'K', -1, 'degC', 1.0),
        'pump_outlet_pressure': outlet,
        'motor_inlet_flow': flow,
        'motor_speed': listed('motor_speed', 'rpm', eq.O_READ, 'rpm', RPM),
        'load_torque': listed('load_torque', 'N_m', eq.O_TORQUE, 'N.m', 1.0),
        'motor_inlet_pressure': outlet._replace(column=eq.O_P_MOTOR),
        'pump_speed': Sensor(eq.O_SHAFT, 'rpm', RPM, 3e-4 * shaft, 1e-4 * shaft),
        'pump_displacement': Sensor(eq.O_STROKE, 'cc/rev', CC, 1e-3 * stroke, 5e-4 * stroke),
        'case_drain_flow': flow._replace(column=eq.O_DRAIN, noise=0.4 * flow.noise,
                                         step=0.4 * flow.step),
    }


def clean(rows: np.ndarray, oil: np.ndarray, which: dict[str, Sensor],
          faults: dict[str, list[Fault]]) -> dict[str, np.ndarray]:
    """Return what the sensors say each millisecond but for noise and resolution."""
    t = np.arange(len(rows)) * 1e-3
    said = {}
    for name, sensor in which.items():
        values = oil if sensor.column < 0 else rows[:, sensor.column] / sensor.si
        for fault in faults.get(name, ()):
            values = fault(t, values, rows)
        said[name] = values
    return said


def write(path: Path, rows: np.ndarray, said: dict[str, np.ndarray], which: dict[str, Sensor],
          target: np.ndarray, each_ms: int, speed_noise: np.ndarray, rng: np.random.Generator,
          rig_top: float, words: dict[str, Fault], leave_out: tuple[str, ...]) -> None:
    """
    Write a log.

    ``speed_noise`` [rpm] is what the controller has seen, too. ``rig_top`` is the end of the
    pressure sensor's range [bar]. ``words`` are faults of the converter: they act after it.
    """
    at = np.arange(0, len(rows), each_ms)
    columns = {'time[s]': at * 1e-3, 'pump_command[V]': rows[at, eq.O_U],
               'pprv_command[V]': rows[at, eq.O_V],
               'speed_setpoint[rpm]': target[at // (len(rows) // len(target))] / RPM}
    for name, sensor in which.items():
        noise = rng.standard_normal(len(at)) * sensor.noise
        if name == 'motor_speed':
            noise = speed_noise[at]
        values = np.rint((said[name][at] + noise) / sensor.step) * sensor.step
        if 'pressure' in name:
            values = np.clip(values, 0.0, rig_top)
        if name in words:
            values = words[name](columns['time[s]'], values, rows[at])
        columns[f'{name}[{sensor.unit}]'] = values + 0.0     # No minus zero.
    kept = {name: v for name, v in columns.items() if name.split('[')[0] not in leave_out}
    np.savetxt(path, np.column_stack(list(kept.values())), fmt='%.6g', delimiter=',',
               header=','.join(kept), comments='')
