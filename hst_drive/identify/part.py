# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of a part of the drive as a fitting problem: every balance that they close is a signal."""
from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Sequence

from hst_drive.channels import CHANNELS, TORQUES
from hst_drive.effects import catalogue, Effect, effect_of, Parameter
from hst_drive.effects.slots import DRILLING_SPEED, LEAKS
from hst_drive.identify.campaign import Campaign, ELSEWHERE, SETTLE
from hst_drive.identify.model import Model
from hst_drive.identify.observable import unread
from hst_drive.measure.balances import is_part, lacking
from hst_drive.measure.circuit_balances import balances_of
from hst_drive.measure.part import PartReplay
from hst_drive.measure.readings import filled
from hst_drive.measure.run import BLOCK, Run, usual_size
from hst_drive.model.circuit_model import part_model
from hst_drive.model.part import PartModel
from hst_drive.rig import Rig
from hst_drive.rig.rig import OPEN
import numpy as np

_BLOCKS = 60            # a record is cut into so many at least
_LONGEST = 0.5          # s; nothing is simulated, so errors have no long memory
_ROWS = 3.0             # operating points in a block of a table
_CIRCUIT_FINEST = 0.01  # s: every row is evaluated, and faster ones tell no more
_FLOW = 3.3e-4          # m^3/s: usual at the drill drive
_TORQUE = 150.0         # N.m: usual at the drill drive, for which the catalogue has its bounds


def campaign_of(rig: Rig, runs: Sequence[Run], holdout: Sequence[Run] = ()) -> Campaign:
    """Return the campaign that fits the logs: one of a part if any log is of a part."""
    part = any(is_part(run, rig) for run in (*runs, *holdout))
    return (PartCampaign if part else Campaign)(rig, runs, holdout)


