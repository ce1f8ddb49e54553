# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A formula of three terms in place of an effect that has no name yet.

A diagnosis that ends with 'unknown' describes what is missing by such a formula; these carry it
into the drive. They are not searched and not listed: they explain nothing.
"""
import math
from typing import Iterable, Sequence

from hst_drive.effects.base import Effect, Parameter

PRESSURE = 1e7          # Pa
SPEED = 10.0            # rad/s
WARMTH = 10.0           # K
REFERENCE = 323.15      # K
TORQUE = 100.0          # N.m
FLOW = 1e-4             # m^3/s
TERMS = 3
# Variable of a formula, and how it is written.
TEXTS = {'pressure': '(pressure / 100 bar)', 'speed': '(motor_speed / 10 rad/s)',
         'warmth': '((oil_temperature - 50 degC) / 10 K)', 'pump': '(pump_command / 1 V)',
         'pprv': '(pprv_command / 1 V)', 'torque': '(load_torque / 100 N.m)',
         'flow': '(flow / 6 L/min)',
         'cosine': 'cos(motor_angle)', 'sine': 'sin(motor_angle)',
         'forwards': '(1 forwards, else 0)', 'backwards': '(1 backwards, else 0)',
         'line_a': '(1 with line A high, else 0)', 'line_b': '(1 with line B high, else 0)'}


def product(pressure, motor_speed, oil_temperature, pump_command, pprv_command, motor_angle,
            coefficient_1, pressure_1, speed_1, warmth_1, pump_1, pprv_1,
            cosine_1, sine_1, forwards_1, backwards_1,
            coefficient_2, pressure_2, speed_2, warmth_2, pump_2, pprv_2,
            cosine_2, sine_2, forwards_2, backwards_2,
            coefficient_3, pressure_3, speed_3, warmth_3, pump_3, pprv_3,
            cosine_3, sine_3, forwards_3, backwards_3):
    """Return the sum of three coefficients times powers of the balances' variables."""
    pressure = pressure / PRESSURE
    speed = motor_speed / SPEED
    warmth = (oil_temperature - REFERENCE) / WARMTH
    cosine = math.cos(motor_angle)
    sine = math.sin(motor_angle)
    forwards = 0.5 + 0.5 * math.copysign(1.0, motor_speed)
    return (coefficient_1 * pressure**pressure_1 * speed**speed_1 * warmth**warmth_1
            * pump_command**pump_1 * pprv_command**pprv_1 * cosine**cosine_1
            * sine**sine_1 * forwards**forwards_1 * (1.0 - forwards)**backwards_1
            + coefficient_2 * pressure**pressure_2 * speed**speed_2 * warmth**warmth_2
            * pump_command**pump_2 * pprv_command**pprv_2 * cosine**cosine_2
            * sine**sine_2 * forwards**forwards_2 * (1.0 - forwards)**backwards_2
            + coefficient_3 * pressure**pressure_3 * speed**speed_3 * warmth**warmth_3
            * pump_command**pump_3 * pprv_command**pprv_3 * cosine**cosine_3
            * sine**sine_3 * forwards**forwards_3 * (1.0 - forwards)**backwards_3)


def loss(pressure, motor_speed, oil_temperature, pump_command, pprv_command, motor_angle,
         high_line, coefficient_1, pressure_1, speed_1, warmth_1, pump_1, pprv_1,
         cosine_1, sine_1, line_a_1, line_b_1,
         coefficient_2, pressure_2, speed_2, warmth_2, pump_2, pprv_2,
         cosine_2, sine_2, line_a_2, line_b_2,
         coefficient_3, pressure_3, speed_3, warmth_3, pump_3, pprv_3,
         cosine_3, sine_3, line_a_3, line_b_3):
    """Return what ``product`` returns with the other sign: flow that is lost, not gained."""
    pressure = pressure / PRESSURE
    speed = motor_speed / SPEED
    warmth = (oil_temperature - REFERENCE) / WARMTH
    cosine = math.cos(motor_angle)
    sine = math.sin(motor_angle)
    line_a = 0.5 + 0.5 * high_line
    return -(coefficient_1 * pressure**pressure_1 * speed**speed_1 * warmth**warmth_1
             * pump_command**pump_1 * pprv_command**pprv_1 * cosine**cosine_1
             * sine**sine_1 * line_a**line_a_1 * (1.0 - line_a)**line_b_1
             + coefficient_2 * pressure**pressure_2 * speed**speed_2 * warmth**warmth_2
             * pump_command**pump_2 * pprv_command**pprv_2 * cosine**cosine_2
             * sine**sine_2 * line_a**line_a_2 * (1.0 - line_a)**line_b_2
             + coefficient_3 * pressure**pressure_3 * speed**speed_3 * warmth**warmth_3
             * pump_command**pump_3 * pprv_command**pprv_3 * cosine**cosine_3
             * sine**sine_3 * line_a**line_a_3 * (1.0 - line_a)**line_b_3)


