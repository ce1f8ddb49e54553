# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law that holds the hydromotor speed by moving the pump displacement."""
from __future__ import annotations

from collections.abc import Callable
import math

_KNEE = 0.05    # V: within it the step over a dead band is a slope, so that noise does not chatter
ANTIWINDUP_STRATEGIES = ('conditional_integration', 'back_calculation', 'none')


class PiController:
    """
    PI law on the speed error, with limits and anti-windup.

    Every ``sample_time``, with ``e = setpoint - measured`` of this very sample::

        raw      = kp * e + integral (+ feed_forward(setpoint))
        command  = clip(raw, u_clamp_min, u_clamp_max)
        integral = integral + ki * e * sample_time        (seen by the NEXT command)

    This order (forward rule: the error enters the integral after the command is formed, and
    the command holds until the next sample) is the one that the rig's recordings follow: their
    first command is ``kp * e`` alone. The controller reads the speed with its sensor noise.
    Where another time than ``sample_time`` has passed, the integral has that time of the error.

    Parameters
    ----------
    kp : float
        Proportional gain, V.s/rad, not negative.
    ki : float
        Integral gain, V/rad, not negative.
    sample_time : float
        Seconds between updates.
    limits : (float, float)
        ``u_clamp_min`` and ``u_clamp_max`` of the command, V. With a negative one the drive turns
        either way: 0 V is zero stroke.
    antiwindup_strategy : str
        Names as in ros2_controllers. 'conditional_integration': while the command is clipped
        the integral is held, unless the error drives the command back inside. (Holding it
        then too, as the datasheet's words can be read, could lock the command at its limit.)
        'back_calculation': the integral is drawn towards the limit with
        ``tracking_time_constant``. 'none': it winds up.
    tracking_time_constant : float, optional
        Seconds, for 'back_calculation'; default ``kp / ki``.
    setpoint_rate_limit : float, optional
        Largest change of the set point, rad/s^2. After a reset it starts from the measured
        speed. None: no limit.
    feed_forward : callable, optional
        Command in V for a set point in rad/s; see ``PumpFeedForward``. None: off.
    dead_band : float
        V to either side of 0 V in which the pump gives nothing: the command steps over it, and
        all above counts from its edge.

    Raises
    ------
    ValueError
        For a gain, time, limit or strategy that makes no sense.

    """

    def __init__(self, kp: float, ki: float, sample_time: float,
                 limits: tuple[float, float] = (0.0, 10.0), *,
                 antiwindup_strategy: str = 'conditional_integration',
                 tracking_time_constant: float | None = None,
                 setpoint_rate_limit: float | None = None,
                 feed_forward: Callable[[float], float] | None = None, dead_band: float = 0.0):
        self.u_clamp_min, self.u_clamp_max = (float(limit) for limit in limits)
        self.kp, self.ki, self.sample_time = float(kp), float(ki), float(sample_time)
        if not all(map(math.isfinite, (self.kp, self.ki))) or self.kp < 0 or self.ki < 0:
            raise ValueError(f'gains kp={kp}, ki={ki}: expected numbers that are not negative')
        if not 0 < self.sample_time < math.inf:
            raise ValueError(f'sample_time={sample_time}: expected a positive number of seconds')
        if not self.u_clamp_min < self.u_clamp_max:
            raise ValueError(f'limits {limits}: expected u_clamp_min below u_clamp_max')
        if antiwindup_strategy not in ANTIWINDUP_STRATEGIES:
            raise ValueError(f'antiwindup_strategy {antiwindup_strategy!r}: expected one of '
                             f'{", ".join(ANTIWINDUP_STRATEGIES)}')
        if not 0.0 <= dead_band < max(self.u_clamp_max, -self.u_clamp_min):
            raise ValueError(f'dead_band={dead_band}: expected 0 V to less than the limits')
        self.dead_band = float(dead_band)
        self._limits = self._within(self.u_clamp_min), self._within(self.u_clamp_max)
        self.antiwindup_strategy = antiwindup_strategy
        if tracking_time_constant is None and self.ki > 0:
            # With kp = 0 the ratio is 0, too stiff for one sample: draw back within a sample.
            tracking_time_constant = max(self.kp / self.ki, self.sample_time)
        if tracking_time_constant is not None and not tracking_time_constant >= self.sample_time:
            raise ValueError(f'tracking_time_constant={tracking_time_constant}: expected at least '
                             f'the sample time {self.sample_time} s')
        if setpoint_rate_limit is not None and not setpoint_rate_limit > 0:
            raise ValueError(f'setpoint_rate_limit={setpoint_rate_limit}: expected a positive '
                             'number or None')
        self.tracking_time_constant = tracking_time_constant
        self.setpoint_rate_limit = setpoint_rate_limit
        self.feed_forward = feed_forward
        self.reset()

    def reset(self, output: float | None = None) -> None:
        """
        Start afresh.

        Parameters
        ----------
        output : float, optional
            Bumpless start: the next update returns this command (V, clipped to the limits),
            whatever the error is then. None: the integral starts at zero, the command at the one
            next to 0 V.

        """
        self.integral = 0.0
        self.command = min(max(output or 0.0, self.u_clamp_min), self.u_clamp_max)
        self._bumpless = output is not None
        self._ramped: float | None = None
        self._error = self._late_rate = 0.0

    def update(self, setpoint: float, measured: float, elapsed: float | None = None) -> float:
        """
        Return the command for this sample, V.

        Parameters
        ----------
        setpoint, measured : float
            Speeds, rad/s. If either is not finite (a sensor that dropped out), the last
            command is held and the integral stays.
        elapsed : float, optional
            Time since the last update, s; default: the sample time.

        """
        if not (math.isfinite(setpoint) and math.isfinite(measured)):
            return self.command
        elapsed = self.sample_time if elapsed is None else elapsed
        # The last update has integrated over one sample time.
        self.integral += self._late_rate * (elapsed - self.sample_time)
        setpoint = self._limit_rate(setpoint, measured, elapsed)
        error = self._error = setpoint - measured
        direct = self.kp * error
        if self.feed_forward is not None:
            direct += self.feed_forward(setpoint)
        if self._bumpless:
            self.integral = self._within(self.command) - direct
            self._bumpless = False
        raw = direct + self.integral
        inner = min(max(raw, self._limits[0]), self._limits[1])
        self.command = inner + self.dead_band * min(max(inner / _KNEE, -1.0), 1.0)
        excess = raw - inner
        self.integral += self._integral_rate(error, excess) * self.sample_time
        # The time beyond it draws nothing back: longer than the time constant it would overshoot.
        winds_up = error * excess > 0.0 and self.antiwindup_strategy != 'none'
        self._late_rate = 0.0 if winds_up else self.ki * error
        return self.command

    def retune(self, kp: float, ki: float) -> None:
        """
        Take over new gains without a jump of the command.

        The integral takes up what the proportional part changes by at the last error.

        Raises
        ------
        ValueError
            For gains that make no sense; the old ones then stay.

        """
        if not all(map(math.isfinite, (kp, ki))) or kp < 0 or ki < 0:
            raise ValueError(f'gains kp={kp}, ki={ki}: expected numbers that are not negative')
        self.integral += (self.kp - kp) * self._error
        self.kp, self.ki = float(kp), float(ki)

    def _within(self, command: float) -> float:
        """Return what the law has to give for a command, which has the dead band in it."""
        if abs(command) <= _KNEE + self.dead_band:
            return command / (1.0 + self.dead_band / _KNEE)
        return command - math.copysign(self.dead_band, command)

    def _integral_rate(self, error: float, excess: float) -> float:
        """Return the change of the integral, V/s; ``excess`` (V) is what was clipped off."""
        if excess == 0.0 or self.antiwindup_strategy == 'none':
            return self.ki * error
        if self.antiwindup_strategy == 'back_calculation' and self.tracking_time_constant:
            return self.ki * error - excess / self.tracking_time_constant
        return self.ki * error if error * excess < 0.0 else 0.0

    def _limit_rate(self, setpoint: float, measured: float, elapsed: float) -> float:
        if self.setpoint_rate_limit is None:
            return setpoint
        before = measured if self._ramped is None else self._ramped
        step = self.setpoint_rate_limit * elapsed
        self._ramped = min(max(setpoint, before - step), before + step)
        return self._ramped
