# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
From the equations and the catalogue of effects to running code.

The text of ``kernel_template`` gets one guarded line per effect at its slot, switched by a flag,
and constants for the places in the parameter vector. ``compiled`` makes it run.
"""
from __future__ import annotations

import ast
from functools import lru_cache
import inspect
from typing import Any, Callable, Mapping, NamedTuple, Sequence

from hst_drive.effects import catalogue, edition, Effect, effect_of
from hst_drive.effects.base import arguments
from hst_drive.effects.slots import (
    SLOTS, USUAL_DAMPING_TIME, USUAL_FAR, USUAL_SHARE, USUAL_UPSTREAM)
from hst_drive.model import kernel_template
from hst_drive.model.compiled import compiles, running, terms
from hst_drive.model.parameters import NAMES, TABLES
import numpy as np

CONSTANTS = {
    'SIGN_WIDTH': 0.15,               # rad/s, smooth sign of friction and load torques
    'SIGN_SATURATED': 3.0,            # rad/s; beyond it tanh is 1 to the last digit
    'CAVITATION_PRESSURE': -0.9e5,    # Pa gauge
    'BEND_PRESSURE': 1e3,             # Pa and rad/s: differences of third order in one step, up
    'BEND_SPEED': 5e-4,               # to which Adams and Bashforth's method is trusted
    'BEND_COMPLIANCE': 1e5,           # Pa, of one step where the compliance goes with pressure
    'OIL_BENDS_AT': 2e7,              # Pa, where 'compressibility_under_pressure' holds
    'STEP_ERROR': 2e-5,               # of a step in a circuit, over the largest that a state was
    'BENT': 0.05,                     # what the bend of its stages counts
    'STRICTER': 10.0,                 # with steps of Adams and Bashforth
    'SHORTEST': 0.02,                 # of the usual step
    'SIZE_SPAN': 0.02,                # s; a state is at least what it moves by in that
    'NUDGE': 1e-6,                    # of the largest: what tells how fast a state decays
    'MOST_DECAY': 8.0,                # in a step; what decays faster is taken for that
    'STIFF_SPEED': 0.8,               # rad/s
    'STIFF_PRESSURE_SHARE': 0.99,     # of the relief pressure
    'LINE_UPSTREAM_SHARE': USUAL_UPSTREAM,  # of the line's volume lies before its resistance
    'LINE_FAR_SHARE': USUAL_FAR,      # of that volume lies behind the mass of its oil
    'LINE_FASTEST': 1000.0,           # rad/s; a line that swings faster cannot be told from none
    'LINE_STEP': 0.7,                 # of the time in which it swings by a radian
    'SHAFT_LOAD_SIDE_SHARE': USUAL_SHARE,   # of the inertia lies behind a flexible shaft
    'SHAFT_STIFF_SHARE': 0.17,        # of the step, where friction meets so little inertia
    'PILOT_SETTLED': 1e-6,            # of full stroke: nearer, what stands before the plate rests
    'PUMP_SPEED_AT_ONCE': 0.01,       # s; a shorter lag of the pump speed cannot be seen
    'SHAFT_STEP': 0.12,               # of the root of inertia times compliance
    'SHAFT_STALL_STEP': 1e-3,         # s; what lies behind a shaft may stall for some 20 ms
    'SHAFT_DAMPING_TIME': USUAL_DAMPING_TIME,
    'SHAFT_RIGID': 2.4e-6,            # s^2, compliance times inertia: less is rigid, and stiff
}
OUTPUTS: tuple[str, ...] = (
    'pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque',
    'pump_displacement', 'motor_inlet_pressure', 'case_drain_flow', 'pump_speed',
    'motor_torque_hydraulic', 'pump_flow', 'relief_flow', 'pprv_pressure',
    'motor_outlet_pressure')
STATES: tuple[str, ...] = (
    'displacement', 'pump_pressure', 'motor_speed', 'pprv_pressure', 'motor_angle', 'load_speed',
    'twist', 'speed_reading', 'play', 'last_command', 'slowdown',
    'wide_play', 'pilot_aim', 'late_speed_reading', 'line_flow', 'far_pressure')


# Which functions of the text are put into their callers, and which others only it calls.
INLINE = ('interpolate', 'interpolate2', 'smooth_sign', 'load_model', 'shaft', 'balances',
          'derivatives')
INSIDE = ('find', 'along', 'waved', 'of_unit', 'played', 'twist_under')


class Code(NamedTuple):
    """
    Generated equations, and how their vectors are laid out.

    ``places`` maps (effect id, parameter) to its place behind the baseline's parameters, which
    are 0 in ``neutral``; ``flags`` maps an effect id to its switch, ``slots`` a slot to the switch
    that any of its effects sets. ``usable`` are the effects whose first term the equations have.
    ``module`` has the running functions, None while this is but a text.
    """

    source: str
    places: dict[tuple[str, str], int]
    neutral: np.ndarray
    flags: dict[str, int]
    slots: dict[str, int]
    usable: frozenset[str]
    module: Any = None
    compiled: bool = False

    def vectors(self, base: Sequence[float],
                effects: Mapping[str, Mapping[str, float]]) -> tuple[np.ndarray, np.ndarray]:
        """Return parameters and switches: the baseline's numbers, effects that are on (SI)."""
        parameters = self.neutral.copy()
        parameters[:len(base)] = base
        switches = np.zeros(len(self.flags) + len(self.slots), dtype=np.int8)
        for name, values in effects.items():
            self.switch_on(name, values, parameters, switches)
        return parameters, switches

    def switch_on(self, name: str, values: Mapping[str, float], parameters: np.ndarray,
                  switches: np.ndarray) -> None:
        """Write an effect with its parameters (SI) into those vectors."""
        for key, value in values.items():
            parameters[self.places[name, key]] = value
        switches[self.flags[name]] = 1
        for slot, _ in effect_of(name).terms:
            switches[self.slots[slot]] = 1


