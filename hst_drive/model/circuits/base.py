# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a circuit declares: states, inputs, equations, and the balances that logs can close.

A circuit is one file. Its two functions, ``hold`` (once a row) and ``equations``, are plain text
for numbers: ``circuit_code`` puts effects into their ``# slot`` lines and makes running code. A
simulation integrates the states; a replay puts measured signals in the place of the states that
they tell, and what the equations then say of other signals is compared with those.
"""
from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, Callable, Container, NamedTuple

from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.rig import Curve, Rig, Surface

OF_A_FLOW = 0.0015  # beside the unit's own displacements: how their curves differ
OF_A_LEAK = 0.04    # no sheet tells: its table is of one temperature, and of one unit's gaps


class State(NamedTuple):
    """
    A state: channel that tells it, SI unit, parameter with which a drive at rest starts.

    It does not fall below ``least``; there the equations let it rise only. Without an effect in
    the slot ``moved_by`` it stays where it starts.
    """

    name: str
    unit: str
    start: str = ''
    moved_by: str = ''
    least: float = -math.inf


class Input(NamedTuple):
    """An input by channel, and what stands in its place where it is not recorded (SI)."""

    name: str
    default: float = 0.0


class Part(NamedTuple):
    """
    One way to predict a signal: a quantity, less ``storage`` times the rate of a measured state.

    And less the rate of the quantity ``turns``. It counts where the quantity ``when`` is at least
    1 (always, without one).
    """

    quantity: str
    when: str = ''
    state: str = ''
    storage: str = ''
    turns: str = ''


class Balance(NamedTuple):
    """
    A balance that signals may close.

    ``signal`` is what it predicts from the channels ``needs`` ('a|b': either); ``enters`` and
    ``place`` say what is missing where it does not close, ``sign`` times the signal's error, per
    displacement of the hydromotor where ``swept``; ``formula`` which formula can carry it. ``id``
    is the word by which it is watched while the drive runs ('' of the open circuit: it is not).

    It predicts by its ``parts``, or by an ``equation`` of the open circuit's parts. Of that
    ``rig`` are the numbers that the rig file must give, and ``without`` channels that make another
    balance the better one. ``sheet`` is the share of the signal's usual size that no maker's sheet
    tells: of leakage far more than of a flow (ISO 4409, measurement class A: 0.5 %).
    """

    name: str
    signal: str
    enters: str
    place: str
    parts: tuple[Part, ...] = ()
    needs: tuple[str, ...] = ()
    formula: str = ''
    sheet: float = 0.003
    id: str = ''
    equation: Callable[..., Any] | None = None
    rig: tuple[str, ...] = ()
    sign: float = 1.0
    swept: bool = False
    without: tuple[str, ...] = ()

    @property
    def conditions(self) -> tuple[str, ...]:
        """Quantities of which one must be at least 1; none where a part always counts."""
        needed = tuple(part.when for part in self.parts)
        return needed if all(needed) else ()

    @property
    def unit(self) -> str:
        """SI unit of what is missing."""
        return 'm^3/s' if self.swept else CHANNELS[self.groups[0][0]].unit

    @property
    def groups(self) -> tuple[list[str], ...]:
        """Alternatives of the signal and of each channel that it needs."""
        return tuple(entry.split('|') for entry in (self.signal, *self.needs))

    @property
    def untold(self) -> float:
        """What of ``sheet`` the unit's own factors do not tell either."""
        # Of other curves an open circuit has factors, of its leakage one alone.
        return self.sheet if self.sheet == OF_A_LEAK or not self.equation else 0.0

    def channels(self, present: Container[str]) -> tuple[str, ...]:
        """Return what it goes by: those of its alternatives that are present, the signal first."""
        return tuple(dict.fromkeys(
            name for group in self.groups for name in group if name in present))


@dataclass(frozen=True, eq=False)
class Circuit:
    """
    A hydraulic circuit.

    Attributes
    ----------
    id, title : str
        Word in the rig file, and for people.
    hold : callable
        ``hold(*held_inputs, interval, memory, p, on, cells, layout)``: once a row; what it
        returns holds until the next one. ``memory`` (NaN at first) is its own.
    equations : callable
        ``equations(*states, *held, *inputs, p, on, cells, layout)``: rates of the states, then
        the quantities. ``P_name`` is the place of a parameter, ``T_NAME`` the number of a table.
    actuator : callable, optional
        With the same arguments: the rate of the first state, which ``equations`` then leaves out.
        Where all other states are measured, nothing else is worked out between rows.
    helpers : tuple of callable
        Functions that they call, beside those of the open circuit's text (``interpolate``, ...).
    numbers : callable
        Parameters from a rig, SI.
    tables : dict of str to callable
        Tables from a rig.
    scaled : dict of str to str
        What a unit may differ in (``rig.tolerances``): the parameter that it scales.
    sections, keys : tuple of str
        What the rig file must have.
    states, held_inputs, inputs, quantities, balances : tuple
        As above; what ``hold`` returns is named by the arguments between states and inputs.
    steps : callable
        From the numbers: the longest integration step (s) that the equations bear, and the one
        where all states that are measured are told.
    complete : callable, optional
        From a rig and channels: channels that go with those that are there.
    memory : int
        Numbers that ``hold`` keeps.

    """

    id: str
    title: str
    hold: Callable
    equations: Callable
    numbers: Callable[[Rig], dict[str, float]]
    sections: tuple[str, ...]
    states: tuple[State, ...]
    held_inputs: tuple[Input, ...]
    inputs: tuple[Input, ...]
    quantities: tuple[str, ...]
    balances: tuple[Balance, ...]
    tables: dict[str, Callable[[Rig], Curve | Surface]]
    scaled: dict[str, str]
    steps: Callable[[dict[str, float]], tuple[float, float]]
    keys: tuple[str, ...] = ()
    actuator: Callable | None = None
    complete: Callable[[Rig, dict], dict] | None = None
    helpers: tuple[Callable, ...] = ()
    memory: int = 4

    @property
    def held(self) -> int:
        """How many numbers ``hold`` returns."""
        arguments = self.equations.__code__.co_argcount
        return arguments - len(self.states) - len(self.inputs) - 4

    def parameters(self, rig: Rig) -> dict[str, float]:
        """
        Return the numbers of the equations, this unit's calibration included.

        Raises
        ------
        InputError
            If a section of the rig file is missing.

        """
        for name in self.sections:
            if getattr(rig, name) is None:
                raise InputError(f"{rig.source}: section '{name}' is missing; 'circuit: "
                                 f"{self.id}' needs it; add it to the rig file")
        for key in self.keys:
            section, _, name = key.partition('.')
            if name not in getattr(rig, section).given:
                raise InputError(f"{rig.source}: key '{key}' is missing; 'circuit: {self.id}' "
                                 'needs it; add it')
        found = self.numbers(rig)
        for key, factor in rig.calibration.items():
            if key in self.scaled:
                found[self.scaled[key]] *= factor
        return {name: float(value) for name, value in found.items()}
