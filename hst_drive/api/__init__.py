# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The library as a notebook uses it: ``import hst_drive as hd``.

A thin shell: it reads, hands over to the pure library, and wraps what comes back so that it
prints, shows and converts. The names are public as docs/python.md says.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
import os
from typing import Any, Union

from hst_drive.api import given
from hst_drive.api.results import (
    Comparison, Design, Diagnosis, Effects, Log, Losses, Result, RigFile)
from hst_drive.errors import InputError

__all__ = ['Comparison', 'Design', 'Diagnosis', 'Effects', 'Log', 'Losses', 'Result', 'RigFile',
           'adopt', 'commission', 'compare', 'design', 'diagnose', 'effects', 'load_rig', 'losses',
           'read_log', 'simulate']

PathLike = Union[str, 'os.PathLike[str]']
Channels = Union[PathLike, Mapping[str, Any], None]
Rigs = Union[RigFile, PathLike, Mapping[str, Any], None]
"""A rig: what ``load_rig`` returns, a rig file, its mapping; None is the shipped test rig."""
Sizes = Mapping[str, Mapping[str, Union[float, str]]]


def read_log(source: Any, channels: Channels = None, name: str | None = None) -> Log:
    """
    Read a recording.

    Parameters
    ----------
    source : path, pandas.DataFrame or mapping of str to array
        CSV file, rosbag2 folder or .mcap file; or a table in memory whose columns are
        ``name[unit]``. A named index of a frame is a column as well.
    channels : path or mapping, optional
        Channel map: foreign names and units to ours (``config/channels_example.yaml``), or the
        mapping of such a file.
    name : str, optional
        For tables and messages; by default that of the file.

    Returns
    -------
    Log
        The recording in SI; ``notes`` say what was repaired or left out.

    Raises
    ------
    InputError
        If it cannot be used; one line that says what is wrong, where, and what to do.

    Examples
    --------
    >>> import hst_drive as hd
    >>> import numpy as np
    >>> time = np.arange(0.0, 1.0, 0.01)
    >>> log = hd.read_log({'time[s]': time, 'motor_speed[rpm]': 60 + time}, name='bench')
    >>> print(log)
    bench: 100 samples, 0.99 s, every 10 ms
    <BLANKLINE>
    channel      unit  least  mean  most  missing
    -----------  ----  -----  ----  ----  -------
    motor_speed  rpm    60.0  60.5  61.0        0

    """
    from dataclasses import replace

    from hst_drive.bag import ChannelMap, load_channel_map
    from hst_drive.bag import read_log as read
    from hst_drive.bag.arrays import is_table, read_arrays
    from hst_drive.bag.channels import parse_channel_map

    if isinstance(source, Log):
        return source
    if channels is None:
        mapping = ChannelMap()
    elif isinstance(channels, Mapping):
        mapping = parse_channel_map(dict(channels), 'channels')
    elif isinstance(channels, (str, os.PathLike)):
        mapping = load_channel_map(channels)
    else:
        raise InputError(f'channels: found {type(channels).__name__}, expected the path of a '
                         'channel map or its mapping')
    if is_table(source):
        return Log(read_arrays(source, mapping, name or 'log'))
    run = read(given.path(source, 'log', given.TABLE), mapping)
    return Log(replace(run, name=name) if name else run)


def load_rig(rig: Rigs = None) -> RigFile:
    """
    Load a rig: the numbers of a drive, or of a part of one.

    Parameters
    ----------
    rig : path or mapping, optional
        Rig file, or its mapping; by default the shipped test rig.

    Raises
    ------
    InputError
        One line that names file and key and suggests the mend.

    Examples
    --------
    >>> import hst_drive as hd
    >>> rig = hd.load_rig()
    >>> rig.content['motor']['displacement_cc_rev']
    195
    >>> rig.effects
    {}

    """
    from hst_drive.rig import default_rig_file
    from hst_drive.rig.yaml_file import read_yaml

    if isinstance(rig, RigFile):
        return rig
    if isinstance(rig, Mapping):
        return RigFile(dict(rig), 'rig')
    path = given.path(rig, 'rig') if rig is not None else str(default_rig_file())
    return RigFile(read_yaml(path), path)


