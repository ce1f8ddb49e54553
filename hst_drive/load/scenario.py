# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A scenario: what is asked of the drive during a run, and what it has to turn against."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from hst_drive.errors import InputError
from hst_drive.load.keys import Keys, quantity
from hst_drive.load.load_sections import read_load
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.profile_sections import COMMAND, read_profile, SPEED, TEMPERATURE
from hst_drive.load.profiles import constant, Profile
from hst_drive.load.recorded import is_recorded, KIND, Recorded, Recording
import numpy as np

_PLAYED = ('speed_setpoint', 'oil_temperature', 'pump_command', 'pprv_command', 'load')
MODES = ('closed_loop', 'open_loop')
STARTS = ('rest', 'steady', KIND)


class LoadProfile:
    """
    The load of a run: a PPRV command, or without a loading unit a torque against the motion.

    Give either a torque, which the loading unit's steady state turns into a command at the set
    speed, or the command itself.

    Parameters
    ----------
    unit : LoadingUnit or None
        Of the rig, if it has one.
    speed : Profile
        Speed set point, rad/s.
    duration : float
        s.
    torque : Profile, optional
        At the hydromotor shaft, N.m.
    command : Profile, optional
        V.
    notes : tuple of str
        What was done to the data.

    Attributes
    ----------
    torque_profile : Profile or None
        The torque that is asked for; None where the command is given.
    notes : tuple of str
        With a line for each limit of the loading unit that the torque would pass.

    """

    def __init__(self, unit: LoadingUnit | None, speed: Profile, duration: float, *,
                 torque: Profile | None = None, command: Profile | None = None,
                 notes: tuple[str, ...] = ()):
        if (torque is None) == (command is None):
            raise ValueError('expected either a torque or a command')
        self.unit, self.speed, self.duration = unit, speed, duration
        self.torque_profile, self._command = torque, command
        if unit is None and torque is None:
            raise ValueError('a command needs a loading unit')
        self.notes = notes + (self._limits() if unit and torque is not None else ())

    def pprv_command(self, t: float) -> float:
        """Return the PPRV command at ``t`` (s), V."""
        if self._command is not None:
            limits = self.unit.command
            return min(max(self._command(t), limits[0]), limits[-1])
        return self.unit.command_of_torque(self.torque_profile(t), self.speed(t))

    def torque(self, t: float) -> float:
        """Return the torque that is asked for at ``t`` (s), or that the command gives, N.m."""
        if self.torque_profile is not None:
            return self.torque_profile(t)
        return self.unit.torque_of_command(self.pprv_command(t), self.speed(t))

    def _limits(self) -> tuple[str, ...]:
        times = np.linspace(0.0, self.duration, 2000)
        speeds, places = np.unique(self.speed.sample(times), return_inverse=True)
        asked = self.torque_profile.sample(times)
        low, high = np.array([self.unit.torque_range(speed) for speed in speeds.tolist()])[
            places].T
        notes = []
        for beyond, bound, word in ((low - asked, low, 'least'), (asked - high, high, 'greatest')):
            worst = int(np.argmax(beyond))
            if beyond[worst] > 1.0:
                notes.append(
                    f'{asked[worst]:.4g} N.m asked at {times[worst]:.4g} s, the {word} load of '
                    f'the loading unit there is {bound[worst]:.4g} N.m; held there for '
                    f'{100.0 * np.mean(beyond > 1.0):.3g} % of the run')
        return tuple(notes)


