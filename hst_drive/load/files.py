# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenario files: where the shipped ones are, and reading one with the log it names."""
from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.recorded import Recording
from hst_drive.load.scenario import parse_scenario, Scenario
from hst_drive.resources import share
from hst_drive.rig.load import default_rig
from hst_drive.rig.rig import OPEN, Rig
from hst_drive.rig.yaml_file import read_yaml
from hst_drive.units import from_si
import numpy as np

_LOOKS = 2000       # at a scenario's set point


def shipped_scenarios() -> dict[str, Path]:
    """Return the scenarios that come with the package, by name."""
    return {path.stem: path for path in sorted(share('config', 'scenarios').glob('*.yaml'))}


def load_scenario(source: str | Path, rig: Rig | None = None,
                  log: str | Path | None = None, channels: str | Path | None = None,
                  read: Callable[[Path, Path | None], Recording] | None = None) -> Scenario:
    """
    Load a scenario.

    Parameters
    ----------
    source : str or Path
        A file, or the name of a shipped scenario.
    rig : Rig, optional
        Whose loading unit, on the open circuit, turns torque into a PPRV command; default the
        shipped test rig.
    log : str or Path, optional
        Drilling log, or recording, in place of the one that the scenario names.
    channels : str or Path, optional
        Channel map of the recording, likewise.
    read : callable, optional
        Reads a recording from its path and that of a channel map (or None).

    Raises
    ------
    InputError
        One line that names file and key and suggests the mend.

    """
    path = _find(source)
    rig = rig or default_rig()
    one_way = rig.circuit == OPEN
    if one_way:
        rig.require('loading', purpose='the load of a scenario')

    asked: list[str | None] = []
    mapped: list[str | None] = []

    def read_text(name: str | None) -> tuple[str, str]:
        asked.append(name)
        if log is None and name is None:
            raise InputError(f"{path}: 'load.file' is missing; name a drilling log there or give "
                             'one with --log')
        place = Path(log) if log is not None else path.parent / name
        try:
            return place.read_text(encoding='utf-8-sig'), str(place)
        except OSError as error:
            raise InputError(f'{place}: cannot be read ({error.strerror}); check the path') \
                from None
        except UnicodeDecodeError:
            raise InputError(f'{place}: is not a text file in UTF-8; expected a CSV (a bag '
                             "is the log of the scenario 'recorded')") from None

    def read_recording(name: str | None, mapping: str | None) -> Recording:
        asked.append(name)
        mapped.append(mapping)
        if log is None and name is None:
            raise InputError(f"{path}: 'recording.file' is missing; name a recording there or "
                             'give one with --log')
        if channels is not None:
            mapping = channels
        elif mapping is not None:
            mapping = path.parent / mapping
        return read(Path(log) if log is not None else path.parent / name,
                    Path(mapping) if mapping is not None else None)

    try:
        unit = LoadingUnit.of(rig.loading) if one_way else None
    except ValueError as error:
        raise InputError(f'{rig.source or rig.name}: {error}') from None
    scenario = parse_scenario(read_yaml(path), unit, str(path), read_text,
                              read_recording if read else None)
    if one_way:
        _refuse_backwards(scenario, rig)
    if log is not None and not asked:
        raise InputError(f"{path}: drills no log (its 'load.kind' is neither drilling_log nor "
                         f'recorded), so --log {log} would not count; leave it out or choose a '
                         'scenario that does, e.g. real_log or recorded')
    if channels is not None and not mapped:
        raise InputError(f'{path}: plays no recording, so --channels {channels} would not count; '
                         "leave it out or choose a scenario that does, e.g. 'recorded'")
    return scenario


def _refuse_backwards(scenario: Scenario, rig: Rig) -> None:
    times = np.linspace(0.0, scenario.duration, _LOOKS)
    speeds = scenario.speed_setpoint.sample(times)
    if speeds.min() < 0.0:
        first = int(np.argmax(speeds < 0.0))
        raise InputError(
            f'{scenario.source}: speed_setpoint: is {from_si(speeds[first], "rpm"):.4g} rpm at '
            f"{times[first]:.4g} s, but {rig.name} ('circuit: open') turns one way: give a rig "
            'with a closed circuit (--rig)')


def _find(source: str | Path) -> Path:
    path, shipped = Path(source), shipped_scenarios()
    if path.is_file() or path.suffix in ('.yaml', '.yml'):
        return path
    if str(source) in shipped:
        return shipped[str(source)]
    near = get_close_matches(str(source), shipped, n=1)
    hint = f"did you mean '{near[0]}'?" if near else f'shipped: {", ".join(shipped)}'
    raise InputError(f"scenario '{source}': neither a file nor a shipped scenario; {hint}")
