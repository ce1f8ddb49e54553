# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Model and PI controller together, beside a recording of both."""
from __future__ import annotations

import math

from hst_drive.control import PiController
from hst_drive.errors import InputError
from hst_drive.measure.noise import noise_std
from hst_drive.measure.readings import filled
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.model import Drive
import numpy as np


def command_noise(command: np.ndarray) -> float:
    """Return the white noise of the command, V: at least what its steps, if any, make."""
    steps = np.abs(np.diff(command))
    steps = steps[steps > 0]
    step = float(steps.min()) if len(steps) else 0.0
    return max(noise_std(command), step / math.sqrt(12.0), 1e-6)


def command_floor(drive: Drive, run: Run, noise: float, speed_floor: float) -> float:
    """
    Return what speed noise does to the command, V.

    Its proportional part is the white noise of the command itself. In the loop the integral is
    an autoregressive process of first order: it decays with ki*G, G the slope of speed over
    command, and so has the variance ki*T/(2*G) times that of the speed.
    """
    controller, pump = drive.rig.controller, drive.rig.pump
    low, high = pump.displacement.x[[0, -1]]
    usual = np.clip(np.nanmedian(run['pump_command']), low, high)
    ends = np.clip([usual - 0.5, usual + 0.5], low, high)
    slope = float(np.diff(pump.displacement(ends))[0] / np.diff(ends)[0])
    gain = max(slope, 1e-12) * pump.shaft_speed / drive.rig.motor.displacement
    memory = controller.ki * controller.sample_time / (2 * gain)
    return math.sqrt(noise**2 + memory * speed_floor**2)


def closed_loop_signals(drive: Drive, run: Run, replay: Replay) -> dict[str, np.ndarray]:
    """Run model and PI controller together against the recorded load."""
    drive.rig.require('controller', purpose='--closed-loop')
    if 'speed_setpoint' not in run:
        raise InputError(f"{run.source}: channel 'speed_setpoint' is missing; --closed-loop needs "
                         'it; leave the option out or name the column with --channels')
    settings = drive.rig.controller
    controller = PiController(settings.kp, settings.ki, settings.sample_time,
                              settings.output_limits)
    controller.reset(float(replay.inputs['pump_command'][0]))
    # The controller steps between rows that are further apart, too.
    steps = np.maximum(np.rint(np.diff(run.time) / settings.sample_time), 1.0)
    places = np.append(0, np.cumsum(steps).astype(int))
    between = np.interp(np.arange(places[-1] + 1), places, np.arange(len(run)))

    def finer(values: np.ndarray, held: bool = False) -> np.ndarray:
        return values[between.astype(int)] if held else np.interp(
            between, np.arange(len(run)), values)

    setpoint = finer(filled(run['speed_setpoint'], hold=True), held=True)
    pprv = finer(replay.inputs['pprv_command'], replay.between.held)
    time, temperature, disturbance = map(finer, (
        run.time, replay.inputs['oil_temperature'], replay.disturbance(drive)))
    state = replay.start(drive)
    rows: list[dict[str, float]] = []
    command, due = 0.0, time[0]
    for k in range(len(time)):
        inputs = {'pprv_command': pprv[k], 'oil_temperature': temperature[k],
                  'load_disturbance': disturbance[k]}
        row = drive.outputs(state, pump_command=command, **inputs)
        while due <= time[k] + 1e-9:
            command = controller.update(setpoint[k], row['motor_speed'])
            due += settings.sample_time
        row['pump_command'] = command
        rows.append(row)
        if k + 1 < len(time):
            state = drive.advance(state, time[k + 1] - time[k], pump_command=command, **inputs)
    return {name: np.array([rows[k][name] for k in places])
            for name in (*replay.signals, 'pump_command')}
