# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A log for the first visit: the shipped rig with a hidden effect, the same on every machine."""
from __future__ import annotations

from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.steady import operating_point
from hst_drive.rig import Rig
import numpy as np
from scipy.signal import lfilter

HIDDEN = {'motor_leakage': {'conductance': 1.4e-12}}
_STEP = 0.01            # s
_HOLD = 4.0             # s between steps of the commands
_ROUGHNESS = 1.5        # N.m, standard deviation of the load's roughness
_MEMORY = 0.1           # s


def sample_logs(rig: Rig) -> tuple[Run, Run]:
    """Return a log of a minute to fit on and one to judge on."""
    return _record(rig, 'sample', 60.0, 5), _record(rig, 'sample held out', 40.0, 6)


def _record(rig: Rig, name: str, duration: float, seed: int) -> Run:
    random = np.random.default_rng(seed)
    drive = Drive(rig, HIDDEN)
    time = np.arange(round(duration / _STEP)) * _STEP
    part = (time / _HOLD).astype(int)
    pump = np.round(random.uniform(4.4, 6.4, part[-1] + 1), 2)[part]
    # One level after the other, in an order by chance: the load visits all of its range.
    levels = np.linspace(1.4, 4.6, part[-1] + 1)
    pprv = np.round(random.permutation(levels), 2)[part]
    temperature = 323.15 + 2 * np.sin(2 * np.pi * time / 50)
    decay = np.exp(-_STEP / _MEMORY)
    load = lfilter([_ROUGHNESS * np.sqrt(1 - decay**2)], [1, -decay],
                   random.standard_normal(len(time)))
    start = operating_point(drive, 10.0, pprv_command=float(pprv[0]))
    exact = drive.simulate(time, {'pump_command': pump, 'pprv_command': pprv,
                                  'oil_temperature': temperature, 'load_disturbance': load},
                           start.state.copy())
    exact['oil_temperature'] = temperature
    wanted = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque',
              'oil_temperature')
    readings = SensorBank(rig, seed).read({key: exact[key] for key in wanted})
    return Run(name, time, {'pump_command': pump, 'pprv_command': pprv, **readings}, '')
