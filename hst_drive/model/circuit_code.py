# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""From the file of a circuit and the catalogue of effects to running code."""
from __future__ import annotations

from functools import lru_cache
import inspect
import textwrap
from typing import Callable

from hst_drive.effects import catalogue, edition
from hst_drive.model import kernel_template
from hst_drive.model.circuits import replay_text
from hst_drive.model.circuits.base import Circuit
from hst_drive.model.compiled import compiles, running
from hst_drive.model.compose import Code, generate

_SHARED = ('find', 'interpolate', 'interpolate2', 'smooth_sign', 'played')
_REST = 'p, on, cells, layout'
READINGS = ('pressure_reading', 'flow_reading', 'torque_reading', 'speed_reading_lag')
"""Slots of sensors: what they add is taken from, or added to, the readings of a replay."""


@lru_cache
def text_of(circuit: Circuit) -> str:
    """Return all equations of a circuit as one text, slots for effects in it."""
    states, inputs = len(circuit.states), len(circuit.inputs)
    held = _listed('held', circuit.held)
    arguments = f"{_listed('x', states)}{held}{_listed('now', inputs)}{_REST}"
    rates, first = _listed('slope', states), ''
    if circuit.actuator:
        rates, first = rates.removeprefix('slope[0], '), f"""
            slope[0] = actuator({arguments})
            if not whole:
                return
"""
    wrappers = f"""
        def hold_row(commands, k, interval, memory, {_REST}, held):
            {held} = hold(
                {_listed('commands[k, ', len(circuit.held_inputs), '')}interval, memory, {_REST})


        def evaluate(x, held, now, {_REST}, slope, found, whole):{first}
            {rates}{_listed('found', len(circuit.quantities))} = equations({arguments})
        """
    functions = (*(getattr(kernel_template, name) for name in _SHARED), *circuit.helpers,
                 circuit.hold, *_actuator(circuit), circuit.equations)
    sizes = f'STATES, HELD, QUANTITIES = {states}, {circuit.held}, {len(circuit.quantities)}'
    return '\n\n'.join(['import math', sizes, *map(inspect.getsource, functions),
                        textwrap.dedent(wrappers), inspect.getsource(replay_text.weigh),
                        inspect.getsource(replay_text.run)])


def _actuator(circuit: Circuit) -> tuple[Callable, ...]:
    return (circuit.actuator,) if circuit.actuator else ()


def _listed(name: str, count: int, opened: str = '[') -> str:
    """Return ``name[0], name[1], `` and so on."""
    return ''.join(f'{name}{opened}{index}], ' for index in range(count))


def code_of(circuit: Circuit, names: tuple[str, ...], compiled: bool | None = None) -> Code:
    """
    Return the code of a circuit for all effects of the catalogue.

    Parameters
    ----------
    circuit : Circuit
        The declaration.
    names : tuple of str
        Its parameters, in order.
    compiled : bool, optional
        As for ``compose.kernel``.

    """
    if compiled is None:
        compiled = compiles()
    return _code(circuit.id, text_of(circuit), (names, tuple(circuit.tables)),
                 tuple(function.__name__ for function in (*circuit.helpers, *_actuator(circuit))),
                 compiled, edition())


@lru_cache(maxsize=8)
def _code(_: str, text: str, layout: tuple, helpers: tuple[str, ...], compiled: bool,
          __: int) -> Code:
    effects = catalogue(everything=True)
    code = generate(effects, text, *layout)
    read = {name for name, effect in effects.items() if effect.slot in READINGS}
    module = running(code.source, effects, compiled,
                     ('interpolate', 'interpolate2', 'smooth_sign', *helpers, 'hold',
                      'hold_row', 'equations', 'evaluate'), ('find', 'played', 'weigh'), ('run',))
    return code._replace(usable=code.usable | read, module=module, compiled=compiled)
