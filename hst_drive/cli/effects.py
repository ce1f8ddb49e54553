# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``effects``: what a baseline drive model may lack.

Without an id, lists all effects by the balance that they enter; with one, explains it. Effects
of other packages (entry-point group hst_drive.effects) are listed with the package's name.
Numbers are in SI. The ids are those of rig files, of diagnoses and of the plant node's parameter
``effects``.
"""
from __future__ import annotations

import argparse
from difflib import get_close_matches
import textwrap
from typing import TYPE_CHECKING

from hst_drive.cli.output import add_json_argument, say, table, write_json
from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.effects import Effect

HELP = 'physical effects that the model can add: list, or explain one'
_WIDTH = 96


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('id', nargs='?', metavar='ID',
                        help='effect to explain (default: list all)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the list or the explanation."""
    from hst_drive.effects import catalogue, left_out

    effects = catalogue()
    for line in left_out():
        say(line)
    if args.id is not None and args.id not in effects:
        near = get_close_matches(args.id, effects, n=1)
        hint = f"did you mean '{near[0]}'?" if near else "'hst-drive effects' lists all"
        raise InputError(f"unknown effect '{args.id}'; {hint}")
    chosen = effects if args.id is None else {args.id: effects[args.id]}
    if args.json != '-':
        print(_listing(chosen) if args.id is None else _explanation(effects[args.id]))
    if args.json:
        write_json({'schema': 'hst_drive/effects/1', 'left_out': left_out(),
                    'effects': [_entry(effect) for effect in chosen.values()]}, args.json)
    return 0


def _listing(effects: dict[str, Effect]) -> str:
    from hst_drive.effects import origin, SLOTS

    order = list(dict.fromkeys(slot.enters for slot in SLOTS.values()))
    rows = [(effect.id, effect.enters, effect.title + (
        '' if origin(effect.id) == 'hst_drive' else f' (package {origin(effect.id)})'))
        for effect in sorted(effects.values(), key=lambda effect: order.index(effect.enters))]
    return table(['id', 'enters', 'what it is'], rows)


def _explanation(effect: Effect) -> str:
    from hst_drive.effects import origin, SLOTS

    lines = [f'{effect.id}: {effect.title}', '']
    facts = [('enters', f'{effect.enters}: ' + '; '.join(
                 f'{SLOTS[slot].meaning} ({SLOTS[slot].unit})' for slot, _ in effect.terms)),
             ('equation', effect.equation), ('tell-tale', effect.telltale),
             ('shows in', ', '.join(effect.shows_in)), ('source', effect.source),
             ('package', origin(effect.id))]
    for name, text in facts:
        lines += textwrap.wrap(text, _WIDTH, initial_indent=f'{name:11}',
                               subsequent_indent=' ' * 11, break_on_hyphens=False)
    rows = [(entry.name, entry.unit, entry.low, entry.high, entry.typical, entry.meaning)
            for entry in effect.parameters]
    return '\n'.join([*lines, '', table(
        ['parameter', 'unit', 'low', 'high', 'typical', 'what it is'], rows)])


def _entry(effect: Effect) -> dict[str, object]:
    from hst_drive.effects import origin

    return {'id': effect.id, 'title': effect.title, 'enters': effect.enters,
            'slots': [slot for slot, _ in effect.terms], 'equation': effect.equation,
            'telltale': effect.telltale, 'source': effect.source, 'shows_in': effect.shows_in,
            'package': origin(effect.id),
            'parameters': {entry.name: {
                'unit': entry.unit, 'low': entry.low, 'high': entry.high,
                'typical': entry.typical, 'neutral': entry.neutral, 'meaning': entry.meaning}
                for entry in effect.parameters}}
