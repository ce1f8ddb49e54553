# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page asks for: curves and errors of a model, a fit, a diagnosis, a rig file."""
from __future__ import annotations

from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
import math
import os
from pathlib import Path
from threading import Lock
from typing import Callable, Iterable, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.diagnose.adopt import adopt
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.effects import SLOTS
from hst_drive.errors import InputError
from hst_drive.identify.fit import fit
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.identify.phases import in_step
from hst_drive.measure.compare import compare, LogComparison, model_of, pooled
from hst_drive.measure.run import Run
from hst_drive.report.effects import chosen
from hst_drive.rig import Rig
from hst_drive.units import difference_from_si, for_people
from hst_drive.workbench.state import Base, PageModel
import numpy as np

_REMEMBERED = 64            # comparisons of a log of a minute; fewer of longer ones
_SAMPLES = 500_000
_FIT_STEPS = 6


class Superseded(InputError):
    """Nobody waits for the answer any more."""


class Workbench:
    """
    Logs and a rig, and what models of the rig make of the logs.

    Parameters
    ----------
    base : Base
        The rig.
    runs, holdout : sequence of Run
        Without ``holdout`` a third of each log is held out.

    """

    def __init__(self, base: Base, runs: Sequence[Run], holdout: Sequence[Run]):
        self.base = base
        self.training, self.holdout = list(runs), list(holdout)
        self.runs = [*runs, *holdout]
        self._known: OrderedDict[tuple[str, int], LogComparison] = OrderedDict()
        self._lock = Lock()
        self._pool = ThreadPoolExecutor(max(os.cpu_count() or 1, 1))
        longest = max(len(run) for run in self.runs)
        self._room = max(2, min(_REMEMBERED, _SAMPLES // longest)) * len(self.runs)
        self._stamps = {run.source: _stamp(run.source) for run in self.runs if run.source}
        self.campaign = campaign_of(base.bare, runs, holdout)
        self.compared(base.start, range(len(self.runs)))

    def compared(self, model: PageModel, places: Iterable[int],
                 stale: Callable[[], bool] = lambda: False) -> list[LogComparison]:
        """
        Return logs (by place) beside a model: what compare gives for each.

        Raises
        ------
        Superseded
            Once ``stale`` says that nobody waits for it any more.

        """
        rig = self.base.rig(model)
        places = list(places)
        found = {place: log for place in places if (log := self._remembered(model.key, place))}
        missing = [place for place in places if place not in found]
        if missing:
            drive = model_of(rig, self.runs)

            def one(place: int) -> LogComparison:
                if stale():
                    raise Superseded('the page asks for something newer')
                return compare(drive, [self.runs[place]]).logs[0]

            for place, log in zip(missing, self._pool.map(one, missing)):
                found[place] = log
                self._remember(model.key, place, log)
        return [found[place] for place in places]

    def _remembered(self, key: str, place: int) -> LogComparison | None:
        with self._lock:
            if (key, place) in self._known:
                self._known.move_to_end((key, place))
            return self._known.get((key, place))

    def _remember(self, key: str, place: int, log: LogComparison) -> None:
        with self._lock:
            self._known[key, place] = log
            while len(self._known) > self._room:
                self._known.popitem(last=False)

    def quick(self, model: PageModel, place: int) -> tuple[LogComparison | None, dict]:
        """
        Return a log beside a model, and the errors over all logs, after one replay of each.

        With longer steps than compare takes and with the floor of the rig that was given, so that
        'ratio' is near that of compare, while 'training' and 'held' are those of ``errors``. The
        log is None where compare sees it in other samples.
        """
        self.base.rig(model)
        campaign = self.campaign
        errors = self._errors(model)
        found = {name: {'ratio': math.sqrt(total / count)} for name, (total, count)
                 in self._squares(errors).items() if count}
        self._judge(found, errors)
        known = self.compared(self.base.start, [place])[0]
        columns = {column.signal: (error, column) for error, column
                   in zip(errors, campaign.columns) if column.log == place}
        if any(len(error) != len(known.run) for error, _ in columns.values()):
            return None, found
        signals, given = {}, {}
        for name, (error, column) in columns.items():
            difference = error / column.scale
            given[name] = known.run[name] + difference
            signals[name] = known.signals[name]._replace(
                noise_ratio=float(np.sqrt(np.nanmean(np.where(
                    np.isfinite(known.measured(name))
                    & campaign.replays[place].counted(name), error, np.nan)**2))))
        return known._replace(model=given, signals=signals), found

    def _squares(self, errors: list[np.ndarray]) -> dict[str, tuple[float, int]]:
        """Return the sum of the squared noise ratios and the count of samples, by signal."""
        totals: dict[str, tuple[float, int]] = {}
        for error, column in zip(errors, self.campaign.columns):
            counted = self.campaign.replays[column.log].counted(column.signal)
            judged = self.compared(self.base.start, [column.log])[0].judged.samples
            if len(judged) == len(counted):
                counted = counted & judged
            valid = error[counted]
            total, count = totals.get(column.signal, (0.0, 0))
            totals[column.signal] = (total + float(valid @ valid), count + len(valid))
        return totals

    def _judge(self, found: dict[str, dict], errors: list[np.ndarray]) -> None:
        """Add the noise ratios that diagnose judges by."""
        for part, held in (('training', False), ('held', True)):
            for name, ratio in self.campaign.ratios(errors, held).items():
                if name in found:
                    found[name][part] = ratio

    def errors(self, model: PageModel, stale: Callable[[], bool] = lambda: False) -> dict:
        """
        Return the errors of a model over all logs.

        Returns
        -------
        dict
            By signal, in the units of the field: 'ratio', 'rmse', 'bias', 'floor' of compare, and
            'training' and 'held', the noise ratios that diagnose judges by.

        """
        found = {name: {'ratio': entry.noise_ratio, **{
            key: difference_from_si(getattr(entry, key), CHANNELS[name].display)
            for key in ('rmse', 'floor', 'bias')}} for name, entry in
            pooled(self.compared(model, range(len(self.runs)), stale)).items()}
        self._judge(found, self._errors(model))
        return found

    def _errors(self, model: PageModel) -> list[np.ndarray]:
        whole = _campaign_model(model)
        return in_step(self.campaign, whole).errors(whole)

    def fit(self, model: PageModel, locked: Iterable[tuple[str, str]], unit: bool,
            progress: Callable[[str], None]) -> PageModel:
        """
        Fit the parameters of the effects that are on.

        Parameters
        ----------
        model : PageModel
            Where to start.
        locked : iterable of (str, str)
            Effect and parameter that stay.
        unit : bool
            Calibrate the unit within its tolerances as well; otherwise its factors stay.
        progress : callable
            Called with a text; may raise to stop.

        """
        self.base.rig(model)
        whole = _campaign_model(model)
        # The page has no zeros and delays of sensors: they stay as the rig file has them.
        kept = {*locked, *(('', key) for key in (
            *(() if unit else self.campaign.tolerances), *self.campaign.zeros,
            *self.campaign.delays))}
        found = fit(in_step(self.campaign, whole), whole, iterations=_FIT_STEPS, kept=kept,
                    progress=progress).model
        return PageModel(found.effects, {
            key: found.scales[key] for key, value in found.factors.items() if value})

    def diagnose(self, model: PageModel, progress: Callable[[str], None]) -> dict:
        """Say what the model still lacks, and which models take it over."""
        mapping = self.base.mapping(model)
        rig = self.base.rig(model)
        found = as_json(diagnose(rig, self.training, self.holdout, progress=progress))
        offers = []
        formula = (found.get('unknown') or {}).get('formula')
        for title, with_formula, there in (('add what was found', False, found['effects']),
                                           ('add the formula as well', True, formula)):
            if there:
                adopted = adopt(mapping, found, 'diagnosis', found['rig'], formula=with_formula)
                offers.append({'title': title,
                               'model': self.base.model_of(adopted).as_json()})
        if not found['effects']:
            # Within the tolerances of the datasheet the unit itself may explain the rest.
            factors = {entry['quantity']: entry['factor'] for entry in found['calibration']}
            offers.insert(0, {'title': 'take over the calibration of the unit', 'model': PageModel(
                model.effects, {key: model.factors.get(key, 1.0) * factors.get(key, 1.0)
                                for key in {**model.factors, **factors}}).as_json()})
        return {'diagnosis': found, 'offers': offers}

    def rig_file(self, model: PageModel) -> dict:
        """Return the mapping of the rig file of a model, with its provenance."""
        made = self.base.mapping(model)
        self.base.rig(model)
        held = {name: entry.get('held') for name, entry in self.errors(model).items()}
        past = list((made.get('provenance') or {}).get('adopted', []))
        made['provenance'] = {'adopted': [*past, {
            'workbench': 'set by hand or fitted on the workbench',
            'logs': [run.source for run in self.runs], 'held_out_noise_ratio': held}]}
        return made

    def lost(self) -> list[str]:
        """Say which log files have gone or changed since they were read."""
        lines = []
        for source, before in self._stamps.items():
            now = _stamp(source)
            if before is not None and now != before:
                lines.append(f'{source}: has {"gone" if now is None else "changed"} since it was '
                             'read; what is shown is what was read at the start')
        return lines


def parameters(rig: Rig) -> list[dict]:
    """Return a rig's catalogue for the page: effects, their parameters in SI and for people."""
    order = list(dict.fromkeys(slot.enters for slot in SLOTS.values()))
    effects = sorted(chosen(rig=rig).values(), key=lambda effect: order.index(effect.enters))
    return [{
        'id': effect.id, 'title': effect.title, 'enters': effect.enters,
        'equation': effect.equation, 'telltale': effect.telltale, 'source': effect.source,
        'parameters': [{
            'name': entry.name, 'meaning': entry.meaning, 'fixed': entry.fixed,
            'low': entry.low, 'high': entry.high, 'typical': entry.typical,
            'neutral': entry.neutral, 'unit': for_people(1.0, entry.unit)[1],
            'per': for_people(1.0, entry.unit)[0]} for entry in effect.parameters],
    } for effect in effects]


def _campaign_model(model: PageModel) -> Model:
    return Model({name: dict(values) for name, values in model.effects.items()},
                 {key: math.log(value) for key, value in model.factors.items()})


def _stamp(source: str) -> tuple[int, int] | None:
    try:
        state = Path(source).stat()
    except OSError:
        return None
    return state.st_mtime_ns, state.st_size
