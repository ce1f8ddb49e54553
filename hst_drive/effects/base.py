# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a physical effect declares.

An effect is a plain scalar function and one ``Effect``. The names of the function's arguments
say what it reads (``slots.READABLE``) and which of its own parameters it uses; its ``slot`` says
where the result enters the drive's balances (``slots.SLOTS``). Fit bounds, ROS parameters,
listing, page, documentation and tests follow from the declaration.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
import inspect
import math
from typing import Any, Callable, Collection, Mapping

from hst_drive.effects.slots import READABLE, readable, SLOTS
from hst_drive.units import for_people

_BUILTINS = frozenset({'abs', 'max', 'min'})
FORMULA_ERROR = 0.1     # of what an effect does, by which its formula usually is off machines
_GREATEST = 1e12    # SI: no machine has such a torque or speed
# Powers of a machine's torque, speed and flow in the units whose sizes go with them.
_POWERS = {'N.m': (1, 0, 0), 'rad/s': (0, 1, 0), 'N.m.s/rad': (1, -1, 0),
           'N.m.s^2/rad^2': (1, -2, 0), 'rad/(N.m)': (-1, 0, 0), 'm^3/(s.Pa)': (0, 0, 1),
           'm^3/s': (0, 0, 1), 'm^3': (0, -1, 1), 'Pa.s/m^3': (0, 0, -1),
           'Pa.s^2/m^3': (0, 0, -1), 'Pa.s^2/m^6': (0, 0, -2)}


@dataclass(frozen=True)
class Parameter:
    """
    A parameter of an effect, in SI.

    ``neutral`` switches the effect off; ``low`` and ``high`` bound what is plausible on a real
    machine; ``typical`` is a size at which the effect matters and where a fit may start. A
    ``fixed`` parameter is chosen, not fitted; one of the ``whole_drive`` is fitted there only: in
    logs of a part its values compete as effects of their own. One that ``needs`` a channel is
    fitted only where that is recorded (if it is of the ``whole_drive``, there always), and in a
    part the effect's other ones are then, too.
    ``usual`` are values that the field's formulas have: one of them is taken where the data do
    not ask for another.
    """

    name: str
    unit: str
    low: float
    high: float
    typical: float
    meaning: str
    neutral: float = 0.0
    fixed: bool = False
    whole_drive: bool = False
    needs: str = ''
    usual: tuple[float, ...] = ()

    def scale(self, torque: float, speed: float, flow: float) -> float:
        """Return by what its values grow where torque, speed, flow are so many times as large."""
        of_torque, of_speed, of_flow = _POWERS.get(self.unit, (0, 0, 0))
        return torque**of_torque * speed**of_speed * flow**of_flow

    def sized(self, torque: float, speed: float, flow: float) -> Parameter:
        """Return it for a machine with so many times the drill drive's torque, speed and flow."""
        factor = self.scale(torque, speed, flow)
        return replace(self, low=self.low * factor, high=self.high * factor,
                       typical=self.typical * factor,
                       neutral=self.neutral * factor)

    @property
    def example(self) -> str:
        """What is typical, with its unit, as people write it."""
        value, unit = for_people(self.typical, self.unit)
        return f'{value:.2g}' + (f' {unit}' if unit != '1' else '')

    @property
    def of_any_size(self) -> Parameter:
        """It with the bounds of a machine that may have any torque and speed."""
        if self.unit not in _POWERS:
            return self
        return replace(self, low=-_GREATEST if self.low < 0 else 0.0, high=_GREATEST)

    def recorded_in(self, channels: Collection[str]) -> bool:
        """Say whether the channel that it needs, if any, is there."""
        return not self.needs or self.needs in channels


# How a leak through gaps goes with the oil; of one whose size is that at the usual viscosity.
OIL_POWER = (
    Parameter('oil_power', '1', 0.0, 3.0, 0.0,
              'power of the viscosity by which it falls; 0: it does not follow the oil',
              fixed=True, whole_drive=True),
    Parameter('oil_viscosity_ratio', '1', 1e-3, 1e3, 1.0,
              'viscosity, over that at which the tables were measured, for which its size holds',
              neutral=1.0, fixed=True, whole_drive=True),
)


