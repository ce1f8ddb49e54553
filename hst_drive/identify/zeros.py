# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What sensors read beyond the truth throughout, and how late: what is fitted, how far it may go.

An amplifier filters, a bus takes its time, and no two channels are alike in that. So each reading
has a delay of its own; that all of them have together says the same as the actuator's lag.
"""
from __future__ import annotations

from typing import Sequence

from hst_drive.channels import CHANNELS, TORQUES
from hst_drive.identify.model import Model
from hst_drive.measure.part import PartReplay
from hst_drive.measure.replay import Replay
from hst_drive.rig import Rig
import numpy as np

LATE = '.delay'         # behind a channel's name: how late that reads
DELAY = 0.005           # s, one sigma: amplifiers filter from 30 Hz on, and a bus takes its time
LEARNT_DELAY = 0.0005   # s: of a machine whose delays were learnt


def zeros_of(rig: Rig, replays: Sequence[Replay | PartReplay],
             by_balance: bool) -> dict[str, float]:
    """
    Return one standard deviation (SI) of the zero of each sensor that is fitted.

    What was learnt of a machine comes before what its rig file states, and that before what is
    usual where logs are judged ``by_balance``.
    """
    stated = {name: sensor.zero_std for name, sensor in rig.sensors.items() if sensor.zero_std}
    learnt = rig.fingerprint.zeros if rig.fingerprint else {}
    found = {**(_usual(replays) if by_balance else {}), **stated,
             **{name: sigma for name, (_, sigma) in learnt.items()}}
    recorded = {name for replay in replays for name in replay.sensor_noise}
    return {name: value for name, value in found.items() if name in recorded}


def delays_of(rig: Rig, replays: Sequence[Replay | PartReplay],
              usual: float = 0.0) -> dict[str, float]:
    """
    Return one standard deviation (s) of how late each sensor reads, by 'channel.delay'.

    It is ``usual`` where the rig file does not say; what is 0 is left out.
    """
    stated = {name: sensor.delay_std for name, sensor in rig.sensors.items()
              if sensor.delay_std is not None}
    # Operating points have no time.
    recorded = {name for replay in replays if not replay.static for name in replay.sensor_noise
                if CHANNELS[name].hold == 'linear' and not CHANNELS[name].slow}
    return {f'{name}{LATE}': sigma for name in sorted(recorded)
            if (sigma := stated.get(name, usual))}


def _usual(replays: Sequence[Replay | PartReplay]) -> dict[str, float]:
    """Return those of gauges, and of the torque beside them: no better than they scatter."""
    found: dict[str, float] = {}
    for replay in replays:
        for name, noise in replay.sensor_noise.items():
            if (CHANNELS[name].unit == 'Pa' or name in TORQUES) and noise > 0.0:
                found[name] = min(noise, found.get(name, np.inf))
    return found if any(CHANNELS[name].unit == 'Pa' for name in found) else {}


def as_read(rig: Rig, model: Model) -> tuple[dict[str, float], dict[str, float]]:
    """
    Return what each sensor reads beyond the truth (SI), and how late it reads (s), by channel.

    Both as known of the machine, and what the model has more.
    """
    late = {key.removesuffix(LATE): delay for key, delay in model.delays.items()}
    zeros, delays = ({name: known.get(name, 0.0) + more.get(name, 0.0)
                      for name in {**known, **more}}
                     for known, more in ((rig.zeros, model.zeros), (rig.delays, late)))
    return zeros, delays
