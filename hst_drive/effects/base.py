# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a physical effect declares.

An effect is a plain scalar function and one ``Effect``. The names of the function's arguments
say what it reads (``READABLE``) and which of its own parameters it uses; its ``slot`` says
where the result enters the drive's balances (``SLOTS``). Fit bounds, ROS parameters, listing,
page, documentation and tests follow from the declaration.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
import inspect
import math
from typing import Any, Callable, Collection, Mapping, NamedTuple


class Slot(NamedTuple):
    """A place in the equations: balance it belongs to, unit of the term, what the term does."""

    enters: str
    unit: str
    meaning: str


DRILLING_SPEED = 10.0   # rad/s: about where a drill works, so that size and shape are told apart
USUAL_DAMPING_TIME = 0.002  # s, material damping of a flexible shaft unless an effect moves it
USUAL_SHARE = 0.35      # of the inertia lies behind a flexible shaft unless an effect moves it
USUAL_FAR = 0.5         # of the line's volume lies behind the mass of its oil, unless moved
USUAL_UPSTREAM = 0.3    # of the line's volume lies before its resistance unless an effect moves it

SLOTS: dict[str, Slot] = {
    'pump_command': Slot('pump actuator', 'V', 'added to the pump command'),
    'pump_play': Slot('pump actuator', 'V', 'width of the play between command and swash plate'),
    'pump_play_softness': Slot('pump actuator', '1', 'how softly that play takes hold'),
    'pump_play_spread': Slot('pump actuator', '1', 'how far two halves of that play differ'),
    'pump_lag': Slot('pump actuator', 's', 'added to the displacement lag'),
    'pump_series_lag': Slot('pump actuator', 's', 'lag in series with that of the displacement'),
    'pump_stroke_time': Slot('pump actuator', 's', 'shortest time for the full stroke'),
    'pump_stroke_asymmetry': Slot('pump actuator', '1', 'how much faster up than on average'),
    'pump_yield': Slot('pump actuator', 'm^3/rad', 'taken from the displacement that the command '
                       'asks for'),
    'valve_command': Slot('pump actuator', 'V', 'added to the command of the valve'),
    'valve_lag': Slot('pump actuator', 's', "added to the valve's lag"),
    'pump_speed': Slot('flow', 'rad/s', 'added to the pump shaft speed'),
    'pump_speed_lag': Slot('flow', 's', 'first-order lag of that change'),
    'pump_flow_loss': Slot('flow', 'm^3/s', 'lost between pump and flow meter'),
    'charge_wear': Slot('flow', '1', "share of the charge pump's delivery that leaks at the "
                        "relief's pressure"),
    'one_line': Slot('flow', '1', 'where compressibility is added: 1 in line A, -1 in line B, '
                     '0 in both'),
    'pump_torque_loss': Slot('torque', 'N.m', 'torque at the pump shaft beyond its sheet'),
    'motor_flow_loss': Slot('flow', 'm^3/s', 'lost in the hydromotor, behind the flow meter'),
    'cross_port_flow': Slot('flow', 'm^3/s', 'passes from the high line to the low one'),
    'charge_pressure': Slot('flow', 'Pa', 'taken from the pressure of the charge relief'),
    'compliance': Slot('flow', '1/Pa', 'added to the compressibility of the oil'),
    'line_inertance': Slot('flow', 'Pa.s^2/m^3', "mass of the line's oil over its area squared"),
    'line_far_share': Slot('flow', '1', f"added to the share of the line's volume ({USUAL_FAR}) "
                           'that lies behind that mass'),
    'line_damping': Slot('flow', '1/s', 'decay of what moves in the line by itself'),
    'line_drop': Slot('torque', 'Pa', 'pressure lost between pump outlet and hydromotor inlet'),
    'line_upstream_share': Slot('torque', '1', 'added to the share of the oil in the line '
                                f'({USUAL_UPSTREAM}) that lies before its resistance'),
    'back_pressure': Slot('torque', 'Pa', 'pressure at the hydromotor outlet'),
    'motor_torque_loss': Slot('torque', 'N.m', 'torque that opposes the hydromotor rotation'),
    'motor_torque': Slot('torque', 'N.m', 'torque added to the hydromotor, of either sign'),
    'gear_twist': Slot('torque', 'rad/(N.m)', 'turn of the hydromotor against the shaft behind '
                       'its gear, per torque'),
    'gear_angle': Slot('torque', 'rad', 'turn of the hydromotor against that shaft'),
    'shaft_compliance': Slot('torque', 'rad/(N.m)', 'twist of the shaft per torque'),
    'shaft_load_share': Slot('torque', '1', f'added to the share of the inertia ({USUAL_SHARE}) '
                             'that lies behind a flexible shaft'),
    'shaft_damping_time': Slot('torque', 's', 'added to the damping of a flexible shaft over its '
                               f'stiffness ({USUAL_DAMPING_TIME} s)'),
    'load_torque': Slot('load', 'N.m', 'load torque beyond what the loading unit explains'),
    'pressure_reading': Slot('sensor', 'Pa', 'added to the pressure reading'),
    'flow_reading': Slot('sensor', 'm^3/s', 'added to the flow reading'),
    'speed_reading': Slot('sensor', 'rad/s', 'added to the speed reading'),
    'speed_reading_lag': Slot('sensor', 's', 'first-order lag of the speed reading'),
    'speed_reading_series_lag': Slot('sensor', 's', 'lag in series with that of the reading'),
    'torque_reading': Slot('sensor', 'N.m', 'added to the torque reading'),
}

