# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The catalogue of effects, or one of them, as text and as JSON."""
from __future__ import annotations

import textwrap

from hst_drive.effects import catalogue, Effect, left_out, origin, SLOTS, unknown_effect
from hst_drive.errors import InputError
from hst_drive.model.circuit_model import part_model, refuse_placeless
from hst_drive.report import markup
from hst_drive.report.terminal import table
from hst_drive.rig import Rig

_WIDTH = 96
_HEADER = ('id', 'enters', 'what it is')
_COLUMNS = ('parameter', 'unit', 'low', 'high', 'typical', 'what it is')


def chosen(identity: str | None = None, rig: Rig | None = None) -> dict[str, Effect]:
    """
    Return the whole catalogue, or one effect of it; with a rig what has a place in its circuit.

    With a rig sizes and bounds are those of its machine.

    Raises
    ------
    InputError
        If there is no such effect, or it has no place there.

    """
    effects = catalogue()
    if identity is not None:
        if identity not in effects:
            raise InputError(unknown_effect(identity))
        effects = {identity: effects[identity]}
    if rig is not None:
        model = part_model(rig)
        if identity is not None:
            refuse_placeless(model, effects)
        effects = {name: effect.sized(*rig.sizes) for name, effect in effects.items()
                   if model.enters(name)}
    return effects


def text(effects: dict[str, Effect], identity: str | None = None) -> str:
    """Return effects as a table, or the explanation of the one that was asked for."""
    return (table(_HEADER, _rows(effects)) if identity is None
            else _explanation(effects[identity]))


def html(effects: dict[str, Effect], identity: str | None = None) -> str:
    """Return the same for a page."""
    if identity is None:
        return str(markup.table(_HEADER, _rows(effects)))
    effect = effects[identity]
    facts = [markup.element('dt', name) + markup.element('dd', told)
             for name, told in _facts(effect)]
    return str(markup.element('h3', f'{effect.id}: {effect.title}')
               + markup.element('dl', markup.join(facts))
               + markup.table(_COLUMNS, _parameters(effect)))


def _rows(effects: dict[str, Effect]) -> list[tuple[str, ...]]:
    order = list(dict.fromkeys(slot.enters for slot in SLOTS.values()))
    return [(effect.id, effect.enters, effect.title + (
        '' if origin(effect.id) == 'hst_drive' else f' (package {origin(effect.id)})'))
        for effect in sorted(effects.values(), key=lambda effect: order.index(effect.enters))]


def _explanation(effect: Effect) -> str:
    lines = [f'{effect.id}: {effect.title}', '']
    for name, told in _facts(effect):
        lines += textwrap.wrap(told, _WIDTH, initial_indent=f'{name:11}',
                               subsequent_indent=' ' * 11, break_on_hyphens=False)
    return '\n'.join([*lines, '', table(_COLUMNS, _parameters(effect))])


def _facts(effect: Effect) -> list[tuple[str, str]]:
    return [('enters', f'{effect.enters}: ' + '; '.join(
                f'{SLOTS[slot].meaning} ({SLOTS[slot].unit})' for slot, _ in effect.terms)),
            ('equation', effect.equation), ('tell-tale', effect.telltale),
            ('shows in', ', '.join(effect.shows_in)), ('source', effect.source),
            ('package', origin(effect.id))]


def _parameters(effect: Effect) -> list[tuple]:
    return [(entry.name, entry.unit, entry.low, entry.high, entry.typical, entry.meaning)
            for entry in effect.parameters]


def as_json(effects: dict[str, Effect]) -> dict:
    """Return effects in the form of schema hst_drive/effects/1."""
    return {'schema': 'hst_drive/effects/1', 'left_out': left_out(),
            'effects': [_entry(effect) for effect in effects.values()]}


def _entry(effect: Effect) -> dict[str, object]:
    return {'id': effect.id, 'title': effect.title, 'enters': effect.enters,
            'slots': [slot for slot, _ in effect.terms], 'equation': effect.equation,
            'telltale': effect.telltale, 'source': effect.source, 'shows_in': effect.shows_in,
            'package': origin(effect.id),
            'parameters': {entry.name: {
                'unit': entry.unit, 'low': entry.low, 'high': entry.high,
                'typical': entry.typical, 'neutral': entry.neutral, 'meaning': entry.meaning}
                for entry in effect.parameters}}