def compare(logs: Any, rig: Rigs = None, *, channels: Channels = None, closed_loop: bool = False,
            all_seconds: bool = False) -> Comparison:
    """
    Replay the measured inputs of logs through the model: how well does it fit, and where not.

    Parameters
    ----------
    logs : log or sequence of logs
        What ``read_log`` returns or takes.
    rig : RigFile, path or mapping, optional
        By default the shipped test rig.
    channels : path or mapping, optional
        Channel map, for logs that are not read yet.
    closed_loop : bool
        Let the rig's controller command the pump, and compare the command, too.
    all_seconds : bool
        Judge also the start from rest and cavitation.

    Returns
    -------
    Comparison
        ``noise_ratio`` is the error of each signal over what a perfect model would show.

    Raises
    ------
    InputError
        If a log lacks the channels that a replay needs, or comes twice.

    Examples
    --------
    >>> import hst_drive as hd
    >>> log = hd.simulate('paper_step', effects={'motor_leakage': {'conductance': 2e-12}})
    >>> found = hd.compare(log)
    >>> found.noise_ratio['motor_speed'] > 1.5
    True
    >>> with_it = hd.load_rig().with_effects({'motor_leakage': {'conductance': 2e-12}})
    >>> hd.compare(log, with_it).noise_ratio['motor_speed'] < 1.2
    True

    """
    from hst_drive.measure.compare import compare as work
    from hst_drive.measure.compare import model_of

    file, runs = load_rig(rig), _runs(logs, channels)
    result = work(model_of(file.rig, runs), runs, closed_loop=closed_loop,
                  all_seconds=all_seconds)
    return Comparison(result, file, runs)


def commission(logs: Any, rig: Rigs = None, *, channels: Channels = None,
               day_to_day: float | None = None,
               progress: Callable[[str], None] | None = None) -> RigFile:
    """
    Learn a machine's own numbers from logs of when it was healthy.

    Parameters
    ----------
    logs : log or sequence of logs
        What ``read_log`` returns or takes; better of two or three days.
    rig : RigFile, path or mapping, optional
        Of the make; by default the shipped test rig.
    channels : path or mapping, optional
        Channel map, for logs that are not read yet.
    day_to_day : float, optional
        By how much the machine differs from one day to the next, one sigma, in tolerances of the
        make; by default from the logs, if there are several, else 0.1.
    progress : callable, optional
        Called with a text while the work goes on, e.g. ``print``.

    Returns
    -------
    RigFile
        With it ``diagnose`` says what has changed since.

    Raises
    ------
    InputError
        If something is missing in the model of these logs, or they tell nothing.

    Examples
    --------
    >>> import hst_drive as hd
    >>> healthy = hd.simulate('commissioning').between(0.0, 30.0)
    >>> unit = hd.commission(healthy)
    >>> unit.rig.scatter['motor.leakage'] < hd.load_rig().rig.tolerances['motor.leakage']
    True

    """
    from hst_drive.diagnose.commission import commission as work
    from hst_drive.rig.fingerprint import day_to_day_share

    file = load_rig(rig)
    if day_to_day is not None:
        day_to_day = day_to_day_share(given.number(day_to_day, 'day_to_day'), 'day_to_day')
    found = work(file.content, file.source, _runs(logs, channels), day_to_day,
                 progress=given.progress(progress))
    return RigFile(found.rig, 'commissioned rig')


def diagnose(logs: Any, rig: Rigs = None, *, holdout: Any = (), channels: Channels = None,
             progress: Callable[[str], None] | None = None) -> Diagnosis:
    """
    Say which physical effect the model lacks, how large it is and how sure that is.

    Parameters
    ----------
    logs : log or sequence of logs
        One campaign of one drive: what ``read_log`` returns or takes.
    rig : RigFile, path or mapping, optional
        By default the shipped test rig.
    holdout : log or sequence of logs, optional
        To judge on; without them a third of each log is held out.
    channels : path or mapping, optional
        Channel map, for logs that are not read yet.
    progress : callable, optional
        Called with a text while the work goes on, e.g. ``print``.

    Raises
    ------
    InputError
        If the logs lack what a replay needs, tell nothing, or one comes twice.

    Examples
    --------
    >>> import hst_drive as hd
    >>> log = hd.simulate('commissioning', effects={'motor_leakage': {'conductance': 2e-12}})
    >>> found = hd.diagnose(log.between(0.0, 30.0))
    >>> found.verdict, list(found.effects)
    ('missing_effect', ['motor_leakage'])

    """
    from hst_drive.diagnose.decide import diagnose as work

    file = load_rig(rig)
    training = _several(logs)
    runs = _runs([*training, *_several(() if holdout is None else holdout)], channels)
    result = work(file.rig, runs[:len(training)], runs[len(training):],
                  progress=given.progress(progress))
    return Diagnosis(result, file, runs, len(runs) - len(training))