# Places where oil leaves a line.
LEAKS = ('pump_flow_loss', 'motor_flow_loss')
# Places that the open circuit has not.
OF_OTHER_CIRCUITS = frozenset({'cross_port_flow', 'charge_pressure', 'charge_wear', 'one_line',
                               'gear_twist', 'gear_angle', 'valve_command', 'valve_lag'})

# What an effect may read: name -> unit. Constants of the rig stand beside signals.
READABLE: dict[str, str] = {
    'displacement': 'm^3/rad', 'pump_speed': 'rad/s', 'pump_pressure': 'Pa', 'pressure': 'Pa',
    'motor_speed': 'rad/s', 'motor_angle': 'rad', 'pump_command': 'V', 'pprv_command': 'V',
    'oil_temperature': 'K', 'viscosity_ratio': '1', 'load_torque': 'N.m', 'flow': 'm^3/s',
    'twist': 'rad', 'pump_leakage': 'm^3/s', 'motor_leakage': 'm^3/s',
    'motor_displacement': 'm^3/rad', 'efficiency': '1',
    'max_displacement': 'm^3/rad', 'line_volume': 'm^3', 'bulk_modulus': 'Pa',
    'oil_density': 'kg/m^3', 'relief_pressure': 'Pa', 'pistons': '1', 'characterised_at': 'K',
    'nominal_speed': 'rad/s', 'rated_pressure': 'Pa', 'cross_port_pressure': 'Pa',
    'valve_command': 'V',
}

# What is known where a slot lies: the equations are evaluated in order.
_COMMANDS = frozenset({'displacement', 'pump_pressure', 'motor_speed', 'motor_angle',
                       'pump_command', 'pprv_command', 'oil_temperature', 'viscosity_ratio',
                       'nominal_speed', 'max_displacement'})
_BALANCES = frozenset(READABLE) - {'pump_speed', 'load_torque', 'twist', 'efficiency',
                                   'valve_command'}