@dataclass(frozen=True)
class Effect:
    """
    One physical effect that a baseline drive model leaves out.

    Attributes
    ----------
    id : str
        Name in results and rig files.
    title : str
        What it is, for people, without a full stop.
    slot : str
        Where the term enters (``SLOTS``).
    function : callable
        Scalar function of readable quantities and parameters; returns the term in SI.
    equation : str
        The equation as text.
    parameters : tuple of Parameter
        The first is the effect's size: at its neutral value nothing is left of the effect, but
        for parts that have a size of their own (friction in proportion to load, say).
    telltale : str
        One sentence: what the data look like.
    source : str
        Where the equation comes from.
    shows_in : tuple of str
        Channels of which at least one must be recorded for the effect to be seen.
    also : tuple of (str, callable)
        Further terms of the same effect, with the same parameters: slot and function.
    alike : tuple of str
        Effects that differ from this one by no more than formulas do from machines, so that a
        better fit does not tell them apart where it is small.
    formula_error : float
        Share of what it does by which a machine may be off its formula, one standard deviation.
    starts : tuple of dict of str to float
        Parameters from which a fit may start besides the typical ones: where the error has
        several valleys, one of them must lie in each.
    order : str
        Parameter that counts swings per turn of the hydromotor; a diagnosis reads it off the
        recordings.
    swings : callable
        From its parameters (a mapping) and the hydromotor's pistons: how often in a turn it
        swings with the angle of the shaft (0: never), and its parameters without that swing. So
        recordings that begin at different angles are turned into step.
    gauge : str
        What would measure it by itself, for advice where no channel of a drive does.
    searched : str
        Where a diagnosis searches it: 'always', only in logs of a part ('parts'), or 'never'.
    form_of : (str, str), optional
        Another effect and its parameter that can take this one's form: where that is fitted, only
        that effect is searched.
    both_ways : bool
        Whether only logs that turn both ways tell it from what is alike, which comes first.
    kept : bool
        Whether what a pump lacks or a hydromotor takes in (``pump_flow_loss``,
        ``motor_flow_loss``) goes from line to line, so that in a closed circuit it is not lost.
    zero_of : tuple of str
        Channels whose sensor's zero it is, in whatever circuit: with it that zero is not fitted.

    Raises
    ------
    ValueError
        If the declaration does not hold together.

    """

    id: str
    title: str
    slot: str
    function: Callable[..., float]
    equation: str
    parameters: tuple[Parameter, ...]
    telltale: str
    source: str
    shows_in: tuple[str, ...] = ()
    also: tuple[tuple[str, Callable[..., float]], ...] = ()
    alike: tuple[str, ...] = ()
    formula_error: float = FORMULA_ERROR
    starts: tuple[dict[str, float], ...] = ()
    order: str = ''
    swings: Callable[[Mapping[str, float], int], tuple[float, dict[str, float]]] | None = None
    gauge: str = ''
    searched: str = 'always'
    form_of: tuple[str, str] | None = None
    both_ways: bool = False
    kept: bool = False
    zero_of: tuple[str, ...] = ()

    def __post_init__(self):
        if not self.id.isidentifier():
            raise ValueError(f"effect '{self.id}': expected an id of letters, digits and '_'")
        if not self.parameters:
            raise ValueError(f"effect '{self.id}': expected at least one parameter, its size")
        if self.searched not in ('always', 'parts', 'never'):
            raise ValueError(f"effect '{self.id}': searched is {self.searched!r}, expected "
                             "'always', 'parts' or 'never'")
        own = {parameter.name for parameter in self.parameters}
        if own & set(READABLE):
            raise ValueError(f"effect '{self.id}': parameter '{min(own & set(READABLE))}' has the "
                             'name of a readable quantity')
        for slot, function in self.terms:
            if slot not in SLOTS:
                raise ValueError(f"effect '{self.id}': unknown slot '{slot}'; "
                                 f'known: {", ".join(SLOTS)}')
            for name in arguments(function):
                if name not in readable(slot) and name not in own:
                    raise ValueError(
                        f"effect '{self.id}': argument '{name}' is neither a parameter nor known "
                        f"at the slot '{slot}'; there: {', '.join(sorted(readable(slot)))}")
            _refuse_what_cannot_be_compiled(self.id, function)
        for parameter in self.parameters:
            if not parameter.low <= parameter.typical <= parameter.high:
                raise ValueError(f"effect '{self.id}': parameter '{parameter.name}' has its "
                                 'typical value outside its bounds')

    @property
    def enters(self) -> str:
        """Balance that the effect enters."""
        return SLOTS[self.slot].enters

    @property
    def terms(self) -> tuple[tuple[str, Callable[..., float]], ...]:
        """All slots that the effect enters, each with its function."""
        return ((self.slot, self.function), *self.also)

    @property
    def typical(self) -> dict[str, float]:
        """Parameters, SI, at which the effect matters."""
        return {entry.name: entry.typical for entry in self.parameters}

    def sized(self, *sizes: float) -> Effect:
        """Return it for a machine of such sizes (``Rig.sizes``): bounds, typical sizes, starts."""
        return replace(
            self, parameters=tuple(entry.sized(*sizes) for entry in self.parameters),
            starts=tuple({key: value * self.parameter(key).scale(*sizes)
                          for key, value in start.items()} for start in self.starts))

    @property
    def neutral(self) -> dict[str, float]:
        """Parameters, SI, of the effect when it is switched off."""
        return {entry.name: entry.neutral for entry in self.parameters}

    @property
    def own(self) -> tuple[Parameter, ...]:
        """Its parameters but for those that the machine's oil sets (``OIL_POWER``)."""
        return tuple(entry for entry in self.parameters if entry not in OIL_POWER)

    @property
    def size(self) -> Parameter:
        """The parameter of which nothing is left where the effect is off: the first."""
        return self.parameters[0]

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of this name, which there must be."""
        return next(entry for entry in self.parameters if entry.name == name)


@lru_cache(maxsize=None)
def arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    """Return the names of a function's arguments, in order."""
    return tuple(inspect.signature(function).parameters)


def _refuse_what_cannot_be_compiled(name: str, function: Callable[..., Any]) -> None:
    """Raise ValueError unless this is a plain function of arguments, numbers and math."""
    code = getattr(function, '__code__', None)
    if code is None or code.co_name == '<lambda>' or code.co_freevars:
        raise ValueError(f"effect '{name}': expected a plain function, written with 'def' at the "
                         'top of a file')
    for used in code.co_names:
        value = function.__globals__.get(used)
        known = used in _BUILTINS or hasattr(math, used) if value is None else (
            value is math or isinstance(value, (int, float)))
        if not known:
            raise ValueError(f"effect '{name}': its function uses '{used}'; expected arithmetic, "
                             'math, abs, min, max and numbers of its file only')
