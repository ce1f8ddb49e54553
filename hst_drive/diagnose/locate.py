# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which balance fails, in its own unit, and over which variables.

Each balance is judged alone by feeding it the measured signals of the others: one wrong
equation does not spoil the next. The equations are those of the drill-drive paper with the
effects and factors of a fitted model; the signals are smoothed over a window, so that no noise
is differentiated.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d

from hst_drive.diagnose.campaign import Campaign
from hst_drive.diagnose.fit import Fit
from hst_drive.measure.replay import Replay
from hst_drive.measure.where import operating_variables

WINDOW = 0.15       # s, standard deviation of the smoothing


class Balance(NamedTuple):
    """
    What is left of one balance.

    Attributes
    ----------
    name : str
        'pump flow', 'motor flow', 'torque' or 'load'.
    enters : str
        Place in the drive in the words of the results.
    signal : str
        The signal that shows it most directly.
    unit : str
        SI unit of the residual.
    residual : list of ndarray
        One array per log, smoothed; positive where the measurement needs more.
    ratio : float
        Rms of the residual over what the sensors' noise explains of it.

    """

    name: str
    enters: str
    signal: str
    unit: str
    residual: list[np.ndarray]
    ratio: float


def balances(campaign: Campaign, model: Fit) -> list[Balance]:
    """
    Return what is left of each balance that the channels close, the worst first.

    Parameters
    ----------
    campaign : Campaign
        The recordings.
    model : Fit
        Effects and factors to judge.

    """
    drive = campaign.driver(model.model)
    found = []
    given = [replay.predict(drive).signals for replay in campaign.replays]
    for name, enters, signal, unit, needs, formula in _BALANCES:
        if not all(channel in replay.run for replay in campaign.replays for channel in needs):
            continue
        parts, noises = [], []
        for replay, signals in zip(campaign.replays, given):
            residual, noise = formula(replay, signals)
            width = max(WINDOW / replay.run.sample_time, 0.5)
            smooth = gaussian_filter1d(residual, width)
            smooth[replay.run.time - replay.run.time[0] < 1.0] = 0.0
            parts.append(smooth)
            # White noise through a Gaussian window of standard deviation w samples.
            noises.append(noise / np.sqrt(2 * np.sqrt(np.pi) * width))
        rms = np.sqrt(np.mean(np.concatenate(parts)**2))
        found.append(Balance(name, enters, signal, unit, parts,
                             float(rms / np.sqrt(np.mean(np.square(noises))))))
    return sorted(found, key=lambda item: -item.ratio)


def variables(campaign: Campaign) -> list[dict[str, np.ndarray]]:
    """Return what a residual may depend on, log by log, SI."""
    return [operating_variables(replay.run) for replay in campaign.replays]


def _load(replay: Replay, signals: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    name = replay.torque
    residual = _filled(replay.run[name]) - signals[name]
    return residual, np.hypot(replay.noise[name], 3 * replay.roughness.std)


def _torque(replay: Replay, signals: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    # Where the replay's torque is right, a pressure error is a torque missing at the shaft.
    error = _filled(replay.run['pump_outlet_pressure']) - signals['pump_outlet_pressure']
    drive = replay.reference
    scale = drive.rig.motor.displacement * 0.88
    return error * scale, replay.noise['pump_outlet_pressure'] * scale * 2


def _motor_flow(replay: Replay, signals: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    displacement = replay.reference.rig.motor.displacement
    flow = _filled(replay.run['motor_inlet_flow']) - signals['motor_inlet_flow']
    speed = _filled(replay.run['motor_speed']) - signals['motor_speed']
    noise = np.hypot(replay.noise['motor_inlet_flow'], displacement * replay.noise['motor_speed'])
    return flow - displacement * speed, noise


def _pump_flow(replay: Replay, signals: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    flow = signals['motor_inlet_flow'] - _filled(replay.run['motor_inlet_flow'])
    return flow, 1.5 * replay.noise['motor_inlet_flow']


def _drive_flow(replay: Replay, signals: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    displacement = replay.reference.rig.motor.displacement
    speed = signals['motor_speed'] - _filled(replay.run['motor_speed'])
    return displacement * speed, 1.5 * displacement * replay.noise['motor_speed']


_BALANCES = (
    ('pump flow', 'flow', 'motor_inlet_flow', 'm^3/s', ('motor_inlet_flow',), _pump_flow),
    ('motor flow', 'flow', 'motor_speed', 'm^3/s', ('motor_inlet_flow', 'motor_speed'),
     _motor_flow),
    ('torque', 'torque', 'pump_outlet_pressure', 'N.m', ('pump_outlet_pressure',), _torque),
    ('load', 'load', 'load_torque', 'N.m', ('load_torque', 'motor_speed'), _load),
)


def _filled(values: np.ndarray) -> np.ndarray:
    bad = ~np.isfinite(values)
    if not bad.any():
        return values
    index = np.arange(len(values))
    return np.interp(index, index[~bad], values[~bad])
