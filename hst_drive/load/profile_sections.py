# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Profiles out of a scenario's sections, and the random or composed ones."""
from __future__ import annotations

from functools import partial
from typing import NamedTuple

from hst_drive.load.keys import Keys
from hst_drive.load.profiles import (
    Chirp, constant, Points, Profile, random_steps, Sequenced, Sine, Sum)
from hst_drive.units import to_si

KINDS = ('constant', 'steps', 'ramps', 'sine', 'chirp', 'random_steps', 'sum', 'sequence')


class Quantity(NamedTuple):
    """What a profile is of: key stem, unit in the key, plausible range in that unit."""

    name: str
    unit: str
    low: float
    high: float


SPEED = Quantity('speed', 'rpm', -10000.0, 10000.0)
TORQUE = Quantity('torque', 'N.m', -1e6, 1e6)
COMMAND = Quantity('command', 'V', -100.0, 100.0)
TEMPERATURE = Quantity('temperature', 'degC', -50.0, 200.0)


def read_profile(keys: Keys, what: Quantity, duration: float, seed: int,
                 salt: int = 0) -> Profile:
    """
    Build a profile from its section.

    Parameters
    ----------
    keys : Keys
        The section; ``kind`` is one of ``KINDS``, 'constant' if left out.
    what : Quantity
        Its quantity.
    duration : float
        Of the run, s.
    seed, salt : int
        Of random profiles; ``salt`` keeps two of one scenario apart.

    Raises
    ------
    InputError
        Naming file and key.

    """
    kind = keys.choice('kind', KINDS, 'constant')
    try:
        profile = _BUILD[kind](keys, what, duration, seed, salt)
    except ValueError as error:
        raise keys.fail('kind', f"'{kind}': {error}") from None
    keys.done()
    return profile


def _value(keys: Keys, what: Quantity, stem: str = '') -> float:
    return keys.number(stem + what.name, what.unit, low=what.low, high=what.high)


def _difference(keys: Keys, what: Quantity) -> float:
    """Return an amplitude; a temperature's only in K: degC would bring its offset in."""
    if what is TEMPERATURE:
        return keys.number('amplitude_K', '1', low=0.0, high=100.0)
    return keys.number('amplitude', what.unit, low=0.0, high=what.high)


def _constant(keys, what, duration, seed, salt):
    return constant(_value(keys, what))


def _points(keys, what, duration, seed, salt, hold):
    times = keys.numbers('time', 's', low=0.0)
    values = keys.numbers(what.name, what.unit, low=what.low, high=what.high)
    return Points(times, values, hold)


def _sine(keys, what, duration, seed, salt):
    return Sine(_value(keys, what, 'mean_'), _difference(keys, what),
                keys.number('frequency', 'Hz', low=0.0, high=1e4))


def _chirp(keys, what, duration, seed, salt):
    first, last = keys.numbers('frequency', 'Hz', low=1e-6, high=1e4, count=2)
    return Chirp(_value(keys, what, 'mean_'), _difference(keys, what), first, last,
                 keys.number('duration', 's', duration, low=1e-3))


def _random(keys, what, duration, seed, salt):
    return random_steps(
        _value(keys, what, 'low_'), _value(keys, what, 'high_'),
        keys.number('shortest', 's', low=1e-3), keys.number('longest', 's', low=1e-3),
        duration, (seed, salt))


def _sum(keys, what, duration, seed, salt):
    parts = [read_profile(part, what, duration, seed, 100 * salt + i + 1)
             for i, part in enumerate(keys.sections('parts'))]
    zero = to_si(0.0, what.unit)        # of degC: not once with each part
    return Sum([*parts, constant((1 - len(parts)) * zero)])


def _sequence(keys, what, duration, seed, salt):
    parts = []
    for i, part in enumerate(keys.sections('parts')):
        length = part.number('lasts', 's', low=1e-6)
        parts.append((length, read_profile(part, what, length, seed, 100 * salt + i + 1)))
    return Sequenced(parts)


_BUILD = dict(zip(KINDS, (
    _constant, partial(_points, hold='zero'), partial(_points, hold='linear'), _sine, _chirp,
    _random, _sum, _sequence)))