def generate_drive(effects: dict[str, Effect]) -> Code:
    """Return ``generate`` of the open circuit's text."""
    return generate(effects, inspect.getsource(kernel_template), NAMES, TABLES)


def generate(effects: dict[str, Effect], template: str, names: Sequence[str],
             tables: Sequence[str]) -> Code:
    """
    Return the code of a template, as text.

    Parameters
    ----------
    effects : dict of str to Effect
        A term that reads what the text does not know where its slot lies is left out.
    template : str
        The equations, from ``import math`` on. Where they have a line ``# slot NAME kept``, the
        effects that are ``kept`` enter there, as ``NAME_kept``; with ``# slot NAME free`` so do
        formulas, which may read all that is known there.
    names, tables : sequence of str
        Numbers and tables that they use, as ``P_name`` and ``T_NAME``.

    """
    places, flags, neutral = {}, {}, [0.0] * len(names)
    for index, effect in enumerate(effects.values()):
        flags[effect.id] = index
        for parameter in effect.parameters:
            places[effect.id, parameter.name] = len(neutral)
            neutral.append(parameter.neutral)
    constants = {f'P_{name}': index for index, name in enumerate(names)}
    constants.update({f'T_{name}': index for index, name in enumerate(tables)})
    constants.update(CONSTANTS)
    slots = {slot: index for index, slot in enumerate(SLOTS, len(flags))}
    constants.update({f'SLOT_{slot}': index for slot, index in slots.items()})
    lines = [f'{name} = {value!r}' for name, value in constants.items()]
    text = template.splitlines()
    head = text.index('import math') + 1
    known = _known(template)
    body = []
    for number, line in enumerate(text[head:], head + 1):
        body.append(line)
        mark = line.strip()
        if not mark.startswith('# slot '):
            continue
        slot, _, part = mark[len('# slot '):].partition(' ')
        indent = line[:len(line) - len(line.lstrip())]
        variable = {'load_torque': 'whole_load_torque'}.get(slot, slot) + (part and f'_{part}')
        # A slot's own switch spares a look at each of its effects.
        body.append(f'{indent}if on[SLOT_{slot}]:')
        for name, effect, place, function in terms(effects):
            if place != slot or _part(effect, slot, template) != part:
                continue
            if call := _call(effect, function, places, known[number]):
                body += [f'{indent}    if on[{flags[effect.id]}]:',
                         f'{indent}        {variable} += {name}({call})']
        body.append(f'{indent}    pass')
    text = '\n'.join(['# Generated from the equations and the catalogue of effects.',
                      *text[:head], '', *lines, '', *body, ''])
    usable = frozenset(name for name in effects if f'effect_{name}(' in text)
    return Code(text, places, np.array(neutral), flags, slots, usable)


def _part(effect: Effect, slot: str, template: str) -> str:
    """Return the word behind the slot's name where an effect enters, '' without one."""
    for part, belongs in (('kept', effect.kept), ('free', effect.searched == 'never')):
        if belongs and f'# slot {slot} {part}' in template:
            return part
    return ''


def _call(effect: Effect, function: Callable, places: dict, known: set[str]) -> str:
    """Return what an effect's function is called with; empty if it reads what is not known."""
    words = []
    for argument in arguments(function):
        if (effect.id, argument) in places:
            words.append(f'p[{places[effect.id, argument]}]')
        elif argument in known:
            words.append(argument)
        elif effect.searched == 'never':
            words.append('0.0')     # a formula names all that it could read
        else:
            return ''
    return ', '.join(words)


def _known(template: str) -> dict[int, set[str]]:
    """Return the names that are known at the line of each slot."""
    found = {}
    for function in ast.parse(template).body:
        if not isinstance(function, ast.FunctionDef):
            continue
        names = [(0, argument.arg) for argument in function.args.args]
        names += [(node.lineno, node.id) for node in ast.walk(function)
                  if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
        for line in range(function.lineno, function.end_lineno + 1):
            found[line] = {name for at, name in names if at < line}
    return found


def kernel(compiled: bool | None = None) -> Code:
    """
    Return the code for all effects of the catalogue.

    Parameters
    ----------
    compiled : bool, optional
        True compiles with numba, False runs plain Python; by default numba is used if present.

    """
    if compiled is None:
        compiled = compiles()
    return _kernel(compiled, edition())


@lru_cache(maxsize=4)
def _kernel(compiled: bool, _: int) -> Code:
    effects = catalogue(everything=True)
    code = generate_drive(effects)
    return code._replace(compiled=compiled, module=running(
        code.source, effects, compiled, INLINE, INSIDE, ('load_record', 'simulate')))