_KNOWN: dict[str, frozenset[str]] = {
    'line_drop': _BALANCES, 'motor_flow_loss': _BALANCES, 'pump_speed': _BALANCES,
    'pump_flow_loss': _BALANCES | {'pump_speed'}, 'compliance': _BALANCES | {'pump_speed'},
    'back_pressure': _BALANCES | {'pump_speed'},
    'cross_port_flow': _BALANCES | {'pump_speed'},
    'charge_pressure': frozenset({'pump_speed', 'oil_temperature', 'viscosity_ratio'}),
    'gear_twist': frozenset({'pressure', 'motor_displacement'}),
    'gear_angle': frozenset({'load_torque'}),
    **dict.fromkeys(('charge_wear', 'one_line'), frozenset()),
    **dict.fromkeys(('valve_command', 'valve_lag'), frozenset({'valve_command'})),
    'pump_torque_loss': _COMMANDS | {'pump_speed'},
    'motor_torque_loss': frozenset(READABLE), 'motor_torque': frozenset(READABLE),
    **dict.fromkeys(('shaft_compliance', 'shaft_damping_time'), frozenset({'twist'})),
    **dict.fromkeys(('shaft_load_share', 'line_inertance', 'line_far_share', 'line_damping'),
                    frozenset()),
    'load_torque': frozenset({'load_torque', 'motor_speed', 'motor_angle', 'pprv_command',
                              'oil_temperature', 'pistons'}),
    'torque_reading': frozenset({'load_torque', 'motor_angle', 'oil_temperature'}),
    **dict.fromkeys(('pressure_reading', 'flow_reading', 'speed_reading'),
                    _COMMANDS | {'pressure', 'flow', 'load_torque', 'pump_speed'}),
}
_BUILTINS = frozenset({'abs', 'max', 'min'})
_GREATEST = 1e12    # SI: no machine has such a torque or speed
# Powers of a machine's torque, speed and flow in the units whose sizes go with them.
_POWERS = {'N.m': (1, 0, 0), 'rad/s': (0, 1, 0), 'N.m.s/rad': (1, -1, 0),
           'N.m.s^2/rad^2': (1, -2, 0), 'm^3/(s.Pa)': (0, 0, 1), 'Pa.s/m^3': (0, 0, -1),
           'Pa.s^2/m^6': (0, 0, -2)}


def readable(slot: str) -> frozenset[str]:
    """Return the names of ``READABLE`` that are known where a slot lies."""
    return _KNOWN.get(slot, _COMMANDS)


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

    def sized(self, torque: float, speed: float, flow: float = 1.0) -> Parameter:
        """Return it for a machine with so many times the drill drive's torque, speed and flow."""
        of_torque, of_speed, of_flow = _POWERS.get(self.unit, (0, 0, 0))
        factor = torque**of_torque * speed**of_speed * flow**of_flow
        return replace(self, low=self.low * factor, high=self.high * factor,
                       typical=self.typical * factor,
                       neutral=self.neutral * factor)

    @property
    def of_any_size(self) -> Parameter:
        """It with the bounds of a machine that may have any torque and speed."""
        if self.unit not in _POWERS:
            return self
        return replace(self, low=-_GREATEST if self.low < 0 else 0.0, high=_GREATEST)

    def recorded_in(self, channels: Collection[str]) -> bool:
        """Say whether the channel that it needs, if any, is there."""
        return not self.needs or self.needs in channels


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
        Share of what it does by which a machine may be off its formula, where effects that are
        alike are to be told apart.
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
        Where a diagnosis searches it: 'always', only in logs of a part ('parts': elsewhere another
        effect can take its form, and it is tried in that one's place), or 'never'.
    form_of : (str, str), optional
        Another effect and its parameter that can take this one's form: where that is fitted, only
        that effect is searched.
    both_ways : bool
        Whether only logs that turn both ways tell it from what is alike, which comes first.
    kept : bool
        Whether what the delivery lacks (``pump_flow_loss``) is not taken in either, so that in a
        closed circuit it is not lost.

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
    formula_error: float = 0.18
    starts: tuple[dict[str, float], ...] = ()
    order: str = ''
    swings: Callable[[Mapping[str, float], int], tuple[float, dict[str, float]]] | None = None
    gauge: str = ''
    searched: str = 'always'
    form_of: tuple[str, str] | None = None
    both_ways: bool = False
    kept: bool = False

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

    @property
    def neutral(self) -> dict[str, float]:
        """Parameters, SI, of the effect when it is switched off."""
        return {entry.name: entry.neutral for entry in self.parameters}

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of this name, which there must be."""
        return next(entry for entry in self.parameters if entry.name == name)


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
