# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a drive that the model describes exactly, with noise and a rough load."""
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig
import numpy as np


def coloured(random, n, step, std, time_constant):
    """Return an Ornstein-Uhlenbeck process, shape (n,)."""
    from scipy.signal import lfilter

    decay = np.exp(-step / time_constant)
    kicks = std * np.sqrt(1 - decay**2) * random.standard_normal(n)
    kicks[0] = std * random.standard_normal()
    return lfilter([1.0], [1.0, -decay], kicks)


def record(seed=0, *, duration=30.0, rate=100, roughness=1.5, time_constant=0.1, noise=1.0,
           leave_out=(), effects=None, rig=None, settled=False):
    """
    Make a recording: steps and ramps of both commands, running from the first sample on.

    Unless ``settled`` the pump's command steps at the first sample.
    ``noise`` scales that of the torque sensor alone.
    """
    random = np.random.default_rng(seed)
    rig = rig or default_rig()
    drive = Drive(rig, effects)
    step = 1e-3 if rate >= 100 else 1 / 1000
    time = np.arange(int(duration / step)) * step
    part = np.minimum((time / 3.0).astype(int), 99)
    pump = random.uniform(4.4, 6.4, 100)[part]
    pprv = random.uniform(1.8, 4.4, 100)[part] + 0.3 * np.sin(2 * np.pi * time / 7)
    start = operating_point(drive, 10.0, pprv_command=pprv[0])
    if settled:
        pump[part == 0] = start.pump_command
    # What a recorder stores is what was held.
    every = round(1 / rate / step)
    held = np.arange(len(time)) // every * every
    pump, pprv = pump[held], pprv[held]
    temperature = 323.15 + 5 * np.sin(2 * np.pi * time / 40)
    load = coloured(random, len(time), step, roughness, time_constant)
    state = start.state.copy()
    exact = drive.simulate(time, {'pump_command': pump, 'pprv_command': pprv,
                                  'oil_temperature': temperature, 'load_disturbance': load},
                           state)
    exact['oil_temperature'] = temperature
    readings = SensorBank(rig, seed + 1).read({name: exact[name] for name in rig.sensors})
    torque = exact['load_torque'] + noise * rig.sensors['load_torque'].noise_std * (
        random.standard_normal(len(time)))
    if noise != 1.0:
        readings['load_torque'] = torque
    channels = {'pump_command': pump, 'pprv_command': pprv, **readings}
    return Run(f'synthetic {seed}', time[::every], {
        name: values[::every].copy() for name, values in channels.items()
        if name not in leave_out}, 'synthetic.csv')
