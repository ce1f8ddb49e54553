# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drive as a unit for co-simulation, FMI 2.0: what every simulator of machines reads.

One C file holds the equations, from the text that runs here, the numbers of the rig and the
functions of FMI (Functional Mock-up Interface for Model Exchange and Co-Simulation, 2.0.4,
Modelica Association 2022). A step is the drive's own: commands hold in it.
"""
from __future__ import annotations

from collections.abc import Sequence
import hashlib
from importlib.resources import files
from typing import NamedTuple
from xml.etree import ElementTree

from hst_drive.effects import effect_of
from hst_drive.effects.oil import viscosity
from hst_drive.export.c_source import Array, translate
from hst_drive.model import Drive
from hst_drive.model.compiled import python_of
from hst_drive.model.compose import generate_drive, OUTPUTS, STATES
from hst_drive.model.parameters import NAMES, SCALED
from hst_drive.rig.schema import FACTORS, OIL_TEMPERATURES
from hst_drive.units import to_si
import numpy as np

IDENTIFIER = 'hst_drive'
_FIRST_OUTPUT, _FIRST_PARAMETER = 100, 1000     # value references, as in wrapper.c
_ROWS = 2           # a step has a beginning and an end
_READ = Array('const double')
_INPUTS = (('pump_command', 'V', 'pump displacement command'),
           ('pprv_command', 'V', 'PPRV command'),
           ('oil_temperature', 'K', 'oil temperature'),
           ('load_disturbance', 'N.m', 'load torque beyond that of the loading unit'))
_UNITS = {'pressure': 'Pa', 'flow': 'm^3/s', 'speed': 'rad/s', 'torque': 'N.m',
          'displacement': 'm^3/rad', 'hydraulic': 'N.m'}
# FMI spells a unit by powers of the base units of SI.
_BASE = {'Pa': {'kg': 1, 'm': -1, 's': -2}, 'm^3/s': {'m': 3, 's': -1}, 'K': {'K': 1},
         'N.m': {'kg': 1, 'm': 2, 's': -2}, 'rad/s': {'rad': 1, 's': -1}, 's': {'s': 1},
         'm^3/rad': {'m': 3, 'rad': -1}, 'V': {'kg': 1, 'm': 2, 's': -3, 'A': -1}}


class Unit(NamedTuple):
    """What a unit of co-simulation holds: its description (XML), and its source (C)."""

    description: str
    source: str


def unit_of(drive: Drive) -> Unit:
    """Return the unit of a drive, at rest at its start; the drive's effects are in it."""
    source = _source(drive)
    guid = hashlib.sha256(source.encode()).hexdigest()[:32]
    return Unit(_description(drive, guid), f'#define GUID "{guid}"\n{source}')


def _source(drive: Drive) -> str:
    effects = {name: effect_of(name) for name in drive.effects}
    code = generate_drive(effects)
    numbers, on = code.vectors(drive.parameters[:len(NAMES)], drive.effects)
    cells, layout = drive.tables
    records = ('time', 'pump_commands', 'pprv_commands', 'oil_temperatures', 'viscosity_ratios',
               'disturbances', 'motor_angles', 'p')
    equations = translate(
        python_of(code.source, effects),
        {**dict.fromkeys(records, _READ), 'state': Array('double'),
         'on': Array('const signed char'), 'cells': Array('const double', cells.shape[1]),
         'layout': Array('unsigned long', layout.shape[1]),
         'out': Array('double', len(OUTPUTS))},
        _ROWS, integers=('number',), leave_out=('load_record', 'twist_under'))
    counts = {'STATES': len(STATES), 'INPUTS': len(_INPUTS), 'OUTPUTS': len(OUTPUTS),
              'FACTORS': len(SCALED), 'PARAMETERS': len(numbers), 'NUMBERS': len(NAMES),
              'LAYOUT': layout.size}
    inputs = [0.0, 0.0, drive.rig.characterised_at, 0.0]
    return '\n'.join([
        equations, *(f'#define {name} {value}' for name, value in counts.items()),
        f'static const double MAX_STEP = {drive.max_step!r};',
        _array('double', 'BASE', numbers), _array('signed char', 'ON', on),
        _array('double', 'CELLS', cells.ravel()),
        _array('unsigned long', 'FIRST_LAYOUT', layout.ravel()),
        _array('double', 'FIRST_STATE', drive.initial_state()),
        _array('double', 'FIRST_INPUTS', inputs),
        _array('int', 'FACTOR_OF', [NAMES.index(name) for name in SCALED.values()]),
        _viscosity(drive),
        (files('hst_drive.export') / 'wrapper.c').read_text(encoding='utf-8')])


