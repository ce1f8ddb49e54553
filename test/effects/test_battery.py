# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What every effect must be: one battery over the whole catalogue."""
import types

from hst_drive.channels import CHANNELS
from hst_drive.effects import catalogue, origin, READABLE, readable, SLOTS
from hst_drive.effects.base import arguments, Effect, Parameter
from hypothesis import given, settings, strategies as st
import numpy as np
import pint
import pytest

CONTRACT = (
    'leakage_temperature elastic_leakage pump_leakage motor_leakage entrained_air '
    'compressibility_flow prv_cracking pump_speed_droop pump_command_offset pump_hysteresis '
    'pump_rate_limit pump_lag bearing_friction stribeck_friction viscous_drag hydrodynamic_drag '
    'line_loss back_pressure piston_ripple shaft_compliance gearbox_loss pressure_sensor_bias '
    'speed_sensor_lag torque_sensor_scale flow_sensor_scale constant_torque '
    'motor_orifice_leakage suction_starvation swash_compliance accumulator '
    'line_inertance gear_backlash charge_pressure_loss cross_port_leakage '
    'cross_port_relief_cracking valve_dead_band valve_lag').split()
BEYOND = ['pump_friction', 'pump_orifice_leakage']
OWN = {name: effect for name, effect in catalogue().items() if origin(name) == 'hst_drive'}
TERMS = [pytest.param(effect, slot, function, id=f'{name}-{slot}')
         for name, effect in OWN.items() for slot, function in effect.terms]
LOSSES = {'pump_flow_loss', 'motor_flow_loss', 'motor_torque_loss', 'line_drop', 'back_pressure',
          'pump_torque_loss'}
# Numbers in the files that have a dimension.
CONSTANTS = {'ATMOSPHERE': 'Pa', 'LEAST': 'Pa', 'REFERENCE': 'Pa', 'USUAL_DAMPING_TIME': 's',
             'DRILLING_SPEED': 'rad/s', 'SMOOTH': 'V', 'FULL': 'V'}
# Beyond what a drive reaches, in the units of READABLE.
RANGES = {
    'displacement': (0.0, 1e-4), 'pump_speed': (1.0, 400.0), 'pump_pressure': (-9e4, 6e7),
    'pressure': (-9e4, 6e7), 'motor_speed': (-200.0, 200.0), 'motor_angle': (-1e5, 1e5),
    'pump_command': (-10.0, 10.0), 'pprv_command': (0.0, 10.0),
    'oil_temperature': (250.0, 400.0), 'viscosity_ratio': (0.05, 60.0),
    'load_torque': (0.0, 1e5), 'flow': (-1e-2, 1e-2), 'pump_leakage': (0.0, 1e-3),
    'motor_leakage': (0.0, 1e-3), 'motor_displacement': (1e-7, 1e-2),
    'max_displacement': (1e-7, 1e-4), 'line_volume': (1e-7, 10.0), 'bulk_modulus': (2e8, 2e9),
    'oil_density': (700.0, 1000.0),
    'relief_pressure': (5e6, 4e7), 'pistons': (3.0, 15.0), 'characterised_at': (273.0, 373.0),
    'nominal_speed': (50.0, 400.0), 'rated_pressure': (5e6, 4e7),
    'cross_port_pressure': (5e6, 5e7), 'valve_command': (-10.0, 10.0),
    'twist': (-1.0, 1.0), 'high_line': (-1.0, 1.0),
}
PINT = pint.UnitRegistry()


def unit(text):
    """Return a unit as pint spells it."""
    return PINT.Unit('' if text == '1' else text.replace('.', '*'))


def evaluate(function, parameters, reads):
    """Call a term with what it asks for."""
    return function(*(parameters.get(name, reads.get(name)) for name in arguments(function)))


readings = st.fixed_dictionaries({name: st.floats(*ends) for name, ends in RANGES.items()})


def sizes(effect):
    """Return parameters within their bounds."""
    return st.fixed_dictionaries({entry.name: st.floats(entry.low, entry.high)
                                  for entry in effect.parameters})