def load(load_torque, motor_speed, oil_temperature, pprv_command, motor_angle,
         coefficient_1, torque_1, speed_1, warmth_1, pprv_1, cosine_1, sine_1,
         coefficient_2, torque_2, speed_2, warmth_2, pprv_2, cosine_2, sine_2,
         coefficient_3, torque_3, speed_3, warmth_3, pprv_3, cosine_3, sine_3):
    """Return the sum of three coefficients times powers of what the load may depend on."""
    torque = load_torque / TORQUE
    speed = abs(motor_speed) / SPEED
    warmth = (oil_temperature - REFERENCE) / WARMTH
    cosine = math.cos(motor_angle)
    sine = math.sin(motor_angle)
    return (coefficient_1 * torque**torque_1 * speed**speed_1 * warmth**warmth_1
            * pprv_command**pprv_1 * cosine**cosine_1 * sine**sine_1
            + coefficient_2 * torque**torque_2 * speed**speed_2 * warmth**warmth_2
            * pprv_command**pprv_2 * cosine**cosine_2 * sine**sine_2
            + coefficient_3 * torque**torque_3 * speed**speed_3 * warmth**warmth_3
            * pprv_command**pprv_3 * cosine**cosine_3 * sine**sine_3)


def flow_error(flow, pressure, oil_temperature,
               coefficient_1, flow_1, pressure_1, warmth_1,
               coefficient_2, flow_2, pressure_2, warmth_2,
               coefficient_3, flow_3, pressure_3, warmth_3):
    """Return the sum of three coefficients times powers of what a flow meter may depend on."""
    flow = flow / FLOW
    pressure = pressure / PRESSURE
    warmth = (oil_temperature - REFERENCE) / WARMTH
    return (coefficient_1 * flow**flow_1 * pressure**pressure_1 * warmth**warmth_1
            + coefficient_2 * flow**flow_2 * pressure**pressure_2 * warmth**warmth_2
            + coefficient_3 * flow**flow_3 * pressure**pressure_3 * warmth**warmth_3)


def torque_error(load_torque, oil_temperature,
                 coefficient_1, torque_1, warmth_1, coefficient_2, torque_2, warmth_2,
                 coefficient_3, torque_3, warmth_3):
    """Return the sum of three coefficients times powers of what a torque sensor may depend on."""
    torque = load_torque / TORQUE
    warmth = (oil_temperature - REFERENCE) / WARMTH
    return (coefficient_1 * torque**torque_1 * warmth**warmth_1
            + coefficient_2 * torque**torque_2 * warmth**warmth_2
            + coefficient_3 * torque**torque_3 * warmth**warmth_3)


def speed_error(motor_speed, oil_temperature,
                coefficient_1, speed_1, warmth_1, coefficient_2, speed_2, warmth_2,
                coefficient_3, speed_3, warmth_3):
    """Return the sum of three coefficients times powers of what a tachometer may depend on."""
    speed = motor_speed / SPEED
    warmth = (oil_temperature - REFERENCE) / WARMTH
    return (coefficient_1 * speed**speed_1 * warmth**warmth_1
            + coefficient_2 * speed**speed_2 * warmth**warmth_2
            + coefficient_3 * speed**speed_3 * warmth**warmth_3)


