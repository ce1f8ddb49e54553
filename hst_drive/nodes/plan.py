# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a run consists of: the parameters of its nodes, checked before anything starts."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hst_drive.errors import InputError
from hst_drive.load import load_scenario, Scenario
from hst_drive.model import Drive
from hst_drive.model.steady import operating_point
from hst_drive.nodes import wiring
from hst_drive.nodes.both_ways import dead_band_of
from hst_drive.nodes.recordings import read_recording
from hst_drive.nodes.settings import effect_texts, effects_in
from hst_drive.rig import load_rig, Rig
from hst_drive.rig.rig import OPEN

_NONE = -100.0  # V; no first command
_LEAST = 3      # priority of the plant, so that controller and others lie below it


@dataclass(frozen=True)
class Options:
    """
    What a user may choose of a run; None: as the scenario says.

    Attributes
    ----------
    scenario : str
        Name of a shipped scenario, or a file.
    output : str, optional
        Folder to record to; by default scenario and time of day.
    realtime : bool
        The clock on the wall; else simulated time in lockstep.
    speed : float, optional
        In lockstep, simulated per real second; None: as fast as it goes.
    rig, log, channels : str, optional
        Rig file; drilling log or recording in place of the scenario's; its channel map.
    effects : tuple of str
        Hidden in the plant, as ``parse_effects`` reads them.
    effects_from : float
        Time of the run (s) from which on they act.
    seed : int, optional
        Of the sensors' noise.
    duration, rate : float
        s, samples per second.
    topics : tuple of str
        Readings that are off by default and shall be on.
    truth : bool
        Record the values without noise as well.
    priority : int
        Real-time priority of the plant; the controller's is one below, the others' two. 0: none.

    """

    scenario: str
    output: str | None = None
    realtime: bool = False
    speed: float | None = None
    rig: str | None = None
    log: str | None = None
    channels: str | None = None
    effects: tuple[str, ...] = ()
    effects_from: float = 0.0
    seed: int | None = None
    duration: float | None = None
    rate: float = 100.0
    topics: tuple[str, ...] = ()
    truth: bool = False
    priority: int = 0


@dataclass(frozen=True)
class Plan:
    """The nodes' parameters by node, and what the report needs."""

    parameters: Mapping[str, Mapping[str, Any]]
    output: Path
    duration: float
    title: str
    closed_loop: bool
    notes: tuple[str, ...]


def make_plan(options: Options) -> Plan:
    """
    Turn options into the nodes' parameters.

    Raises
    ------
    InputError
        For anything that a node would refuse: nothing is started then.

    """
    rig = load_rig(options.rig)
    nodes = wiring.nodes_of(rig.circuit, rig.source)
    scenario = load_scenario(options.scenario, rig, options.log, options.channels,
                             read_recording)
    duration = scenario.duration if options.duration is None else options.duration
    seed = scenario.seed if options.seed is None else options.seed
    for name, value, low, high in (
            ('--duration', duration, 0.1, 1e6), ('--rate', options.rate, 1.0, 1000.0),
            ('--speed', 1.0 if options.speed is None else options.speed, 1e-3, 1e4),
            ('--priority', options.priority or _LEAST, _LEAST, 99),
            ('--effects-from', options.effects_from, 0.0, 1e7), ('--seed', seed, 0, 2**31 - 1)):
        if not low <= value <= high:
            raise InputError(f'{name} {value:g}: expected {low:g} to {high:g}')
    if options.effects_from >= duration:
        raise InputError(f'--effects-from {options.effects_from:g}: the run ends after '
                         f'{duration:g} s; choose an earlier time')
    if options.priority and not options.realtime:
        raise InputError(f'--priority {options.priority}: is for --realtime; simulated time waits '
                         'for whoever is late: leave it out, or add --realtime')
    output = Path(options.output
                  or f'{Path(options.scenario).stem}_{datetime.now():%Y%m%d_%H%M%S}')
    if output.exists():
        raise InputError(f'{output}: exists already; bags are not overwritten: choose another '
                         'name with -o or remove it')
    _refuse_unwritable(output)
    effects = effects_in(rig, (*effect_texts(scenario.hidden_effects), *options.effects))
    wiring.readings(options.topics, rig.circuit)
    rig_file = _absolute(options.rig)
    source = Path(scenario.source)
    common = {'lockstep': not options.realtime, 'partners': list(nodes), 'circuit': rig.circuit,
              'lookahead': not options.realtime and not options.speed}
    extra = {'extra_topics': list(options.topics) or [''], 'truth': options.truth}
    start = _start(rig, {} if options.effects_from else effects, scenario)
    law = rig.controller
    notes = {'scenario': options.scenario, 'log': options.log or '', 'seed': seed,
             'rig': rig.name,
             'effects': ' '.join(effect_texts(effects)), 'effects_from': options.effects_from}
    parameters = {
        'plant': {**common, **extra, 'rig': rig_file, 'seed': seed, 'rate': float(options.rate),
                  'duration': float(duration), 'speed': float(options.speed or 0.0),
                  'effects': effect_texts(effects) or [''], 'progress': True,
                  'effects_from': float(options.effects_from),
                  'start_speed': start[0], 'start_pprv_command': start[1]},
        'load_profile': {**common, 'scenario': str(source.resolve()), 'rig': rig_file,
                         'rate': float(options.rate),
                         'log': _absolute(options.log),
                         'channels': _absolute(options.channels)},
        'controller': {**common, 'mode': scenario.mode, 'kp': law.kp, 'ki': law.ki,
                       'sample_time': law.sample_time, 'u_clamp_min': law.output_limits[0],
                       'u_clamp_max': law.output_limits[1], 'start_command': start[2],
                       'dead_band': dead_band_of(rig)},
        'estimator': {**common, 'rig': rig_file, 'extra_topics': extra['extra_topics'],
                      'bag': str(output)},
        'recorder': {**common, **extra, 'output': str(output.resolve()),
                     'notes': [f'{key}={value}' for key, value in notes.items()]},
    }
    parameters = {name: parameters[name] for name in nodes}
    if options.priority:
        for node, entry in parameters.items():
            entry['priority'] = options.priority - {'plant': 0, 'controller': 1}.get(node, 2)
    return Plan(parameters=parameters, output=output, duration=duration, notes=scenario.notes,
                title=scenario.title, closed_loop=scenario.mode == 'closed_loop')


def _absolute(path: str | None) -> str:
    return str(Path(path).resolve()) if path else ''


def _refuse_unwritable(folder: Path) -> None:
    """Raise InputError if the folder cannot be made: better told before the nodes start."""
    above = next(path for path in folder.absolute().parents if path.exists())
    try:
        with TemporaryDirectory(dir=above):
            pass
    except OSError as error:
        raise InputError(f'{folder}: cannot be made ({error.strerror}); name one with -o in a '
                         'folder that you may write to') from None


def _start(rig: Rig, effects, scenario: Scenario) -> tuple[float, float, float]:
    """Return speed (rad/s), PPRV command and pump command (V) to start with."""
    rig.require(*(('pump', 'motor', 'line', 'relief_valve', 'loading')
                  if rig.circuit == OPEN else ()), 'controller', purpose='a run of the nodes')
    if scenario.start == 'rest':
        return 0.0, 0.0, _NONE
    speed, command = scenario.speed_setpoint(0.0), scenario.load.pprv_command(0.0)
    point = operating_point(Drive(rig, effects), speed, pprv_command=command)
    return float(speed), float(command), float(point.pump_command)