def test_the_ids_are_the_contract():
    """No id is missing, and what is beyond the list is known."""
    assert sorted(OWN) == sorted(CONTRACT + BEYOND)
    assert all(name == effect.id for name, effect in OWN.items())


@pytest.mark.parametrize('effect', OWN.values(), ids=OWN)
def test_declaration_says_all(effect):
    """Texts are there, bounds are in order, and the channels exist."""
    for text in (effect.title, effect.equation, effect.telltale, effect.source):
        assert text.strip() == text and len(text) > 10
    assert effect.telltale.endswith('.') and not effect.title.endswith('.')
    assert any(digit.isdigit() for digit in effect.source)
    assert effect.shows_in and set(effect.shows_in) <= set(CHANNELS)
    assert 1 <= sum(not entry.fixed for entry in effect.parameters) <= 4
    for entry in effect.parameters:
        assert entry.meaning and entry.low <= entry.neutral <= entry.high
        assert entry.low < entry.typical < entry.high or entry.typical == entry.neutral
        assert entry.name in effect.equation or effect.slot.endswith('lag')
    assert effect.parameters[0].neutral == 0.0 != effect.parameters[0].typical
    used = {name for _, function in effect.terms for name in arguments(function)}
    assert {entry.name for entry in effect.parameters} <= used


@pytest.mark.parametrize('effect, slot, function', TERMS)
def test_dimensions(effect, slot, function):
    """With units put in, the term has the unit of its slot."""
    functional = types.FunctionType(function.__code__, {
        name: value * unit(CONSTANTS[name]) if name in CONSTANTS else value
        for name, value in function.__globals__.items()})
    quantities = {name: 0.7 * max(RANGES[name]) * unit(READABLE[name]) for name in READABLE}
    # Above the cracking pressure of any valve.
    quantities['relief_pressure'] = 1.5 * quantities['pump_pressure']
    quantities['cross_port_pressure'] = 1.5 * quantities['pressure']
    values = {entry.name: entry.typical * unit(entry.unit) for entry in effect.parameters}
    result = evaluate(functional, values, quantities)
    assert result.check(unit(SLOTS[slot].unit)), f'{result} is not in {SLOTS[slot].unit}'


@pytest.mark.parametrize('effect, slot, function', TERMS)
def test_neutral_is_nothing(effect, slot, function):
    """At the neutral size the term is exactly zero, whatever the drive does."""
    @settings(max_examples=40, deadline=None)
    @given(reads=readings, others=sizes(effect))
    def check(reads, others):
        assert evaluate(function, effect.neutral, reads) == 0.0
        if effect.id not in ('bearing_friction', 'charge_pressure_loss', 'pump_friction',
                             'line_loss', 'piston_ripple'):
            size = effect.parameters[0]
            assert evaluate(function, {**others, size.name: size.neutral}, reads) == 0.0
    check()


@pytest.mark.parametrize('effect, slot, function', TERMS)
def test_finite_everywhere(effect, slot, function):
    """A term is a finite number over far more than a drive reaches."""
    @settings(max_examples=40, deadline=None)
    @given(reads=readings, values=sizes(effect))
    def check(reads, values):
        result = evaluate(function, values, reads)
        assert isinstance(result, float) and np.isfinite(result)
    check()


@pytest.mark.parametrize(
    'effect, slot, function', [term for term in TERMS if term.values[1] in LOSSES])
def test_losses_dissipate(effect, slot, function):
    """A loss takes energy: its sign is that of the pressure, the flow or the rotation."""
    drives = {'line_drop': 'flow', 'motor_flow_loss': 'pressure',
              'pump_flow_loss': 'pump_pressure'}.get(slot)

    @settings(max_examples=40, deadline=None)
    @given(reads=readings, values=sizes(effect))
    def check(reads, values):
        loss = evaluate(function, values, reads)
        if effect.id == 'leakage_temperature':
            # It takes from the table's leakage in cold oil, but never all of it.
            loss += reads['motor_leakage' if slot == 'motor_flow_loss' else 'pump_leakage']
            assert loss >= 0.0
        elif drives and drives in arguments(function):
            assert loss * reads[drives] >= 0.0
        else:
            assert loss >= 0.0
    check()