def adopt(diagnosis: Diagnosis | PathLike | Mapping[str, Any], rig: Rigs = None, *,
          formula: bool = False, calibration: bool = False) -> RigFile:
    """
    Return the rig with the effects that a diagnosis found, and with the unit's calibration.

    Parameters
    ----------
    diagnosis : Diagnosis, path or mapping
        The answer of ``diagnose``, or the JSON of one.
    rig : RigFile, path or mapping, optional
        The rig that was diagnosed; a Diagnosis knows it.
    formula : bool
        Where something stayed unknown: adopt the formula for it.
    calibration : bool
        Where nothing is missing: adopt by how much the unit is off its datasheet.

    Raises
    ------
    InputError
        If there is nothing to adopt, or the rig is another one.

    Examples
    --------
    >>> import hst_drive as hd
    >>> log = hd.simulate('commissioning', effects={'motor_leakage': {'conductance': 2e-12}})
    >>> rig = hd.adopt(hd.diagnose(log.between(0.0, 30.0)))
    >>> 1.5e-12 < rig.effects['motor_leakage']['conductance'] < 2.5e-12
    True

    """
    from hst_drive.diagnose.adopt import adopt as work

    content, source = _document(diagnosis)
    if rig is None and isinstance(diagnosis, Diagnosis):
        rig = diagnosis.rig
    file = load_rig(rig)
    return RigFile(work(dict(file.content), content, source, file.source, formula=formula,
                        calibration=calibration), 'adopted rig')


def simulate(inputs: Any, rig: Rigs = None, *, effects: Sizes | Iterable[str] | None = None,
             seed: int = 1) -> Log:
    """
    Run the model and read its sensors: what a log of such a drive would be.

    Parameters
    ----------
    inputs : str, path, Design, log, pandas.DataFrame or mapping
        A shipped scenario ('paper_step'), a scenario file, or what ``design`` returns; or a
        table with the commands: time, pump_command, pprv_command and, if known,
        oil_temperature.
    rig : RigFile, path or mapping, optional
        By default the shipped test rig; its effects are on.
    effects : mapping or iterable of str, optional
        More effects: id to parameters, as numbers in SI or texts like '0.0078 L/min/bar', a
        parameter that is left out being neutral; or ids alone, at their typical sizes.
    seed : int
        Of the sensors' noise and, in a scenario, of the ground's roughness.

    Raises
    ------
    InputError
        If the rig is only a part of a drive, or something is not known.

    Examples
    --------
    >>> import hst_drive as hd
    >>> log = hd.simulate('paper_step', effects=['motor_leakage'])
    >>> 'motor_speed' in log.channels
    True

    """
    from hst_drive.api.play import play

    file = load_rig(rig)
    table = None
    if isinstance(inputs, Design):
        inputs = inputs.scenario
    elif not isinstance(inputs, (str, os.PathLike)):
        table = read_log(inputs).run
    return Log(play(file.rig, inputs if table is None else table, effects,
                    given.whole(seed, 'seed')))


def design(diagnosis: Diagnosis | PathLike | Mapping[str, Any] | None = None, rig: Rigs = None, *,
           effects: Sequence[str] | None = None, duration: float = 120.0,
           closed_loop: bool = False) -> Design | None:
    """
    Find the test, or the sensor, that separates effects which logs cannot.

    Parameters
    ----------
    diagnosis : Diagnosis, path or mapping, optional
        The answer of ``diagnose``, or the JSON of one.
    rig : RigFile, path or mapping, optional
        The rig that was diagnosed; a Diagnosis knows it.
    effects : sequence of str, optional
        Tell these apart; by default what the diagnosis could not.
    duration : float
        Longest test, 20 to 120 s.
    closed_loop : bool
        Let the controller hold the speed; by default its commands are given.

    Returns
    -------
    Design or None
        None if the diagnosis leaves nothing to tell apart.

    Raises
    ------
    InputError
        If neither a diagnosis nor effects are given, or the rig is another one.

    Examples
    --------
    What a diagnosis without anything ambiguous leaves to be told apart; else a test is sought
    for a minute or two.

    >>> import hst_drive as hd
    >>> found = {'schema': 'hst_drive/diagnosis/1', 'verdict': 'missing_effect',
    ...          'errors': {'before': {'motor_speed': 4.6}}, 'effects': [{
    ...              'id': 'motor_leakage', 'parameters': {'conductance': {'value': 2e-12}}}]}
    >>> hd.design(found) is None
    True

    """
    from hst_drive.diagnose.next_test import next_test

    if diagnosis is None and effects is None:
        raise InputError('design: expected a diagnosis, or effects to tell apart')
    content, source = (None, '') if diagnosis is None else _document(diagnosis)
    if rig is None and isinstance(diagnosis, Diagnosis):
        rig = diagnosis.rig
    wanted = None if effects is None else given.ids(effects, 'effects')
    found = next_test(load_rig(rig).rig, content, source, wanted,
                      duration=given.number(duration, 'duration'), closed_loop=closed_loop)
    return Design(found) if found is not None else None