@dataclass(frozen=True)
class Scenario:
    """
    What happens in a run.

    Attributes
    ----------
    title, description : str
        For people.
    duration : float
        s.
    seed : int
        Of everything random: roughness, random steps, sensor noise.
    mode : str
        'closed_loop': the controller holds ``speed_setpoint``. 'open_loop': ``pump_command``
        is given.
    start : str
        'rest': the drive stands. 'steady': it runs steadily at the first set point and load.
    speed_setpoint : Profile
        rad/s. In open loop the speed at which a torque load is turned into a command.
    oil_temperature : Profile
        K.
    load : LoadProfile
        ``load.pprv_command(t)`` in V.
    pump_command : Profile or None
        V, in open loop.
    hidden_effects : dict
        Effects that the plant has and the model is not told of: id to parameters in SI.
    source : str
        File.

    """

    title: str
    duration: float
    seed: int
    mode: str
    start: str
    speed_setpoint: Profile
    oil_temperature: Profile
    load: LoadProfile
    pump_command: Profile | None = None
    hidden_effects: dict[str, dict[str, float]] = field(default_factory=dict)
    description: str = ''
    source: str = ''

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader should know before the run."""
        return self.load.notes


def parse_scenario(content: dict, unit: LoadingUnit | None, source: str = 'scenario',
                   read_text: Callable[[str | None], tuple[str, str]] | None = None,
                   read_recording: Callable[[str | None, str | None], Recording] | None = None
                   ) -> Scenario:
    """
    Build a scenario from the mapping of a scenario file (keys carry their unit).

    Parameters
    ----------
    content : dict
        The mapping.
    unit : LoadingUnit or None
        Of the rig; without one the load is a torque, and the drive starts at rest.
    source : str
        File, for messages.
    read_text : callable, optional
        Takes the ``file`` of a drilling log (or None) and returns its text and name.
    read_recording : callable, optional
        Takes ``file`` and ``channels`` of a recording (or None) and returns it.

    Raises
    ------
    InputError
        One line that names ``source`` and the key.

    """
    keys = Keys(content, source)
    title = keys.text('title')
    mode = keys.choice('mode', MODES, 'closed_loop')
    seed = keys.integer('seed', 0)
    duration = keys.number('duration', 's', None, low=0.1, high=1e6)
    start = keys.choice('start', STARTS, 'rest')
    description = keys.text('description', '')
    effects = _effects(keys)
    recorded = Recorded(keys.section('recording') if keys.has('recording') else None,
                        read_recording or _no_recording)
    if duration is None and any(is_recorded(keys.section(name)) for name in _PLAYED
                                if isinstance(content.get(name), dict)):
        duration = recorded.end

    def profile(name, what, salt, default=None):
        if not keys.has(name):
            return default
        if is_recorded(keys.section(name)):
            return recorded.profile(keys.section(name), name)
        # A drilling log may set the end of the run; random steps then cover an hour.
        return read_profile(keys.section(name), what, duration or 3600.0, seed, salt)

    speed = profile('speed_setpoint', SPEED, 1)
    temperature = profile('oil_temperature', TEMPERATURE, 3, constant(323.15))
    command = profile('pump_command', COMMAND, 4)
    if (mode == 'open_loop') != (command is not None):
        raise keys.fail('pump_command', 'is given in closed loop; remove it or set mode: open_loop'
                        if command is not None else 'is missing; open_loop needs it')
    if keys.has('load') == keys.has('pprv_command'):
        raise keys.fail('load', 'or pprv_command: expected exactly one of the two')
    if speed is None and (mode == 'closed_loop' or keys.has('load')):
        raise keys.fail('speed_setpoint', 'is missing; add it (also in open loop, where it is '
                        'the speed at which a torque becomes a command)')
    speed = speed or constant(0.0)
    if unit is None and keys.has('pprv_command'):
        raise keys.fail('pprv_command', 'is of a loading unit, which this rig has not; give the '
                        'torque as load')
    if unit is None and start != 'rest':
        raise keys.fail('start', f"is '{start}', expected 'rest': without a loading unit no "
                        'steady load is known')
    if keys.has('pprv_command'):
        pprv = profile('pprv_command', COMMAND, 2)
        torque, notes = None, ()
    elif is_recorded(keys.section('load')):
        torque, pprv = recorded.load(keys.section('load'))
        notes = ()
        if unit is None and torque is None:
            raise keys.fail('load', 'is a PPRV command in that recording, but this rig has no '
                            'loading unit; name a torque as load.channel')
    else:
        torque, notes, end = read_load(keys.section('load'), speed, duration, seed,
                                       read_text or _no_files)
        pprv, duration = None, duration or end
    keys.done()
    if duration is None:
        raise keys.fail('duration_s', 'is missing; add it')
    if start == KIND:
        start = 'steady' if recorded.turns(speed) else 'rest'
    load = LoadProfile(unit, speed, duration, torque=torque, command=pprv,
                       notes=(*recorded.notes, *notes))
    return Scenario(title, duration, seed, mode, start, speed, temperature, load, command,
                    effects, description, source)


def _no_files(name: str | None) -> tuple[str, str]:
    raise InputError(f"load.file: '{name}' cannot be read here; pass the log's text")


def _no_recording(name: str | None, channels: str | None) -> Recording:
    raise InputError('recording: cannot be read here; give the scenario profiles of its own')


def _effects(keys: Keys) -> dict[str, dict[str, float]]:
    """Return id -> parameters in SI; whether they exist is the drive's to check."""
    effects = keys.take('hidden_effects', {})
    if not isinstance(effects, dict):
        raise keys.fail('hidden_effects', f'is {effects!r}, expected effect ids with parameters')
    found = {}
    for name, parameters in effects.items():
        if not isinstance(parameters, dict):
            raise keys.fail(f'hidden_effects.{name}', f'is {parameters!r}, expected parameters '
                            'with values')
        found[str(name)] = {str(key): quantity(value, keys, f'hidden_effects.{name}.{key}')
                            for key, value in parameters.items()}
    return found