class PartCampaign(Campaign):
    """
    Recordings of a part, to fit on and to judge on.

    Without ``holdout`` a third of each log is held out.
    """

    by_balance = True
    open_forms = True

    def __init__(self, rig: Rig, runs: Sequence[Run], holdout: Sequence[Run] = ()):
        if rig.circuit != OPEN:
            self.finest = _CIRCUIT_FINEST
        super().__init__(rig, runs, holdout)
        self._named = bool(holdout)
        self._typical: dict[str, dict[str, float]] = {}
        self.tolerances = {key: sigma for key, sigma in self.tolerances.items()
                           if self.tells(key, sigma)}
        self.zeros = {name: value for name, value in self.zeros.items()
                      if self._moves(Model({}, {}, {name: value}))}
        tables = all(replay.static for replay in self.replays)
        total = sum(float(np.ptp(replay.run.time)) for replay in self.replays)
        self.block = _ROWS if tables else min(_LONGEST, total / _BLOCKS)
        torque, speed = (
            max((replay.usual(*names) for replay in self.replays), default=0.0) / reference or 1.0
            for names, reference in (((*TORQUES, 'pump_torque'), _TORQUE),
                                     (('motor_speed',), DRILLING_SPEED)))
        # Of a part nobody knows which flow is usual: a bench may have any.
        self.sizes = torque, speed, 1.0 if rig.circuit == OPEN else (
            speed * DRILLING_SPEED * self.drive.motor_displacement / _FLOW)
        if tables:
            # Operating points are chosen one by one: there are no events among them.
            self.events = 0.0

    def slow(self, name: str = '') -> bool:
        """Say that nothing is replayed, so that nothing drifts out of step."""
        return False

    def _model(self) -> PartModel:
        return part_model(self.rig)

    @staticmethod
    def _split(replay: PartReplay, training: bool, named: bool) -> np.ndarray:
        time = replay.run.time - replay.run.time[0]
        if named:
            return np.full(len(time), 1 if training else -1)
        if replay.static:
            return np.where(np.arange(len(time)) % 3 == 1, -1, 1)
        length = min(3 * BLOCK, time[-1] / 12)
        part = np.where((time / length).astype(int) % 3 == 1, -1, 1)
        part[time < min(SETTLE, 0.02 * time[-1])] = 0
        return part

    def for_sizes(self, errors: Sequence[np.ndarray]) -> Campaign:
        """
        Return a campaign of all rows, those judged on too, whose floors are what a model leaves.

        A machine parts from every formula by more than its sensors scatter: by their noise alone
        the rows with the slowest signals would tell all. Logs named to judge on stay out.
        """
        left = self.ratios(errors, held_out=True)
        return self.of_logs(all_to_fit=not self._named)._changed(open_forms=False, floors=[
            {name: floor * max(left.get(name, 1.0), 1.0) for name, floor in floors.items()}
            for floors in self.floors])

    def to_record(self, models: Sequence[Model]) -> str:
        """Say what to record next, to tell a model from others that explain these logs as well."""
        replay = max(self.replays, key=lambda entry: len(entry.run))
        there = replay.run.channels.keys()
        closing = {balance.groups[0][0]: balance for balance in balances_of(self.rig)
                   if not {*balance.groups[0]} & there
                   and not lacking(balance, {*there, balance.groups[0][0]}, self.rig)}
        first, *rest = (replay.would_read(self.driver(model), closing) for model in models)
        apart: dict[str, float] = {}
        for signal, balance in closing.items():
            noise = CHANNELS[signal].noise * np.max(np.abs(first[signal]))
            std = np.hypot(balance.sheet * usual_size(first[signal]), noise) + 1e-30
            apart[signal] = min(float(np.sqrt(np.mean((other[signal] - first[signal])**2)))
                                for other in rest) / std
        telling = sorted((name for name, far in apart.items() if far > 1.0),
                         key=lambda name: -apart[name])
        if telling:
            named = ' or '.join(f'{CHANNELS[name].title} ({name})' for name in telling)
            return f'record {named} as well: that tells ' + (
                'them apart' if len(rest) == 1 else 'what was found from each of the others')
        span = ', '.join(CHANNELS[name].title for name in there if name not in self.signals)
        return (f'record more operating points: a wider span of {span} than these logs have may '
                'tell them apart')

    def oil_error(self, name: str) -> float:
        """Return what oil other than it was may do to a signal beyond the factors, in floors."""
        return max((self.torque_off * column.scale * float(np.sqrt(np.mean(
            filled(self.replays[column.log].run[name])**2)))
            for column in self.columns if self.torque_off and column.signal == name
            and self.replays[column.log].balances[name].enters == 'torque'), default=0.0)

    def out_of_reach(self, name: str) -> str:
        """Say why the channels cannot show an effect; empty if they can."""
        if not self.drive.enters(name):
            return ELSEWHERE
        if self._moves(Model({name: self.typical(name)}, {})):
            return ''
        enters = catalogue()[name].enters
        return unread(self, name) or f'enters no balance that these channels close ({enters})'

    def parameter(self, name: str, key: str) -> Parameter:
        """
        Return a parameter of an effect, with bounds that are plausible here.

        What brakes a shaft that turns one way is dry friction; what drives it is not.
        """
        found, effect = super().parameter(name, key), effect_of(name)
        if not (effect.both_ways and key == effect.size.name) or any(
                replay.reverses for replay in self.replays):
            return found
        ahead = all(replay.ahead for replay in self.replays)
        far = abs(found.typical)
        return replace(found, high=0.0, typical=-far) if ahead else replace(
            found, low=0.0, typical=far)

    def typical(self, name: str) -> dict[str, float]:
        """Return parameters to start from; one that moves nothing here stays neutral."""
        if name not in self._typical:
            self._typical[name] = self._moving(name)
        return dict(self._typical[name])

    def _moving(self, name: str) -> dict[str, float]:
        values = super().typical(name)
        if name in self.adopted:
            return values
        off = catalogue()[name].neutral
        for key in list(values)[1:]:
            without = {**values, key: off[key] if off[key] != values[key]
                       else 0.5 * values[key] + 1e-3}
            if not self._differ(self.errors(Model({name: values})),
                                self.errors(Model({name: without}))):
                values[key] = off[key]
        return self.oil.within(values)

    def fits(self, name: str, key: str) -> bool:
        """Say whether a parameter is fitted; here also the form, not told, of what may grow."""
        effect = effect_of(name)
        parameter = effect.parameter(key)
        grows = name in self.adopted and effect.slot in LEAKS and bool(parameter.usual)
        return grows and self.open_forms and not self._tells(effect, parameter) or super().fits(
            name, key)

    def _tells(self, effect: Effect, parameter: Parameter) -> bool:
        """Say whether such logs can tell a parameter: here also what a drive hardly shows."""
        if effect.id not in catalogue():
            return super()._tells(effect, parameter)
        if parameter.whole_drive:
            # As well as there where the effect is measured by itself, or a whole circuit moves.
            return self.rig.circuit != OPEN and not parameter.fixed or any(
                entry.needs in self.signals for entry in effect.parameters)
        return parameter.recorded_in(self.signals)

    def scatter(self, name: str, held_out: bool | None = True) -> float:
        """Return two standard errors of the squared noise ratio."""
        count = 0.0
        for column in self.columns:
            if column.signal == name:
                count += len(column.rows(held_out)) * self.thinning(column)**2
        return 2.0 * float(np.sqrt(2.0 / max(count, 1.0)))

    def _delays(self, usual: float = 0.0) -> dict[str, float]:
        return {name: value for name, value in super()._delays(usual).items()
                if self._moves(Model({}, {}, {}, {name: value}))}

    def tells(self, key: str, sigma: float) -> bool:
        """Say whether a balance tells by how much a unit is off."""
        return self._moves(Model({}, {key: sigma}))

    @cached_property
    def _still(self) -> list[np.ndarray]:
        return self.errors(Model())

    def _changed(self, **attributes) -> Campaign:
        other = super()._changed(**attributes)
        vars(other).pop('_still', None)     # of this campaign
        return other

    def _moves(self, model: Model) -> bool:
        return self._differ(self.errors(model), self._still)

    @staticmethod
    def _differ(first, second) -> bool:
        return any(bool(np.any(np.abs(one - other) > 1e-9)) for one, other in zip(first, second))
