# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reference pages from what the program declares, made while the site is built.

A page has a line that ends in ``<!-- declared: NAME -->``. What takes its place on the site comes
from the parsers of the verbs, the catalogue of effects, the table of rig keys, the channels and
the units: it cannot differ from the program.
"""
import argparse
from importlib import import_module
import inspect
from pathlib import Path
import re

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from hst_drive.channels import CHANNELS
from hst_drive.cli import verbs
from hst_drive.effects import catalogue, READABLE, SLOTS
from hst_drive.errors import InputError
from hst_drive.measure.balances import BALANCES
from hst_drive.model.circuits import circuits
from hst_drive.rig.meanings import MEANINGS
from hst_drive.rig.schema import Limits, Number, PART, SECTIONS, SENSOR_UNITS, Table, TOLERANCES
from hst_drive.units import for_people, UNITS
from sphinx.util import logging
import telltale

TOP = Path(import_module('hst_drive').__file__).resolve().parents[1]
_MARK = re.compile(r'^.*<!-- declared: (\w+) ?(\S*) -->$', re.MULTILINE)
_BALANCES = dict.fromkeys(slot.enters for slot in SLOTS.values())


def setup(app):
    """Let Sphinx ask for what is declared."""
    app.add_config_value('telltale_pictures', True, 'html', bool)
    app.add_html_math_renderer('mathml', (_inline, None), (_equation, None))
    app.connect('source-read', _fill)
    app.connect('build-finished', _draw)
    return {'parallel_read_safe': True}


def _inline(writer, node):
    writer.body.append(_mathml(node))
    raise nodes.SkipNode


def _equation(writer, node):
    formula = _mathml(node).replace('<math ', '<math display="block" ', 1)
    writer.body.append(f'<div class="math">{formula}</div>')
    raise nodes.SkipNode


def _mathml(node):
    """Return a formula that needs no script, no network and no font with italic symbols."""
    return tex2mathml(node.astext()).replace('<mi>', '<mi mathvariant="normal">')


def _fill(app, page, source):
    source[0] = _MARK.sub(lambda found: PARTS[found[1]](*filter(None, found.groups()[1:])),
                          source[0])


def _draw(app, problem):
    """Draw the tell-tales beside the pages that show them."""
    if problem or not app.config.telltale_pictures or app.builder.name != 'html':
        return
    try:
        telltale.draw_all(Path(app.outdir) / telltale.FOLDER)
    except InputError as missing:
        logging.getLogger(__name__).warning('no pictures of the tell-tales: %s', missing)


def table(header, rows):
    """Return a table in Markdown."""
    lines = [header, ['---'] * len(header), *rows]
    return '\n'.join('| ' + ' | '.join(str(cell).replace('|', r'\|') for cell in line) + ' |'
                     for line in lines)


def of_verbs():
    """Every verb: what it does, how it is called, its options."""
    return '\n\n'.join(_verb(name, told) for name, told in verbs().items())


def _verb(name, told):
    module = import_module(f'hst_drive.cli.{name.replace("-", "_")}')
    parser = argparse.ArgumentParser(prog=f'hst-drive {name}', add_help=False)
    module.add_arguments(parser)
    usage = re.sub(r'\s+', ' ', parser.format_usage().removeprefix('usage: ')).strip()
    details = inspect.cleandoc(module.__doc__ or '').partition('\n')[2].strip()
    rows = [(_called(action), (action.help or '') % {
        'default': action.default, 'prog': parser.prog}) for action in parser._actions]
    return '\n\n'.join([f'## {name}', f'{told[0].upper()}{told[1:]}.', f'    {usage}', details,
                        table(('argument', 'is'), rows)])


def _called(action):
    values = action.metavar or (action.dest.upper() if action.nargs != 0 else '')
    values = ' '.join(values) if isinstance(values, tuple) else values
    names = ', '.join(action.option_strings)
    return f'`{names} {values}`'.replace(' `', '`') if names else f'`{values or action.dest}`'


def of_effects():
    """Every effect: equation, tell-tale with its picture, parameters, source."""
    own = catalogue()
    lines = [table(('effect', 'enters', 'is'), (
        (f'[`{effect.id}`](#effect-{effect.id.replace("_", "-")})', effect.enters, effect.title)
        for effect in _ordered(own)))]
    for effect in _ordered(own):
        enters = '; '.join(f'{SLOTS[slot].meaning} ({SLOTS[slot].unit})'
                           for slot, _ in effect.terms)
        parameters = [(f'`{entry.name}`', *_sizes(entry), entry.meaning)
                      for entry in effect.parameters]
        lines += [f'(effect-{effect.id.replace("_", "-")})=', f'## {effect.id}',
                  f'{effect.title[0].upper()}{effect.title[1:]}.', f'    {effect.equation}',
                  f'**Tell-tale.** {effect.telltale}', telltale.figure(effect),
                  f'**Enters** the {effect.enters}: {enters}.',
                  f'**Shows in** {_either(effect.shows_in)}.',
                  table(('parameter', 'low', 'high', 'typical', 'unit', 'is'), parameters),
                  f'**Source.** {effect.source}']
    return '\n\n'.join(lines)


def _ordered(effects):
    order = list(_BALANCES)
    return sorted(effects.values(), key=lambda effect: (order.index(effect.enters), effect.id))


def _sizes(entry):
    sizes = [for_people(value, entry.unit) for value in (entry.low, entry.high, entry.typical)]
    return (*(f'{value:.3g}' for value, _ in sizes), sizes[0][1])


def of_slots():
    """Every place where an effect may enter, and what an effect may read."""
    return '\n\n'.join([
        table(('slot', 'balance', 'the value is', 'unit'), (
            (f'`{name}`', slot.enters, slot.meaning, slot.unit) for name, slot in SLOTS.items())),
        '### Names that a function may read',
        table(('name', 'unit'), ((f'`{name}`', unit) for name, unit in READABLE.items()))])


def of_rig():
    """Every key of a rig file: meaning, unit, range, and whether it may be left out."""
    lines = []
    for section, keys in SECTIONS.items():
        lines += [f'### {section}', table(
            ('key', 'means', 'is', 'range', 'optional'),
            [(f'`{key}`', MEANINGS[section][key], *_key(entry), _left_out(section, key, entry))
             for key, entry in keys.items()])]
    sensors = [(f'`{name}`', f'`noise_std_{suffix}`, `resolution_{suffix}`, '
                f'`zero_std_{suffix}`, `range_{suffix}`, `delay_std_s`', unit)
               for name, (suffix, unit) in SENSOR_UNITS.items()]
    return '\n\n'.join([
        *lines, '### sensors', table(('channel', 'keys', 'unit'), sensors),
        '### tolerances_1_sigma_relative',
        _either(TOLERANCES, ', ') + '.'])


def _key(entry):
    if isinstance(entry, Number):
        return f'number, {_unit(entry.unit)}', f'{entry.low:g} to {entry.high:g}'
    if isinstance(entry, Table):
        axes = ' and '.join(f'`{key}`' for key, _ in entry.axes)
        other = (', or one number, or the coefficients '
                 + _either(entry.coefficients, ', ')
                 if entry.coefficients else '')
        return (f'table over {axes}; values `{entry.value}`, {_unit(entry.unit)}'
                + ('; rising' if entry.rising else '') + other,
                f'{entry.low:g} to {entry.high:g}')
    if isinstance(entry, Limits):
        return f'pair [low, high], {_unit(entry.unit)}', ''
    return 'text', ''


def _left_out(section, key, entry):
    if getattr(entry, 'optional', False):
        return 'yes'
    return 'in a part' if key in PART.get(section, ()) else ''


def _unit(unit):
    return 'no unit' if unit == '1' else unit


def of_channels():
    """Every channel of a log."""
    return table(('channel', 'is', 'usual unit', 'SI', 'between two rows'), (
        (f'`{entry.name}`', entry.title, entry.display, entry.unit,
         'stays' if entry.hold == 'zero' else 'on a straight line')
        for entry in CHANNELS.values()))


def of_balances():
    """Every balance of a part: what it predicts, from what, and with which keys of the rig."""
    return table(('balance', 'predicts', 'from all of', 'the rig file has', 'not used beside'), (
        (entry.name, _either(entry.groups[0]), '; '.join(map(_either, entry.groups[1:])),
         _either(entry.rig, ', '), _either(entry.without, ', ')) for entry in BALANCES.values()))


def of_circuits():
    """Every circuit but the open one: sections of its rig file, and its balances."""
    lines = []
    for circuit in circuits().values():
        lines += [f'### {circuit.id}',
                  f'{circuit.title[0].upper()}{circuit.title[1:]}. The rig file has '
                  f'{_either(circuit.sections, ", ")}.', table(
                      ('balance', 'predicts', 'from all of', 'what is missing enters'),
                      ((entry.name, f'`{entry.signal}`', '; '.join(map(_either, entry.groups[1:])),
                        entry.enters.replace('_', ' ')) for entry in circuit.balances))]
    return '\n\n'.join(lines)


def _either(names, between=' or '):
    return between.join(f'`{name}`' for name in names)


def of_units():
    """Every unit that a header may have, by what it measures."""
    groups = {}
    for name, unit in UNITS.items():
        if name:
            groups.setdefault(unit.si, []).append(f'`{name}`')
    return table(('SI', 'also'), ((f'`{si}`', ', '.join(names)) for si, names in groups.items()))


def of_picture(identity):
    """Return the picture of one effect's tell-tale."""
    return telltale.figure(catalogue()[identity])


def of_file(name):
    """Return a page of the source that lies outside of this folder, without its links there."""
    text = (TOP / name).read_text(encoding='utf-8')
    return re.sub(r'\[([^\]]+)\]\((?!https?:)[^)]+\)', r'\1', text)


PARTS = {'verbs': of_verbs, 'effects': of_effects, 'slots': of_slots, 'rig': of_rig,
         'channels': of_channels, 'balances': of_balances, 'units': of_units,
         'circuits': of_circuits,
         'picture': of_picture, 'file': of_file}
