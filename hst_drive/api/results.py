# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the functions of the library return: it prints, shows in a notebook, and converts."""
from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any, TYPE_CHECKING

from hst_drive.api import given
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.plain import plain
from hst_drive.units import difference_from_si, for_people, from_si
import numpy as np

if TYPE_CHECKING:
    from hst_drive.design.design import Design as _Design
    from hst_drive.diagnose.result import Diagnosis as _Diagnosis
    from hst_drive.diagnose.result import Value
    from hst_drive.effects import Effect
    from hst_drive.identify.evidence import Probability
    from hst_drive.measure.compare import Comparison as _Comparison
    from hst_drive.measure.run import Run
    import pandas

_HEIGHT = 640       # pixels of a page in a notebook; it scrolls


class Result(ABC):
    """What all results can do."""

    def __repr__(self) -> str:
        return f'<{type(self).__name__}: {str(self).splitlines()[0]}>'

    @abstractmethod
    def __str__(self) -> str:
        ...

    def _repr_html_(self) -> str:
        return f'<pre>{escape(str(self))}</pre>'

    def to_frame(self) -> pandas.DataFrame:
        """
        Return the result's table as a pandas frame.

        Raises
        ------
        ImportError
            If pandas is not installed.

        """
        try:
            import pandas
        except ImportError:
            raise ImportError("to_frame needs pandas; install it: pip install 'hst_drive[pandas]'"
                              ) from None
        frame: pandas.DataFrame = pandas.DataFrame(self._table())
        return frame

    def to_json(self) -> dict[str, Any]:
        """Return the document that the command line writes with ``--json``, SI."""
        found: Any = plain(self._document())
        return dict(found)

    @abstractmethod
    def _table(self) -> Any:
        ...

    @abstractmethod
    def _document(self) -> Mapping[str, Any]:
        ...


