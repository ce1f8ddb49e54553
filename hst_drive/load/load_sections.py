# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Torque loads out of a scenario's ``load`` section: profiles, ground and drilling logs."""
from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from hst_drive.load.drilling_log import COLUMNS, parse_drilling_log, to_profile, Use
from hst_drive.load.ground import Bit, Ground, Layer
from hst_drive.load.keys import Keys
from hst_drive.load.profile_sections import KINDS, read_profile, TORQUE
from hst_drive.load.profiles import Profile
from hst_drive.load.rocks import ROCKS, typical_strength

LOAD_KINDS = (*KINDS, 'ground', 'drilling_log')
_REV = 6.283185307179586


class TorqueLoad(NamedTuple):
    """Bit torque over time (N.m), what the reader should know, and where it ends (s)."""

    profile: Profile
    notes: tuple[str, ...] = ()
    end: float | None = None


def read_load(keys: Keys, speed: Profile, duration: float | None, seed: int,
              read_text: Callable[[str | None], tuple[str, str]]) -> TorqueLoad:
    """
    Build the torque load from its section.

    Parameters
    ----------
    keys : Keys
        The section.
    speed : Profile
        Speed set point, rad/s.
    duration : float or None
        Of the run, s; None if the load decides, which a drilling log alone can.
    seed : int
        Of the roughness and random steps.
    read_text : callable
        Takes the section's ``file`` (or None) and returns text and name of that file.

    Raises
    ------
    InputError
        Naming file and key.

    """
    kind = keys.choice('kind', LOAD_KINDS, 'constant')
    if kind == 'drilling_log':
        return _drilling_log(keys, read_text)
    if duration is None:
        raise keys.fail('kind', f"'{kind}' does not end by itself; add duration_s at the top")
    if kind == 'ground':
        ground = _ground(keys, speed, duration, seed)
        return TorqueLoad(ground[0], ground[0].notes + ground[1])
    return TorqueLoad(read_profile(keys, TORQUE, duration, seed, salt=2))


def _ground(keys: Keys, speed: Profile, duration: float,
            seed: int) -> tuple[Ground, tuple[str, ...]]:
    rate = keys.number('penetration_rate', 'm/h', low=1e-3, high=1e4)
    turning = keys.number('at_speed', 'rpm', 100.0 * _REV / 60.0, low=0.1, high=1e4)
    bit = Bit(
        diameter=keys.number('bit_diameter', 'mm', low=5.0, high=5000.0),
        depth_of_cut=rate * _REV / turning,
        at_strength=keys.number('at_strength', 'MPa', Bit.at_strength, low=0.1, high=1000.0),
        strength_exponent=keys.number('strength_exponent', '1', Bit.strength_exponent,
                                      low=0.0, high=2.0),
        efficiency=keys.number('efficiency', '1', Bit.efficiency, low=0.01, high=1.0),
        weight=keys.number('weight_on_bit', 'kN', Bit.weight, low=0.0, high=5000.0),
        height=keys.number('bit_height', 'mm', Bit.height, low=0.1, high=1000.0),
        free_torque=keys.number('free_torque', 'N.m', Bit.free_torque, low=0.0, high=1e6))
    start = keys.number('start', 's', 0.0, low=0.0)
    scale = keys.number('torque_scale', '1', 1.0, low=1e-6, high=1e3)
    notes: list[str] = []
    layers = [_layer(part, notes) for part in keys.sections('layers')]
    keys.done()
    return Ground(layers, bit, speed, duration, start=start, seed=seed, scale=scale), tuple(notes)


def _layer(keys: Keys, notes: list[str]) -> Layer:
    rock = keys.text('rock')
    ucs = keys.number('ucs', 'MPa', None, low=0.1, high=1000.0)
    if ucs is None:
        try:
            ucs = typical_strength(rock)
        except ValueError as error:
            raise keys.fail('rock', f': {error}') from None
    elif rock in ROCKS and not ROCKS[rock][0] <= ucs <= ROCKS[rock][1]:
        low, high = ROCKS[rock]
        notes.append(f'{keys.path}: {ucs / 1e6:g} MPa is unusual for {rock} '
                     f'({low / 1e6:g} to {high / 1e6:g} MPa)')
    layer = Layer(rock, keys.number('thickness', 'mm', low=0.1, high=1e7), ucs,
                  keys.number('roughness', '1', 0.0, low=0.0, high=1.0),
                  keys.number('roughness_length', 'mm', 1e-3, low=0.01, high=1e5))
    keys.done()
    return layer


def _drilling_log(keys: Keys, read_text: Callable) -> TorqueLoad:
    columns = {}
    if keys.has('columns'):
        section = keys.section('columns')
        for name in COLUMNS:
            if section.has(name):
                column = section.section(name)
                columns[name] = column.text('name'), column.text('unit')
                column.done()
        section.done()
    use = _use(keys)
    text, name = read_text(keys.text('file', None))
    keys.done()
    profile, notes = to_profile(parse_drilling_log(text, name, columns), use)
    return TorqueLoad(profile, notes, profile.times[-1])


def _use(keys: Keys) -> Use:
    factor = keys.number('torque_factor', '1', None, low=-1e6, high=1e6)
    torque_range = keys.numbers('torque_range', 'N.m', low=0.0, high=1e6, count=2) \
        if keys.has('torque_range', 'N.m') else None
    if (factor is None) == (torque_range is None):
        raise keys.fail('torque_factor', 'or torque_range_N_m: expected exactly one of the two')
    if factor == 0.0:
        raise keys.fail('torque_factor', 'is 0, expected a number other than 0')
    units = {'depth': 'm', 'time': 's'}
    axes = [axis for axis, unit in units.items() if keys.has(f'{axis}_range', unit)]
    if len(axes) > 1:
        raise keys.fail('time_range_s', 'stands beside a depth range; keep one')
    axis = (*axes, 'depth')[0]
    window = keys.numbers(f'{axis}_range', units[axis], low=0.0, count=2) if axes else None
    return Use(
        factor=factor, torque_range=tuple(torque_range) if torque_range else None,
        time_per_row=keys.number('time_per_row', 's', None, low=1e-4),
        speed_up=keys.number('speed_up', '1', 1.0, low=1e-3, high=1e9),
        window=tuple(window) if window else None, axis=axis,
        start=keys.number('start', 's', 0.0, low=0.0))