_BALANCE = ('pressure', 'speed', 'warmth', 'pump', 'pprv', 'cosine', 'sine')
_TORQUE, _FLOW = (*_BALANCE, 'forwards', 'backwards'), (*_BALANCE, 'line_a', 'line_b')
_LOAD = ('torque', 'speed', 'warmth', 'pprv', 'cosine', 'sine')
# Effect -> variables of its formula.
VARIABLES = {'formula_load': _LOAD, 'formula_torque': _TORQUE, 'formula_motor_flow': _FLOW,
             'formula_pump_flow': _FLOW, 'formula_pressure_reading': _TORQUE,
             'formula_flow_reading': ('flow', 'pressure', 'warmth'),
             'formula_torque_reading': ('torque', 'warmth'),
             'formula_speed_reading': ('speed', 'warmth')}


def _swings(values, pistons):
    """Return 1 if a term goes with the angle of the shaft, 0 if none, and what is left then."""
    still = dict(values)
    for term in range(1, TERMS + 1):
        if any(values.get(f'{wave}_{term}') for wave in ('cosine', 'sine')):
            still[f'coefficient_{term}'] = 0.0
    return float(still != dict(values)), still


def _declare(name: str, title: str, slot: str, function, unit: str, typical: float) -> Effect:
    parameters = []
    for term in range(1, TERMS + 1):
        parameters.append(Parameter(f'coefficient_{term}', unit, -1e6 * typical, 1e6 * typical,
                                    typical, f'coefficient of term {term}'))
        parameters += [Parameter(f'{variable}_{term}', '1', 0.0, 4.0, 0.0,
                                 f'power of {TEXTS[variable]} in term {term}', fixed=True)
                       for variable in VARIABLES[name]]
    factors = ' * '.join(f'{TEXTS[variable]}^{variable}_i' for variable in VARIABLES[name])
    return Effect(name, title, slot, function,
                  f'sum over i = 1..{TERMS} of coefficient_i * {factors}', tuple(parameters),
                  'Whatever a diagnosis left unexplained there.',
                  'Fitted to the recordings: a description, not physics.', swings=_swings,
                  searched='never')


FORMULAS: dict[str, Effect] = {effect.id: effect for effect in (
    _declare('formula_load', 'a formula for the load that no listed effect explains',
             'load_torque', load, 'N.m', 1.0),
    _declare('formula_torque', 'a formula for torque that no listed effect explains',
             'motor_torque', product, 'N.m', 1.0),
    _declare('formula_motor_flow', 'a formula for oil that turns the hydromotor or is lost there',
             'motor_flow_loss', loss, 'm^3/s', 1e-6),
    _declare('formula_pump_flow', 'a formula for oil that the pump delivers or loses',
             'pump_flow_loss', loss, 'm^3/s', 1e-6),
    _declare('formula_pressure_reading', 'a formula for what is wrong with the pressure reading',
             'pressure_reading', product, 'Pa', 1e5),
    _declare('formula_flow_reading', 'a formula for what is wrong with the flow reading',
             'flow_reading', flow_error, 'm^3/s', 1e-6),
    _declare('formula_torque_reading', 'a formula for what is wrong with the torque reading',
             'torque_reading', torque_error, 'N.m', 1.0),
    _declare('formula_speed_reading', 'a formula for what is wrong with the speed reading',
             'speed_reading', speed_error, 'rad/s', 0.1),
)}


def written(what: str, terms: Iterable[tuple[float, Sequence[str]]]) -> str:
    """Return a formula as text: what it adds to, and its terms' coefficients and factors."""
    texts = (' * '.join([f'{coefficient:.3g}', *factors]) for coefficient, factors in terms)
    return f'{what} += {" + ".join(texts)}'.replace('+ -', '- ')


def values(name: str, terms) -> dict[str, float]:
    """
    Return the parameters of a formula.

    Parameters
    ----------
    name : str
        Key of ``FORMULAS``.
    terms : sequence of (float, sequence of str)
        Coefficient (SI) and variables, each as often as its power.

    """
    found = {entry.name: 0.0 for entry in FORMULAS[name].parameters}
    for number, (coefficient, variables) in enumerate(terms, 1):
        found[f'coefficient_{number}'] = float(coefficient)
        for variable in variables:
            found[f'{variable}_{number}'] += 1.0
    return found
