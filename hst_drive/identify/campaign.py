# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Several recordings of one drive as one fitting problem.

A ``Campaign`` turns a ``Model`` into normalised errors: one column per signal and log, model minus
measurement over the floor that a perfect model would show.
"""
from __future__ import annotations

import copy
from dataclasses import replace
from functools import cached_property
from typing import Callable, Sequence

from hst_drive.effects import catalogue, Effect, effect_of, Parameter
from hst_drive.effects.leakage_temperature import OIL_LAW
from hst_drive.effects.slots import LEAKS, OF_OTHER_CIRCUITS
from hst_drive.identify.columns import Column, columns
from hst_drive.identify.conditions import faults_of, moved, prior
from hst_drive.identify.evidence import CREDIBLE, STRONG
from hst_drive.identify.model import Model
from hst_drive.identify.zeros import as_read, DELAY, delays_of, LEARNT_DELAY, zeros_of
from hst_drive.measure.circuit import replay_of
from hst_drive.measure.floor import of_rough_load
from hst_drive.measure.judged import judged, start_of
from hst_drive.measure.oscillation import means_where, shaking
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import BLOCK, Run
from hst_drive.model import Drive
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
from hst_drive.rig.schema import DOUBTED, ONE_SIDED, WAVES
import numpy as np

MAX_STEP = 10e-3        # s; halving it moves no fitted cost by more than a thousandth
_SLOW_EVENTS = 0.35     # share of the blocks that events may spoil where rows miss the control
SETTLE = 0.3            # s left out at the start of a log: the first state is not measured whole
_SLOW_STAMPS = 5e-3     # s: time stamps of a record slower than the controller
_SLOW_SCATTER, _SLOW_LOAD = 1.0, 0.4    # of the squared noise ratio; of the load's
ELSEWHERE = 'has no place in this circuit'


class Campaign:
    """
    Recordings to fit on and recordings to judge on.

    Effects that the rig has adopted are part of its baseline. Its unit's factors are as
    independent as the make's tolerances are, or tied by what commissioning told (``ties``).
    Without ``holdout`` a third of each log's time is held out.
    """

    block = BLOCK
    finest = 0.008  # s: faster records are averaged; the drive has nothing to show there
    events = 0.07   # share of the blocks that single events may spoil
    by_balance = False      # True: no simulation, each balance by itself, both sides smoothed
    signed = False  # True: a leak may be negative, where it is what has changed in a machine
    open_forms = False      # True: an adopted leak may grow in another form than it was adopted in

    def __init__(self, rig: Rig, runs: Sequence[Run], holdout: Sequence[Run] = ()):
        # In a closed circuit a share of the flow is its sheet's error instead.
        logs = (*runs, *holdout)
        self.expected, self.tolerances, self.ties, self.oil, self.torque_off = prior(
            rig, logs, self.by_balance and rig.circuit == OPEN)
        self.rig = replace(rig, effects=self.oil.brought(rig.effects), calibration={
            **rig.calibration, **{key: rig.calibration.get(key, 1.0) * factor
                                  for key, factor in self.expected.items()}})
        self.adopted, self.sizes = self.rig.effects, rig.sizes
        self.faults = faults_of(self.rig)
        self.drive = self._model()
        self.replays = [replay_of(run.slower(self.finest), self.drive) for run in logs]
        # What follows the measured rest is judged everywhere, and does not drift out of step.
        self.usable = [np.ones(len(replay.run), dtype=bool) if self.by_balance
                       else judged(replay.run).samples for replay in self.replays]
        self.judge = self.drive
        self.floors = self._floors(self.drive)
        self._own_floors: dict[str, list[dict[str, float]]] = {}    # by model
        self.rough_load = [{} if self.by_balance else of_rough_load(replay, self.drive)
                           for replay in self.replays]
        self.signals = tuple(dict.fromkeys(
            name for replay in self.replays for name in replay.signals))
        self._splits = [
            np.where(usable, self._split(replay, index < len(runs), bool(holdout)), 0)
            for index, (replay, usable) in enumerate(zip(self.replays, self._with_starts()))]
        self._shaking = [np.zeros(len(replay.run), dtype=bool) if self.by_balance
                         else shaking(replay.run) for replay in self.replays]
        self.columns = columns(self.replays, self.floors, self._splits)
        self.zeros = zeros_of(rig, self.replays, self.by_balance)
        self.delays = self._delays()

    def _model(self):
        return Drive(self.rig, max_step=MAX_STEP)

    def _floors(self, judge) -> list[dict[str, float]]:
        return [replay.floor(judge, usable) for replay, usable in zip(self.replays, self.usable)]

    def _with_starts(self) -> list[np.ndarray]:
        """
        Return the usable rows, and those of starts from rest where the machine's own are known.

        There the model errs as far as it did then.
        """
        if not self.starts_known:
            return self.usable
        known = self.rig.fingerprint.starts
        counted = []
        for replay, usable in zip(self.replays, self.usable):
            rows = start_of(replay.run)
            counted.append(usable | rows)
            replay.extra_std = {
                name: np.hypot(replay.extra_std.get(name, 0.0),
                               np.where(rows, known.get(name, np.inf), 0.0))
                for name in replay.signals}
        return counted

    @property
    def commissioned_unit(self) -> bool:
        """Whether the machine's own numbers were learnt on other logs (``Rig.fingerprint``)."""
        return self.rig.fingerprint is not None

    @property
    def starts_known(self) -> bool:
        """Whether the machine's own starts from rest are known (``Fingerprint.starts``)."""
        return bool(not self.by_balance and self.rig.fingerprint and self.rig.fingerprint.starts)

    @property
    def sigmas(self) -> dict[str, float]:
        """One sigma of all that tells this unit, and its sensors, from their datasheets."""
        return {**self.tolerances, **self.zeros, **self.delays}

    @property
    def odds_asked(self) -> float:
        """Log odds from which on a first effect is worth a name."""
        return STRONG if self.commissioned_unit else CREDIBLE

    def to_record(self, models: Sequence[Model]) -> str:
        """Say what to record next to tell models apart; '' where a test can be designed."""
        return ''

    def oil_error(self, name: str) -> float:
        """Return what oil other than it was may do to a signal beyond the factors, in floors."""
        return 0.0

    def candidates(self) -> list[str]:
        """Return the effects that these logs may be searched for."""
        return [name for name, effect in catalogue().items()
                if name in self.faults or (
                    effect.searched == 'always' or self.by_balance and effect.searched == 'parts')
                and name not in self.adopted
                and not (effect.form_of and self.fits(*effect.form_of))]

    def out_of_reach(self, name: str) -> str:
        """Say why the channels cannot show an effect; empty if they can."""
        if catalogue()[name].slot in OF_OTHER_CIRCUITS:
            return ELSEWHERE
        channels = catalogue()[name].shows_in
        if channels and not set(self.signals) & set(channels):
            return f'needs one of the channels {", ".join(channels)}'
        return ''

    def parameter(self, name: str, key: str) -> Parameter:
        """Return a parameter of an effect, with bounds that are plausible on this machine."""
        effect = effect_of(name)
        found = effect.parameter(key).sized(*self.sizes)
        if self.signed and key == effect.size.name and effect.slot in LEAKS:
            return replace(found, low=-found.high)
        return found

    def either_way(self, name: str) -> bool:
        """Say whether the size of an effect may be off the model's to both sides."""
        size = self.parameter(name, effect_of(name).size.name)
        return size.low < self.off(name)[size.name] < size.high

    def least(self, key: str) -> float:
        """Return the least that a factor (natural logarithm) may be: there it is of nothing."""
        return -float(np.log(max(self.rig.calibration.get(key, 1.0), 1.0))) \
            if key in ONE_SIDED else -np.inf

    def typical(self, name: str) -> dict[str, float]:
        """Return parameters of an effect to start from."""
        entries = [self.parameter(name, entry.name)
                   for entry in effect_of(name).parameters]
        if name not in self.adopted:
            return self.oil.within({entry.name: entry.typical for entry in entries})
        now, size = self.off(name), entries[0]
        more = now[size.name] + size.typical - size.neutral
        return {**now, size.name: more if size.low <= more <= size.high
                else now[size.name] - (size.typical - size.neutral) / 2}

    def off(self, name: str) -> dict[str, float]:
        """Return an effect's parameters as the model has them without it: adopted, or neutral."""
        return {**effect_of(name).neutral, **self.adopted.get(name, {})}

    def fits(self, name: str, key: str) -> bool:
        """
        Say whether a parameter of an effect is fitted rather than chosen.

        Of an adopted effect its size is: it grows or shrinks, its form is known.
        """
        effect = effect_of(name)
        parameter = effect.parameter(key)
        return (name not in self.adopted or parameter == effect.size) and self._tells(
            effect, parameter)

    def _tells(self, effect: Effect, parameter: Parameter) -> bool:
        """Say whether such logs can tell a parameter of an effect."""
        return not parameter.fixed and (parameter.whole_drive
                                        or parameter.recorded_in(self.signals))

    def scatter(self, name: str, held_out: bool | None = True) -> float:
        """
        Return how far the squared noise ratio of a perfect model may be off by chance.

        Two standard errors. Only the load's roughness counts: a minute of it holds few
        independent samples, both where it is judged and where its size was estimated.
        """
        total, variance = 0.0, 0.0
        for column in self.columns:
            replay = self.replays[column.log]
            if column.signal == name:
                span = len(column.rows(held_out)) * replay.run.sample_time
                total += span
                if name == replay.torque:
                    rough = replay.misread(self.judge)
                    # Mean square of an Ornstein-Uhlenbeck process over a span.
                    variance += span * 4 * (rough.std * column.scale)**4 * rough.time_constant
        chance = 2.0 * float(np.sqrt(variance)) / total if total else 0.0
        # What a slow record does not show of commands and load shakes the replay, too; of the load
        # it is unsure only when the PPRV got its command.
        return chance + (_SLOW_SCATTER if self.slow(name) else _SLOW_LOAD if self.slow() else 0.0)

    def slow(self, name: str = '') -> bool:
        """
        Say whether rows come so seldom that what the controller did is not known well.

        With the name of a signal: and whether it hangs on that. The load meets the measured speed.
        """
        return any(replay.stamp_std > _SLOW_STAMPS for replay in self.replays
                   if name != replay.torque)

    @staticmethod
    def _split(replay: Replay, training: bool, named: bool) -> np.ndarray:
        """Return +1 for samples to fit on, -1 for samples to judge on, 0 for neither."""
        time = replay.run.time - replay.run.time[0]
        if named:
            part = np.full(len(time), 1 if training else -1)
        else:
            block = (time / (3 * BLOCK)).astype(int)
            part = np.where(block % 3 == 1, -1, 1)
            if block[-1] < 2:
                part = np.where(time < 0.67 * time[-1], 1, -1)
        part[time < SETTLE] = 0
        return part

    def _changed(self, **attributes) -> Campaign:
        """Return a campaign that differs in some attributes; the others are shared."""
        other = copy.copy(self)
        vars(other).update(attributes, _own_floors={})
        if {'floors', '_splits'} & {*attributes}:
            other.columns = columns(other.replays, other.floors, other._splits)
        return other

    def of_logs(self, wanted: Callable[[int], bool] = lambda log: True,
                all_to_fit: bool = False) -> Campaign:
        """Return a campaign with the samples of some recordings alone, perhaps all to fit on."""
        return self._changed(_splits=[
            (np.abs(split) if all_to_fit else split) * wanted(log)
            for log, split in enumerate(self._splits)])

    def for_sizes(self, errors: Sequence[np.ndarray]) -> Campaign:
        """Return the campaign that sizes are taken from, for a model that leaves these errors."""
        return self.without_starts()

    def without_starts(self) -> Campaign:
        """
        Return the campaign without the rows of starts.

        They tell that an effect is there, but neither how much of it nor that something else is:
        when a drive breaks away hangs on all that came before.
        """
        return self._changed(_splits=[
            split * usable for split, usable in zip(self._splits, self.usable)
        ]) if self.starts_known else self

    def doubted(self) -> Campaign | None:
        """
        Return the campaign of readings that are late, and of a machine off its sheet's curves.

        None if the rig file says of all that. Of a machine that was commissioned curves are the
        unit's already; balances that are judged one by one have the pump's in what a sheet is off.
        """
        curves = {} if self.commissioned_unit else {
            key: sigma for key, sigma in DOUBTED.items() if key not in self.rig.scatter
            and not (self.by_balance and key in WAVES) and self.tells(key, sigma)}
        learnt = self.commissioned_unit and self.by_balance
        delays = self._delays(LEARNT_DELAY if learnt else DELAY)
        if not curves and delays.keys() <= self.delays.keys():
            return None
        return self._changed(tolerances={**curves, **self.tolerances}, delays=delays)

    def late(self) -> Campaign:
        """Return the campaign of readings that may be late, each by itself."""
        return self._changed(delays=self._delays(DELAY))

    def tells(self, key: str, sigma: float) -> bool:
        """Say whether such logs can tell by how much a unit is off."""
        return True

    def with_oil_law(self, power: float) -> Campaign:
        """Return the campaign of a machine whose leakages follow the viscosity by a power."""
        rig = replace(self.rig, effects={**self.rig.effects, OIL_LAW: {'exponent': power}})
        other = self._changed(rig=rig, adopted=rig.effects)
        other.drive = other.judge = other._model()
        return other

    def _delays(self, usual: float = 0.0) -> dict[str, float]:
        """Return how late each sensor may read, ``usual`` where the rig file does not say."""
        return delays_of(self.rig, self.replays, usual)

    def copied(self) -> Campaign:
        """Return a campaign whose recordings can be changed while others use these."""
        return self._changed(replays=[copy.copy(replay) for replay in self.replays])

    def of_load(self) -> Campaign:
        """Return a campaign of the torque alone, which asks for no simulation (``Replay``)."""
        replays = [replay.of_load() for replay in self.replays]
        kept = [column for column in self.columns if column.signal in replays[column.log].signals]
        return self._changed(replays=replays, columns=kept,
                             signals=tuple({column.signal for column in kept}))

    def driver(self, model: Model) -> Drive:
        """Return a drive with the model's effects and factors."""
        drive = self.drive.changed(self.switched(model), model.scales)
        drive.zeros, drive.delays = as_read(self.rig, model)
        return drive

    def switched(self, model: Model) -> dict[str, dict[str, float]]:
        """Return the effects of a model, and adopted leaks beside them that follow the oil."""
        return {**moved(self.adopted, model.scales), **model.effects}

    def floors_of(self, model: Model) -> list[dict[str, float]]:
        """Return the floors, log by log, of a drive that is as this model says."""
        key = repr(model)
        if key not in self._own_floors:
            self._own_floors[key] = self._floors(self.driver(model))
        return self._own_floors[key]

    def judging(self, model: Model) -> Campaign:
        """Return the campaign with the floors of a drive that is as this model says."""
        return self._changed(judge=self.driver(model), floors=self.floors_of(model))

    def errors(self, model: Model, *, to_fit: bool = False,
               known: Sequence[np.ndarray] | None = None) -> list[np.ndarray]:
        """
        Return the normalised errors of all samples, column by column (``columns``).

        With ``to_fit`` logs that are only judged on are not replayed; their errors are zero. Such
        errors may be ``known``: then the other logs alone are replayed.
        """
        drive = self.driver(model)
        fitted = [bool((part > 0).any()) for part in self._splits]
        given = [replay.predict(drive)
                 if (fit or not to_fit) and not (fit and known) else None
                 for replay, fit in zip(self.replays, fitted)]
        errors = []
        for index, column in enumerate(self.columns):
            measured = self.replays[column.log].run[column.signal]
            if given[column.log] is None:
                errors.append(known[index] if known else np.zeros(len(measured)))
                continue
            error = (given[column.log][column.signal] - measured) * column.scale
            # A model that left all bounds must lose, not stop the search.
            error[~np.isfinite(error)] = 1e3
            errors.append(means_where(error, np.isfinite(measured), self._shaking[column.log],
                                      self.replays[column.log].run.sample_time))
        return errors

    def training(self, errors: Sequence[np.ndarray]) -> np.ndarray:
        """Return the errors to fit on as one vector, weighted for their correlation."""
        return np.concatenate([(error * column.weight)[column.fit] * self.thinning(column)
                               for error, column in zip(errors, self.columns)])

    def without_blocks(self, blocks: Sequence[int]) -> Campaign:
        """Return the campaign without some blocks to fit on, by their numbers."""
        return self._changed(_splits=[
            np.where((split > 0) & np.isin(number, blocks), 0, split)
            for split, number in zip(self._splits, self._block)])

    def fitted_blocks(self) -> np.ndarray:
        """Return the number of its block for each sample of ``training``."""
        return np.concatenate([self._block[column.log][column.fit] for column in self.columns])

    @cached_property
    def _block(self) -> list[np.ndarray]:
        """The number of the block of time that each sample lies in, by log; all logs in turn."""
        numbers, total = [], 0
        for replay in self.replays:
            since = replay.run.time - replay.run.time[0]
            numbers.append((since / self.block).astype(int) + total)
            total = int(numbers[-1][-1]) + 1
        return numbers

    def thinning(self, column: Column) -> float:
        """Return the weight that makes samples closer than 0.1 s count as one."""
        return float(np.sqrt(min(10 * self.replays[column.log].run.sample_time, 1.0)))

    def ratios(self, errors: Sequence[np.ndarray], held_out: bool | None) -> dict[str, float]:
        """
        Return the noise ratio by signal, over all logs.

        The worst blocks (a share of ``events``) are left out: an error confined to a few
        seconds is an event, not physics that the model lacks.
        """
        ratios = {}
        for name, squares in self.blocks(errors, held_out).items():
            squares = np.sort(squares[np.isfinite(squares)])
            spoilt = _SLOW_EVENTS if self.slow(name) else self.events
            if count := len(squares) - int(np.ceil(spoilt * len(squares))):
                ratios[name] = float(np.sqrt(squares[:count].mean()))
        return ratios

    def blocks(self, errors: Sequence[np.ndarray], held_out: bool | None = True) -> dict[
            str, np.ndarray]:
        """
        Return the mean squared error of each block of ``block`` seconds, by signal.

        Blocks of all logs in turn; NaN where a log lacks the signal, so that all signals and all
        models have the same ones.
        """
        result, total = {}, int(self._block[-1][-1]) + 1
        for name in self.signals:
            sums, counts = np.zeros(total), np.zeros(total)
            for error, column in zip(errors, self.columns):
                if column.signal == name:
                    chosen = column.rows(held_out)
                    number = self._block[column.log][chosen]
                    sums += np.bincount(number, (error * column.weight)[chosen]**2, total)
                    counts += np.bincount(number, minlength=total)
            result[name] = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
        used = np.any([np.isfinite(values) for values in result.values()], axis=0)
        return {name: values[used] for name, values in result.items()}