@pytest.mark.parametrize('effect, slot, function', TERMS)
def test_parity(effect, slot, function):
    """Torque losses are magnitudes; a line loses as much one way as the other."""
    names = arguments(function)

    @settings(max_examples=50, deadline=None)
    @given(reads=readings, values=sizes(effect))
    def check(reads, values):
        here = evaluate(function, values, reads)
        if slot == 'motor_torque_loss':
            back = {**reads, 'motor_speed': -reads['motor_speed']}
            assert evaluate(function, values, back) == here
        if slot == 'line_drop':
            assert evaluate(function, values, {**reads, 'flow': -reads['flow']}) == -here
        for name in {'pressure', 'pump_pressure'} & set(names):
            if slot.endswith('flow_loss'):
                assert evaluate(function, values, {**reads, name: 0.0}) == 0.0
    check()


@pytest.mark.parametrize('effect, slot, function', TERMS)
def test_smooth_in_its_parameters(effect, slot, function):
    """A tenfold smaller step of a parameter moves the term about a tenth: it can be fitted."""
    reads = {name: 0.6 * high + 0.4 * low for name, (low, high) in RANGES.items()}
    reads.update(motor_speed=3.0, relief_pressure=2e7, cross_port_pressure=2e7,
                 pump_pressure=1.2e7, pressure=1.2e7)
    typical = effect.typical
    here = evaluate(function, typical, reads)
    for entry in effect.parameters:
        if entry.fixed:
            continue
        step = 1e-3 * (entry.high - entry.low)
        coarse, fine = (
            (evaluate(function, {**typical, entry.name: entry.typical + h}, reads) - here) / h
            for h in (step, 0.1 * step))
        assert fine == pytest.approx(coarse, rel=0.2, abs=1e-30)


def test_slots_and_readable_names_are_complete():
    """Every readable name is known at some slot, and at each slot only readable names are."""
    assert set(RANGES) == set(READABLE) == set().union(*(readable(slot) for slot in SLOTS))
    for slot in SLOTS.values():
        assert unit(slot.unit) is not None
    assert {slot for effect in OWN.values() for slot, _ in effect.terms} <= set(SLOTS)


@pytest.mark.parametrize('slot, told', [
    ('speed_reading', {'motor_speed', 'oil_temperature'}), ('speed_reading_lag', set()),
    ('speed_reading_series_lag', set()), ('shaft_damping_time', set()),
    ('shaft_load_share', set())])
def test_effects_that_a_replay_reads_without_a_simulation(slot, told):
    """They may read what is known there only: the load model would pass others by in silence."""
    assert readable(slot) == told


def scale(flow, factor):
    """Return a term for the declarations below."""
    return factor * flow


def with_helper(flow, factor):
    """Return a term that calls another function."""
    return scale(flow, factor)


@pytest.mark.parametrize('change, complaint', [
    ({'slot': 'motor'}, "unknown slot 'motor'"),
    ({'slot': 'torque_reading'}, "argument 'flow' is neither a parameter nor known"),
    ({'slot': 'speed_reading'}, "argument 'flow' is neither a parameter nor known"),
    ({'function': lambda flow, factor: factor * flow}, "written with 'def'"),
    ({'function': with_helper}, "its function uses 'scale'"),
    ({'id': 'my effect'}, "expected an id of letters, digits and '_'"),
    ({'parameters': ()}, 'expected at least one parameter'),
    ({'parameters': (Parameter('factor', '1', 0.0, 1.0, 2.0, 'x'),)}, 'outside its bounds'),
    ({'parameters': (Parameter('flow', '1', 0.0, 1.0, 0.5, 'x'),)}, 'readable quantity'),
])
def test_bad_declarations_are_refused(change, complaint):
    """The message names the effect and what does not fit."""
    good = {'id': 'mine', 'title': 'mine', 'slot': 'flow_reading', 'function': scale,
            'equation': 'Q = factor*Q', 'telltale': '-', 'source': '-',
            'parameters': (Parameter('factor', '1', 0.0, 1.0, 0.5, 'x'),)}
    Effect(**good)
    with pytest.raises(ValueError, match=complaint):
        Effect(**{**good, **change})