class Log(Result):
    """
    A recording.

    Attributes
    ----------
    run : Run
        Time (s) and channels in SI.

    """

    def __init__(self, run: Run):
        self.run = run

    @property
    def name(self) -> str:
        """Short name for tables."""
        return self.run.name

    @property
    def channels(self) -> tuple[str, ...]:
        """What it holds besides the time."""
        return tuple(self.run.channels)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was repaired, left out or guessed."""
        return self.run.notes

    def between(self, start: float, end: float) -> Log:
        """Return the part with ``start <= time < end`` (s)."""
        part = self.run.between(given.number(start, 'start'), given.number(end, 'end'))
        if not len(part):
            raise InputError(f'{self.name}: no samples from {start:g} to {end:g} s; it goes from '
                             f'{self.run.time[0]:g} to {self.run.time[-1]:g} s')
        return Log(part)

    def save(self, path: str) -> None:
        """Write it as CSV, in the units of the field."""
        from hst_drive.bag import write_csv
        from hst_drive.report.files import check_target

        check_target(given.path(path, 'path'))
        write_csv(path, self.run)

    def __str__(self) -> str:
        from hst_drive.report.log import text

        return text(self.run)

    def _table(self) -> dict[str, np.ndarray]:
        """Return the columns that ``read_log`` reads."""
        return {'time[s]': self.run.time, **{
            f'{name}[{CHANNELS[name].display}]': from_si(values, CHANNELS[name].display)
            for name, values in self.run.channels.items()}}

    def _document(self) -> dict[str, Any]:
        return {'schema': 'hst_drive/log/1', 'name': self.name, 'source': self.run.source,
                'notes': self.notes, 'time': self.run.time, 'channels': {
                    name: {'unit': CHANNELS[name].unit, 'values': values}
                    for name, values in self.run.channels.items()}}


class RigFile(Result):
    """
    A rig: the mapping of its file, and what that says.

    Attributes
    ----------
    content : dict
        Keys carry their unit, as in the file.
    source : str
        Where it came from.
    rig : Rig
        The numbers in SI.

    """

    def __init__(self, content: dict[str, Any], source: str):
        from hst_drive.rig import parse_rig

        self.content, self.source = content, source
        self.rig = parse_rig(content, source)

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        """Adopted effects: id to parameters, SI."""
        return self.rig.effects

    def with_effects(self, effects: Mapping[str, Mapping[str, float | str]]) -> RigFile:
        """Return the rig with more effects: numbers in SI, or texts with a unit."""
        return RigFile({**self.content, 'effects': {
            **self.content.get('effects', {}),
            **given.sizes(effects, 'effects')}}, self.source)

    def save(self, path: str) -> None:
        """Write the rig file, for ``--rig`` and ``load_rig``."""
        from hst_drive.report.files import write_yaml

        write_yaml(self.content, given.path(path, 'path'))

    def __str__(self) -> str:
        lines = [f'{self.rig.name} ({self.source})']
        for row in self._table():
            lines.append(f'{row["effect"]}.{row["parameter"]} = {row["value"]:.4g} {row["unit"]}')
        return '\n'.join(lines)

    def _table(self) -> list[dict[str, Any]]:
        from hst_drive.effects import catalogue

        known = catalogue(everything=True)
        rows = []
        for name, values in self.effects.items():
            units = {entry.name: entry.unit for entry in known[name].parameters}
            for key, value in values.items():
                shown, unit = for_people(value, units[key])
                rows.append({'effect': name, 'parameter': key, 'value': shown, 'unit': unit})
        return rows

    def _document(self) -> dict[str, Any]:
        return self.content


class Comparison(Result):
    """
    Logs beside the model.

    Attributes
    ----------
    result : hst_drive.measure.compare.Comparison
        All numbers, SI.
    rig : RigFile
        What the model stands for.

    """

    def __init__(self, result: _Comparison, rig: RigFile, runs: list[Run]):
        self.result, self.rig, self._runs = result, rig, runs

    @property
    def noise_ratio(self) -> dict[str, float]:
        """Error of each signal over what a perfect model would still show; 1 is perfect."""
        return {name: entry.noise_ratio for name, entry in self.result.signals.items()}

    @property
    def remarks(self) -> list[str]:
        """What in the logs was repaired or looks wrong."""
        from hst_drive.report.comparison import remarks

        return remarks(self.rig.rig, self._runs)

    def curves(self, log: int = 0) -> dict[str, np.ndarray]:
        """Return time, and measured and model of each signal, in the units of the field."""
        if not 0 <= given.whole(log, 'log') < len(self.result.logs):
            raise InputError(f'log: found {log}, expected 0 to {len(self.result.logs) - 1}')
        found = self.result.logs[log]
        out = {'time[s]': found.run.time}
        for name, values in found.model.items():
            unit = CHANNELS[name].display
            out[f'{name}[{unit}]'] = from_si(found.run[name], unit)
            out[f'{name} model[{unit}]'] = from_si(values, unit)
        return out

    def __str__(self) -> str:
        from hst_drive.report.comparison import text

        return text(self.result)

    def _repr_html_(self) -> str:
        from hst_drive.report.comparison import sentence
        from hst_drive.report.notebook import whole_page

        return whole_page(self.rig.content, self.rig.rig, self._runs, self.result,
                          sentence(self.result), height=_HEIGHT)

    def _table(self) -> list[dict[str, Any]]:
        rows = []
        for name, entry in self.result.signals.items():
            unit = CHANNELS[name].display
            rows.append({'signal': name, 'unit': unit, **{
                key: difference_from_si(getattr(entry, key), unit)
                for key in ('rmse', 'bias', 'max_abs', 'noise_std', 'floor')},
                'noise_ratio': entry.noise_ratio, 'samples': entry.samples})
        return rows

    def _document(self) -> dict[str, Any]:
        from hst_drive.report.comparison import as_json

        return as_json(self.result, self.rig.source)


class Diagnosis(Result):
    """
    Which physical effect the model lacks.

    Attributes
    ----------
    result : hst_drive.diagnose.result.Diagnosis
        The answer and all that it rests on, SI.
    rig : RigFile
        The rig that was diagnosed.

    """

    def __init__(self, result: _Diagnosis, rig: RigFile, runs: list[Run], held_out: int):
        self.result, self.rig = result, rig
        self._runs, self._held_out = runs, held_out

    @property
    def verdict(self) -> str:
        """'none', 'missing_effect', 'ambiguous' or 'unknown'."""
        return self.result.verdict

    @property
    def sentence(self) -> str:
        """The answer for people."""
        return self.result.sentence

    @property
    def effects(self) -> dict[str, dict[str, Value]]:
        """What the model lacks: id to parameters with value, low, high (95 %) and unit, SI."""
        return {entry.id: entry.parameters for entry in self.result.effects}

    @property
    def probability(self) -> Probability:
        """Of each set of effects, of none and of something unlisted; all add up to 1."""
        return self.result.probability

    def __str__(self) -> str:
        from hst_drive.report.diagnosis import text

        return text(self.result)

    def _repr_html_(self) -> str:
        from hst_drive.measure.compare import compare, model_of
        from hst_drive.report.notebook import whole_page

        given = compare(model_of(self.rig.rig, self._runs), self._runs)
        return whole_page(self.rig.content, self.rig.rig, self._runs, given, self.sentence,
                          self.to_json(), self._held_out, height=_HEIGHT)

    def _table(self) -> list[dict[str, Any]]:
        rows = []
        for entry in self.result.effects:
            for key, value in entry.parameters.items():
                numbers = {name: for_people(number, value.unit)[0] for name, number in zip(
                    ('value', 'low', 'high'), value[:3])}
                rows.append({'effect': entry.id, 'parameter': key, **numbers,
                             'unit': for_people(0.0, value.unit)[1],
                             'error_removed': entry.error_removed})
        return rows

    def _document(self) -> dict[str, Any]:
        from hst_drive.diagnose.result import as_json

        return as_json(self.result)


class Design(Result):
    """
    The test that separates effects.

    Attributes
    ----------
    result : hst_drive.design.design.Design
        The advice and what to expect of it.

    """

    def __init__(self, result: _Design):
        self.result = result

    @property
    def scenario(self) -> dict[str, Any]:
        """The test as the mapping of a scenario file, for ``simulate`` and 'hst-drive run'."""
        return self.result.content

    def save(self, path: str) -> None:
        """Write the scenario file."""
        from hst_drive.report.files import write_yaml

        write_yaml(self.scenario, given.path(path, 'path'))

    def __str__(self) -> str:
        from hst_drive.report.design import text

        return text(self.result, None)

    def _table(self) -> list[dict[str, Any]]:
        return [{'if': ' + '.join(self.result.rivals[pair.truth]),
                 'not': ' + '.join(self.result.rivals[pair.rival]),
                 'significance': pair.significance} for pair in self.result.pairs]

    def _document(self) -> dict[str, Any]:
        from hst_drive.report.design import as_json

        return as_json(self.result, None)


class Effects(Result):
    """
    Physical effects that the model can add.

    Attributes
    ----------
    declared : dict of str to Effect
        By id.

    """

    def __init__(self, declared: dict[str, Effect], identity: str | None = None):
        self.declared, self._identity = declared, identity

    @property
    def ids(self) -> tuple[str, ...]:
        """Their names in rig files and diagnoses."""
        return tuple(self.declared)

    def __str__(self) -> str:
        from hst_drive.report.effects import text

        return text(self.declared, self._identity)

    def _repr_html_(self) -> str:
        from hst_drive.report.effects import html

        return html(self.declared, self._identity)

    def _table(self) -> list[dict[str, Any]]:
        return [{key: entry[key] for key in ('id', 'enters', 'title', 'equation', 'package')}
                for entry in self.to_json()['effects']]

    def _document(self) -> dict[str, Any]:
        from hst_drive.report.effects import as_json

        return as_json(self.declared)


class Losses(Result):
    """Steady-state losses of motors: resistances, characteristics, missing term."""

    def __init__(self, content: Mapping[str, Any], shown: str, notes: Iterable[str]):
        self.notes = tuple(notes)
        self._content, self._shown = content, shown

    def __str__(self) -> str:
        return self._shown

    def _table(self) -> Any:
        """Return a row per operating point, SI; of transmissions the quantities."""
        found = self.to_json()
        rows = found.get('rows') or found['missing_term']['terms']
        return [_flat(row) for row in rows]

    def _document(self) -> Mapping[str, Any]:
        return self._content


def _flat(row: Mapping[str, Any], before: str = '') -> dict[str, Any]:
    """Return nested mappings as one, names joined with dots."""
    out: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            out.update(_flat(value, f'{before}{key}.'))
        else:
            out[f'{before}{key}'] = value
    return out
