# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page asks, by path, and what it gets: plain functions of JSON, without the network."""
from __future__ import annotations

from pathlib import Path
import re
import shlex
from typing import Callable, NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.effects.formula import FORMULAS
from hst_drive.errors import InputError
from hst_drive.plain import plain
from hst_drive.report.curves import measured_curves, model_curves, titles
from hst_drive.report.fails import error_maps
from hst_drive.report.found_sections import found_section, rivals_section, verdict
from hst_drive.workbench.bench import parameters, Workbench
from hst_drive.workbench.jobs import Job
from hst_drive.workbench.state import PageModel, read_model

POINTS = 8_000
_FILE = re.compile(r'[A-Za-z0-9][A-Za-z0-9_. -]{0,80}\.ya?ml')


class Setting(NamedTuple):
    """
    What the workbench was started with.

    ``logs``, ``holdout``, ``rig`` and ``channels`` are the files of the command line; ``folder``
    is where rig files are saved, by ``write``; ``guided`` tells that this is the first visit.
    ``start`` is the model to begin with; None: that of the rig file.
    """

    logs: tuple[str, ...]
    holdout: tuple[str, ...]
    rig: str | None
    channels: str | None
    folder: Path
    write: Callable[[dict, Path], None]
    guided: bool = False
    start: PageModel | None = None


