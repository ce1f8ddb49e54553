# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""All that is told of a running drive from samples as they come; the node is its shell."""
from __future__ import annotations

import math
from typing import NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.losses.efficiency import Limits, Performance
from hst_drive.model.circuit_model import part_model
from hst_drive.model.compiled import compiles
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
from hst_drive.watch.calibration import Calibration
from hst_drive.watch.characteristic import Characteristic, Resistances
from hst_drive.watch.figures import (
    INLET, judged, limits_of, losses, lost, measured, modelled, moment_of, signals_for, switched,
    TEMPERATURE, uncertainty)
from hst_drive.watch.naming import Signatures
from hst_drive.watch.residuals import Balances, Block, following_oil, LEAD, NEITHER
from hst_drive.watch.samples import Accuracy, SPEED
from hst_drive.watch.stream import BILLION, Stream, Window
from hst_drive.watch.watch import Verdict, Watch

_NARROW = 0.04      # s: half the smoothing of pressure and speed
_COMPILED, _PLAIN = 100.0, 20.0     # Hz: rows at which a circuit is evaluated
_WORDS = {'pump_outlet_pressure': 'pressure', 'motor_inlet_flow': 'flow', SPEED: 'speed',
          'load_torque': 'load torque'}


class Settings(NamedTuple):
    """How an ``Observer`` works: s, Hz; limits and accuracy (None: as the rig's size has it)."""

    rate: float = 10.0
    window: float = 0.5
    timeout: float = 0.5
    block: float = 1.0
    limits: Limits | None = None
    accuracy: Accuracy | None = None


class Figures(NamedTuple):
    """Figures of merit that were true at ``stamp`` (ns), or the reason why there are none."""

    stamp: int
    reason: str = ''
    measured: Performance | None = None
    model: Performance | None = None
    uncertainty: Performance | None = None


class Watched(NamedTuple):
    """A block that ended at ``stamp`` (ns): the verdict and the resistances, or why none."""

    stamp: int
    reason: str = ''
    verdict: Verdict | None = None
    resistances: Resistances | None = None
    why_none: str = ''


class Estimates(NamedTuple):
    """What a step in time has brought."""

    figures: list[Figures]
    watched: list[Watched]