def _array(kind: str, name: str, values: Sequence[float] | np.ndarray) -> str:
    shown = ', '.join('NAN' if value != value else
                      f'{"-" if value < 0 else ""}INFINITY' if abs(value) == np.inf else
                      repr(float(value)) if kind == 'double' else str(int(value))
                      for value in values)
    return f'static const {kind} {name}[] = {{{shown}}};'


def _viscosity(drive: Drive) -> str:
    """Return Walther's equation (ASTM D341), which is a line in these coordinates, as C."""
    grade = drive.rig.oil_grade
    at = np.array([313.15, 373.15])
    line = np.log10(np.log10(viscosity(at, grade) * 1e6 + 0.7))
    slope = (line[1] - line[0]) / (np.log10(at[1]) - np.log10(at[0]))
    level = line[0] - slope * np.log10(at[0])
    table = viscosity(drive.rig.characterised_at, grade) * 1e6
    return ('static double viscosity_ratio_at(double temperature)\n{\n'
            f'    return (pow(10.0, pow(10.0, {level!r} + {slope!r} * log10(temperature))) - 0.7) '
            f'/ {table!r};\n}}\n').replace('np.float64(', '(')


def _description(drive: Drive, guid: str) -> str:
    top = ElementTree.Element('fmiModelDescription', {
        'fmiVersion': '2.0', 'modelName': drive.rig.name, 'guid': guid,
        'description': 'Hydrostatic rotary drive of a drill rig',
        'generationTool': 'hst_drive', 'variableNamingConvention': 'structured'})
    step = ElementTree.SubElement(top, 'CoSimulation', {
        'modelIdentifier': IDENTIFIER, 'canHandleVariableCommunicationStepSize': 'true',
        'canGetAndSetFMUstate': 'true', 'canSerializeFMUstate': 'true'})
    sources = ElementTree.SubElement(step, 'SourceFiles')
    ElementTree.SubElement(sources, 'File', {'name': f'{IDENTIFIER}.c'})
    units = ElementTree.SubElement(top, 'UnitDefinitions')
    variables = ElementTree.Element('ModelVariables')
    seen: dict[str, None] = {}

    def add(name: str, reference: int, unit: str, meaning: str, start: float | None = None,
            bounds: tuple[float, ...] = (), **more: str) -> None:
        entry = ElementTree.SubElement(variables, 'ScalarVariable', {
            'name': name, 'valueReference': str(reference), 'description': meaning, **more})
        real = {} if unit == '1' else {'unit': unit}
        if unit != '1':
            seen[unit] = None
        if start is not None:
            real['start'] = repr(float(start))
        real.update(zip(('min', 'max'), map(repr, map(float, bounds))))
        ElementTree.SubElement(entry, 'Real', real)

    first = (0.0, 0.0, drive.rig.characterised_at, 0.0)
    hot = tuple(to_si(value, 'degC') for value in OIL_TEMPERATURES)
    for place, ((name, unit, meaning), start) in enumerate(zip(_INPUTS, first)):
        add(name, place, unit, meaning, start, hot if name == 'oil_temperature' else (),
            causality='input', variability='continuous')
    for place, name in enumerate(OUTPUTS):
        add(name, _FIRST_OUTPUT + place, _UNITS[name.rpartition('_')[2]],
            name.replace('_', ' '), causality='output', variability='continuous')
    for place, name in enumerate(SCALED):
        add(f'factor.{name}', _FIRST_PARAMETER + place, '1', 'of this unit on the rig file', 1.0,
            FACTORS, causality='parameter', variability='tunable')
    place = _FIRST_PARAMETER + len(SCALED)
    for name, values in drive.effects.items():
        for parameter in effect_of(name).parameters:
            add(f'effect.{name}.{parameter.name}', place, parameter.unit, parameter.meaning,
                values[parameter.name], (parameter.low, parameter.high), causality='parameter',
                variability='tunable')
            place += 1
    for unit in seen:
        definition = ElementTree.SubElement(units, 'Unit', {'name': unit})
        if unit in _BASE:
            ElementTree.SubElement(definition, 'BaseUnit', {
                key: str(power) for key, power in _BASE[unit].items()})
    top.append(variables)
    structure = ElementTree.SubElement(top, 'ModelStructure')
    for kind in ('Outputs', 'InitialUnknowns'):
        listed = ElementTree.SubElement(structure, kind)
        for place in range(len(OUTPUTS)):
            ElementTree.SubElement(listed, 'Unknown', {'index': str(len(_INPUTS) + place + 1)})
    ElementTree.indent(top)
    return ElementTree.tostring(top, encoding='unicode', xml_declaration=True) + '\n'
