# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario played on a model, with rough ground and the noise of the sensors."""
from __future__ import annotations

from hst_drive.control import PiController
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import Scenario
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank, usual_sensors
import numpy as np

INPUTS = ('pump_command', 'pprv_command', 'oil_temperature')
_RATE = 100.0           # samples per second
_ROUGH_TIME = 0.3       # s over which the ground's roughness is alike
_ROUGH_SHARE = 0.0015   # of the greatest load torque


def rehearse(drive: Drive, scenario: Scenario, seed: int) -> Run:
    """
    Play a scenario on a model.

    Parameters
    ----------
    drive : Drive
        Its rig needs a controller for a scenario in closed loop.
    scenario : Scenario
        What to play.
    seed : int
        Of roughness and sensor noise.

    Returns
    -------
    Run
        All channels of ``usual_sensors`` and the inputs, SI.

    """
    from scipy.signal import lfilter    # here: a diagnosis seldom needs it, and it loads long

    rig, random = drive.rig, np.random.default_rng([seed, 1])
    time = np.arange(int(round(scenario.duration * _RATE))) / _RATE
    decay = np.exp(-1.0 / _RATE / _ROUGH_TIME)
    unit = LoadingUnit.of(rig.loading)
    size = _ROUGH_SHARE * unit.torque_of_command(unit.command[-1], 0.0)
    rough = lfilter([size * np.sqrt(1 - decay**2)], [1, -decay],
                    random.standard_normal(len(time)))
    speed = scenario.speed_setpoint.sample(time)
    inputs = {'pprv_command': np.array([scenario.load.pprv_command(at) for at in time.tolist()]),
              'oil_temperature': scenario.oil_temperature.sample(time),
              'load_disturbance': rough}
    bank = SensorBank(rig, seed)
    bank.sensors = usual_sensors(rig)
    if scenario.pump_command is None:
        inputs['pump_command'] = _controlled(drive, time, speed, inputs,
                                             bank.sensors['motor_speed'].noise_std, random)
    else:
        inputs['pump_command'] = np.clip(scenario.pump_command.sample(time),
                                         *rig.controller.output_limits)
    readings = bank.read(drive.simulate(time, inputs, drive.initial_state()))
    return Run(scenario.title, time, {**readings, **{name: inputs[name] for name in INPUTS}},
               scenario.source, ())


def _controlled(drive: Drive, time: np.ndarray, setpoint: np.ndarray, inputs, noise: float,
                random: np.random.Generator) -> np.ndarray:
    """Return the pump commands (V) of the rig's controller."""
    law = drive.rig.controller
    controller = PiController(law.kp, law.ki, law.sample_time, law.output_limits)
    commands = np.empty(len(time))
    state = drive.initial_state()
    errors = noise * random.standard_normal(len(time))
    step, due = float(time[1] - time[0]), 0.0
    for k, at in enumerate(time.tolist()):
        if at >= due - 1e-9:
            controller.update(float(setpoint[k]), float(state[2] + errors[k]))
            due += max(law.sample_time, step)
        commands[k] = controller.command
        state = drive.advance(
            state, step, pump_command=commands[k], pprv_command=inputs['pprv_command'][k],
            oil_temperature=inputs['oil_temperature'][k],
            load_disturbance=inputs['load_disturbance'][k])
    return commands
