# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Ways of the pump to answer its command, and of sensors to read, that no effect lists.

Each has one number. The pump's are tried by giving the model another command: that on which its
pump does what this one does on the recorded command.
"""
from __future__ import annotations

import copy
from typing import Any, Callable, NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.identify.campaign import Campaign
from hst_drive.measure.replay import STAMPS
from hst_drive.model.lags import follow
from hst_drive.rig.rig import Pump
import numpy as np


class Timing(NamedTuple):
    """
    A way to answer: ``change(campaign, number)`` changes a copy of a campaign.

    ``told(number)`` says what it is, for numbers between ``bounds`` (None: of a delay, which rows
    tell without a simulation). ``signal`` is the reading that is late; '': the pump is.
    """

    change: Callable[[Campaign, float], None]
    told: Callable[[float], str]
    bounds: tuple[float, float] | None = None
    signal: str = ''


def with_timing(campaign: Campaign, timing: Timing, number: float) -> Campaign:
    """Return the campaign with a drive that answers in this way."""
    changed = campaign.copied()
    timing.change(changed, number)
    return changed


def _of_the_pump(change: Callable[[Pump, np.ndarray, np.ndarray, float], np.ndarray],
                 told: Callable[[float], str], *more: Any) -> Timing:
    def changed(campaign: Campaign, number: float) -> None:
        for replay in campaign.replays:
            replay.command(change(campaign.rig.pump, replay.run.time,
                                  replay.inputs['pump_command'], number))

    return Timing(changed, told, *more)


def _later(pump: Pump, time: np.ndarray, command: np.ndarray, delay: float) -> np.ndarray:
    return np.interp(time - delay, time, command)


def _one_more_lag(pump: Pump, time: np.ndarray, command: np.ndarray, lag: float) -> np.ndarray:
    return follow(time, command, max(lag, STAMPS))


def _one_way_slower(pump: Pump, time: np.ndarray, command: np.ndarray,
                    slower: float) -> np.ndarray:
    """Return the command for a plate whose lag is longer on the way down, or if < 0 up."""
    usual = max(pump.displacement_lag, STAMPS)   # the sheet may give none
    aims = pump.displacement(command)
    reached = follow(time, aims, usual * (1.0 + max(-slower, 0.0)),
                     back_lag=usual * (1.0 + max(slower, 0.0)))
    needed = reached[:-1] + np.diff(reached) / -np.expm1(-np.diff(time) / usual)
    return pump.command_of(np.append(needed, aims[-1]))


def reads_late(signal: str) -> tuple[Timing, Timing]:
    """Return a sensor that reads late: a filter's lag, and a clock's that may be early (< 0)."""
    def filtered(campaign: Campaign, lag: float) -> None:
        for replay in campaign.replays:
            replay.readings = copy.copy(replay.readings)
            replay.readings.lags = {signal: lag}

    def moved(campaign: Campaign, delay: float) -> None:
        for replay in campaign.replays:
            if signal in replay.run:
                replay.read_earlier(signal, delay)

    def told(delay: float) -> str:
        early = 'lead' if delay < 0.0 else 'lag'
        return f'a {early} of {1e3 * abs(delay):.0f} ms in the reading of {CHANNELS[signal].title}'

    return (Timing(filtered, told, (1e-3, 1.0), signal),
            Timing(moved, told, signal=signal))


DEAD_TIME = _of_the_pump(_later, lambda delay: f'a dead time of {1e3 * delay:.0f} ms',
                         (0.0, 0.4))
ONE_MORE_LAG = _of_the_pump(_one_more_lag, lambda lag: f'one more lag of {1e3 * lag:.0f} ms',
                            (0.0, 0.4))
ONE_WAY_SLOWER = _of_the_pump(_one_way_slower, lambda slower: (
    f"a lag that is {1 + abs(slower):.3g} times as long on the plate's way "
    + ('down as up' if slower > 0 else 'up as down')), (-4.0, 4.0))
LATE_READINGS = ('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_inlet_flow',
                 'load_torque', 'motor_torque')