def effects(identity: str | None = None, *, rig: Rigs = None) -> Effects:
    """
    Return the physical effects that the model can add, or explain one.

    Parameters
    ----------
    identity : str, optional
        The effect to explain; by default all are listed.
    rig : RigFile, path or mapping, optional
        List only what has a place in the equations of its circuit; by default those of all
        circuits.

    Raises
    ------
    InputError
        If there is no such effect, or it has no place there.

    Examples
    --------
    >>> import hst_drive as hd
    >>> hd.effects('motor_leakage').ids
    ('motor_leakage',)
    >>> 'motor_leakage' in hd.effects().ids
    True
    >>> 'valve_lag' in hd.effects(rig=hd.load_rig()).ids
    False

    """
    from hst_drive.report.effects import chosen

    if identity is not None and not isinstance(identity, str):
        raise InputError(f'effects: found {identity!r}, expected the id of one effect')
    return Effects(chosen(identity, None if rig is None else load_rig(rig).rig), identity)


def losses(table: Any, *, channels: Channels = None, oil: str = 'ISO VG 46') -> Losses:
    """
    Identify the steady-state losses of motors from a bench table.

    Parameters
    ----------
    table : path, pandas.DataFrame or mapping of str to array
        A row per operating point: motor_displacement, oil_temperature, load_torque,
        motor_speed, supply_pressure, supply_flow and, optionally, case_drain_flow, as
        ``name[unit]``.
    channels : path or mapping, optional
        Channel map: foreign column names and units to ours, constants for all rows.
    oil : str
        Viscosity grade (``config/oil_grades.yaml``).

    Raises
    ------
    InputError
        If the table cannot be used; names row or column.

    Examples
    --------
    >>> import hst_drive as hd
    >>> found = hd.losses({
    ...     'motor_displacement[cc/rev]': [100, 100], 'oil_temperature[degC]': [50, 50],
    ...     'load_torque[N.m]': [90, 180], 'motor_speed[rpm]': [95, 90],
    ...     'supply_pressure[bar]': [60, 120], 'supply_flow[L/min]': [10, 10]})
    >>> found.to_json()['rows_used']
    2

    """
    from hst_drive.api.bench import study

    if not isinstance(oil, str):
        raise InputError(f"oil: found {oil!r}, expected a viscosity grade, as 'ISO VG 46'")
    return study(table, channels, oil)


def _several(logs: Any) -> list[Any]:
    """Return what was given for one log or several as a list."""
    from hst_drive.bag.arrays import is_table

    one = isinstance(logs, (str, os.PathLike, Log)) or is_table(logs)
    # What is neither is refused by read_log.
    return [logs] if one or not isinstance(logs, Iterable) else list(logs)


def _runs(logs: Any, channels: Channels) -> list[Any]:
    from hst_drive.bag.campaign import together

    found = _several(logs)
    if not found:
        raise InputError('logs: there is none; give at least one')
    return together([read_log(log, channels).run for log in found])


def _document(diagnosis: Diagnosis | PathLike | Mapping[str, Any]) -> tuple[dict[str, Any], str]:
    """Return the JSON of a diagnosis, and where it came from."""
    from hst_drive.report.files import read_json

    if isinstance(diagnosis, Diagnosis):
        return diagnosis.to_json(), 'diagnosis'
    if isinstance(diagnosis, Mapping):
        return dict(diagnosis), 'diagnosis'
    if not isinstance(diagnosis, (str, os.PathLike)):
        raise InputError(f'diagnosis: found {type(diagnosis).__name__}, expected what diagnose '
                         'returned, or the JSON of one')
    return read_json(str(diagnosis)), str(diagnosis)