class Observer:
    """
    Watches a drive through its signals.

    Parameters
    ----------
    rig : Rig
        Of the drive; the section 'motor' at least.
    signals : tuple of str
        Channels that may come: the balances are those that can be closed by what has come.
    settings : Settings
        How to work.

    Attributes
    ----------
    origin : int or None
        Time of the first step, ns.
    watch : Watch
        The watch at work, with the unit's calibration.

    """

    def __init__(self, rig: Rig, signals: tuple[str, ...], settings: Settings = Settings()):
        rig.require('motor', purpose='the estimator')
        self.rig, self.settings = rig, settings
        self._limits = settings.limits or limits_of(rig)
        self.model = part_model(following_oil(rig)[0])
        self.signatures = Signatures(self.model)
        self.signals = (SPEED, *(name for name in signals if name != SPEED))
        self._optional = tuple(name for name in (
            TEMPERATURE, INLET, 'motor_displacement_command') if name in signals)
        # Without a flow meter the pump tells the flow: its lag has to settle.
        self._lead = round(LEAD * BILLION)
        self._before = 0 if rig.circuit == OPEN else self._lead
        self._half = round(0.5 * settings.window * BILLION)
        self._length = round(settings.block * BILLION)
        memory = LEAD + 2 * settings.block + settings.window + settings.timeout
        self._stream = Stream(self.signals, memory, settings.timeout)
        self._hear(signals)
        self._restart()

    def _hear(self, came: tuple[str, ...]) -> None:
        """Watch what these signals close."""
        self._came = came
        self._doubt: float | None = None
        self.balances = Balances(self.rig, came, self.settings.accuracy)
        self._judged = judged(self.balances.closed, self.rig.circuit)
        self._of_figures = signals_for(self._judged, self.rig.circuit, came)
        self._watch()

    def _watch(self) -> None:
        self.watch = Watch(Calibration(
            self.balances.spread, self.balances.correlation), self.signatures)

    def _restart(self) -> None:
        """Begin anew: nothing is known."""
        self._watch()
        self.characteristic = Characteristic(self.model, self.balances.accuracy)
        self.origin: int | None = None
        self._next = self._block = 0

    def put(self, name: str, stamp: int, value: float) -> None:
        """Take a sample: channel, ns, SI."""
        before = self._stream.restarts
        self._stream.put(name, stamp, value)
        if self._stream.restarts != before:
            self._restart()

    def reached(self) -> int | None:
        """Return up to when all signals are known, or will not come any more, ns."""
        newest = [self._stream.newest(name) for name in self.signals]
        known = [stamp for stamp in newest if stamp is not None]
        if not known:
            return None
        late = max(known) - round(self.settings.timeout * BILLION)
        return late if len(known) < len(newest) else max(min(known), late)

    def advance(self, stamp: int) -> Estimates:
        """Return what can be told now that all samples up to ``stamp`` (ns) are there."""
        if self.origin is None:
            self.origin = self._next = stamp
            self._block = stamp + self._lead
        figures, watched = [], []
        period = round(BILLION / self.settings.rate)
        if stamp >= self._next:
            self._next += (stamp - self._next) // period * period + period
            figures.append(self._figures(stamp - self._half, stamp))
        if stamp - self._block > 10 * self._length:
            # Nothing came for long: old blocks have no samples.
            self._block = stamp - self._length
        while stamp >= self._block + self._length:
            watched.append(self._watched(self._block, self._block + self._length))
            self._block += self._length
        return Estimates(figures, watched)

    def _figures(self, middle: int, now: int) -> Figures:
        begin, end = middle - self._half - self._before, middle + self._half + 1
        missing = self._stream.missing(self._of_figures, begin, now)
        if missing:
            return Figures(middle, 'no ' + ' and no '.join(
                _WORDS.get(name, CHANNELS[name].title) for name in missing))
        here = [name for name in self._optional if name not in self._of_figures
                and not self._stream.missing((name,), begin, now)]
        window = self._window((*self._of_figures, *here), begin, end)
        if switched(window.values):
            return Figures(middle, 'the hydromotor stands on its second displacement')
        lead = self._before / BILLION
        moment = moment_of(window, middle, self.model, self._judged, _NARROW, lead,
                           self._doubt or 0.0)
        if moment is None:
            return Figures(middle, 'not enough samples yet')
        speed = window.values[SPEED][window.time >= lead]
        if speed.min() < 0.0 < speed.max():
            return Figures(middle, 'reversal or standstill within the window')
        if math.isnan(moment.flow) and self._before:
            return Figures(middle, NEITHER)
        if self._before and self._doubt is None:
            return Figures(middle, 'not enough samples yet')
        displacement = self.model.motor_displacement
        found, reason = measured(moment, displacement, self._limits)
        if found is None:
            return Figures(middle, reason)
        if found.volumetric > 1.5 or found.hydromechanical > 1.5:
            return Figures(middle, 'signals contradict each other: efficiency above 1.5')
        return Figures(middle, '', found, modelled(moment, displacement),
                       uncertainty(moment, found, displacement, self.balances.accuracy))

    def _window(self, names: tuple[str, ...], start: int, end: int) -> Window:
        window = self._stream.window(names, start, end)
        # A circuit's equations go from row to row: not compiled they take 70 us each.
        return window if self.rig.circuit == OPEN else window.thinned(
            _COMPILED if compiles() else _PLAIN)

    def _watched(self, start: int, end: int) -> Watched:
        came = tuple(name for name in self.signals if self._stream.newest(name) is not None)
        if set(came) != set(self._came):
            self._hear(came)
        names = self.balances.needed
        if not self.balances.closed:
            return Watched(end, 'the signals close no balance')
        missing = self._stream.missing(names, start - self._lead, end)
        if missing:
            return Watched(end, f'no {" and no ".join(missing)}')
        here = [name for name in self._optional if name not in names
                and not self._stream.missing((name,), start - self._lead, end)]
        window = self._window((*names, *here), start - self._lead, end)
        block = self.balances.of(window, start, end)
        if isinstance(block, str):
            return Watched(end, block)
        return Watched(end, '', self.watch.add(block), *(
            (None, 'second displacement') if switched(window.values) else self._losses(block)))

    def _losses(self, block: Block) -> tuple[Resistances | None, str]:
        samples, delivered = block.samples, block.residuals.get('pump_flow')
        if delivered:
            # As well as the unit's sheet tells all before the hydromotor.
            self._doubt = math.hypot(*(
                slope * self.balances.spread[key] for key, slope in delivered.moved_by.items()
                if not key.startswith(('motor.', 'gear.', 'sensor.'))))
        speed = samples.mean(samples.speed)
        at = losses(self.model, samples.known, speed)
        flow, torque = lost(samples.residuals, at)
        if math.isnan(flow + torque):
            return None, 'no flow or no torque'
        pressure, speed = samples.mean(at.pressure), at.way * speed
        drain = samples.drained() - samples.mean(at.rest)
        self.characteristic.add(pressure, speed, flow, torque, drain)
        return self.characteristic.resistances(pressure, speed)