class Answers:
    """
    Answers to a page.

    Parameters
    ----------
    bench : Workbench
        Logs and models.
    setting : Setting
        What it was started with.

    """

    def __init__(self, bench: Workbench, setting: Setting):
        self.bench = bench
        self.setting = setting
        self.job: Job | None = None
        self._serials: dict[str, int] = {}
        self.asked: dict[str, Callable[[dict], object]] = {
            'start': self._start, 'quick': self._quick, 'log': self._log,
            'errors': self._errors, 'where': self._where, 'fit': self._fit,
            'diagnose': self._diagnose, 'job': self._job, 'stop': self._stop, 'save': self._save,
            'command': self._command}

    def answer(self, name: str, content: dict) -> object:
        """
        Answer a question.

        Raises
        ------
        InputError
            With one line for the page.
        KeyError
            If there is no such question.

        """
        return plain(self.asked[name](content))

    def _start(self, content: dict) -> dict:
        names = list(dict.fromkeys(name for run in self.bench.runs for name in CHANNELS
                                   if name in run))
        return {
            'titles': titles(), 'effects': parameters(self.bench.base.bare), 'channels': names,
            'model': (self.setting.start or self.bench.base.start).as_json(),
            'logs': [{'name': run.name, 'held': place >= len(self.bench.training),
                      'notes': list(run.notes)} for place, run in enumerate(self.bench.runs)],
            'rig': self.bench.base.bare.name, 'guided': self.setting.guided,
            'named': bool(self.bench.holdout), 'folder': str(self.setting.folder)}

    def _stale(self, content: dict) -> Callable[[], bool]:
        """Return whether a page has asked for something newer, once it has."""
        page, serial = content.get('page'), content.get('serial')
        if not isinstance(page, str) or not isinstance(serial, int) or len(page) > 40:
            return lambda: False
        self._serials[page] = max(serial, self._serials.get(page, 0))
        return lambda: serial < self._serials[page]

    def _place(self, content: dict) -> int:
        place = content.get('log', 0)
        if isinstance(place, bool) or not isinstance(place, int) or not (
                0 <= place < len(self.bench.runs)):
            raise InputError(f'log {place!r}: expected 0 to {len(self.bench.runs) - 1}')
        return place

    def _quick(self, content: dict) -> dict:
        self._stale(content)
        log, signals = self.bench.quick(read_model(content.get('model')), self._place(content))
        return {'curves': log and model_curves(log, POINTS), 'signals': signals}

    def _log(self, content: dict) -> dict:
        place = self._place(content)
        log, = self.bench.compared(read_model(content.get('model')), [place],
                                   self._stale(content))
        found = {'curves': model_curves(log, POINTS)}
        return {**found, 'log': measured_curves(log, POINTS)} if content.get('measured') else found

    def _errors(self, content: dict) -> dict:
        return {'signals': self.bench.errors(read_model(content.get('model')),
                                             self._stale(content)),
                'lost': self.bench.lost()}

    def _where(self, content: dict) -> dict:
        logs = self.bench.compared(read_model(content.get('model')), range(len(self.bench.runs)),
                                   self._stale(content))
        names = list(dict.fromkeys(name for log in logs for name in log.signals))
        return {'fails': error_maps(logs, names), 'signals': names}

    def _begin(self, what: str, work) -> dict:
        if self.job is not None and self.job.running:
            raise InputError(f'{self.job.what}: is still at work; wait, or stop it')
        self.job = Job(what, work)
        return self.job.status()

    def _fit(self, content: dict) -> dict:
        model = read_model(content.get('model'))
        locked = content.get('locked', [])
        if not (isinstance(locked, list) and all(
                isinstance(entry, list) and len(entry) == 2 for entry in locked)):
            raise InputError(f'fit: locked is {locked!r}, expected pairs of effect and parameter')
        locked = [(str(effect), str(parameter)) for effect, parameter in locked]
        if not model.effects and not content.get('unit'):
            raise InputError('fit: no effect is on; switch one on, or let the unit be calibrated')
        return self._begin('fit', lambda progress: self.bench.fit(
            model, locked, bool(content.get('unit')), progress).as_json())

    def _diagnose(self, content: dict) -> dict:
        model = read_model(content.get('model'))
        self.bench.base.rig(model)

        def work(progress) -> dict:
            found = self.bench.diagnose(model, progress)
            told = found['diagnosis']
            return {'sentence': told['sentence'], 'badge': verdict(told),
                    'cards': found_section(told) + rivals_section(told),
                    'offers': found['offers'], 'verdict': told['verdict']}

        return self._begin('diagnose', work)

    def _job(self, content: dict) -> dict:
        return self.job.status() if self.job else {'state': 'none'}

    def _stop(self, content: dict) -> dict:
        if self.job:
            self.job.stop()
            self.job.wait(1.0)
        return self._job({})

    def _save(self, content: dict) -> dict:
        model, name = read_model(content.get('model')), content.get('name')
        if not isinstance(name, str) or not _FILE.fullmatch(name):
            raise InputError(f'{name!r}: is no name for a rig file; expected letters, digits, _ '
                             'and -, without a folder, ending in .yaml')
        target = self.setting.folder / name
        if target.exists():
            raise InputError(f'{target}: exists already; choose another name')
        self.setting.write(self.bench.rig_file(model), target)
        given = self.setting
        line = shlex.join(['hst-drive', 'compare', *given.logs, *given.holdout,
                           *_option('--channels', given.channels), '--rig', str(target)])
        return {'path': str(target), 'command': line if given.logs else ''}

    def _command(self, content: dict) -> dict:
        model = read_model(content.get('model'))
        self.bench.base.rig(model)
        gone = [name for name in self.bench.base.start.effects if name not in model.effects]
        nameless = [name for name in model.effects if name in FORMULAS]
        if gone or nameless:
            raise InputError(f'{(gone + nameless)[0]}: this model cannot be said on a command '
                             'line; save it as a rig file')
        given = self.setting
        if not given.logs:
            raise InputError('the sample log is not a file, so no command line can name it; start '
                             "the workbench with a log of yours: 'hst-drive workbench LOG...'")
        words = [f'{name}.{key}={value!r}' for name, values in model.effects.items()
                 for key, value in values.items()]
        factors = [f'{key}={value!r}' for key, value in model.factors.items()]
        return {'command': shlex.join([
            'hst-drive', 'report', *given.logs,
            *_option('--rig', given.rig), *_option('--channels', given.channels),
            *(part for log in given.holdout for part in ('--holdout', log)),
            *(part for word in words for part in ('--effect', word)),
            *(part for word in factors for part in ('--factor', word)),
            '--no-diagnosis', '-o', 'report.html'])}


def _option(name: str, value: str | None) -> tuple[str, ...]:
    return (name, value) if value else ()
