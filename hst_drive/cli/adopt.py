# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``adopt``: what a diagnosis found becomes part of the rig.

Writes the rig with the found effects, their values and the calibration of the unit; an effect
that was adopted before gets its new size, or goes if it is gone. 'compare --rig' with it shows
how far the error falls, and the plant node runs with it.
"""
from __future__ import annotations

import argparse
from pathlib import Path

from hst_drive.cli.common import add_rig_argument, read_json, rig_file_of
from hst_drive.cli.output import add_force_argument, refuse_to_replace, say, size, write_yaml
from hst_drive.errors import InputError

HELP = 'write the rig with the effects that a diagnosis found'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('diagnosis', metavar='DIAGNOSIS.json',
                        help="what 'diagnose --json' wrote")
    parser.add_argument('-o', '--output', metavar='RIG.yaml', required=True,
                        help='rig file to write')
    parser.add_argument('--formula', action='store_true',
                        help="where something stayed unknown: adopt the diagnosis' formula for it")
    parser.add_argument('--calibration', action='store_true',
                        help='where nothing is missing: adopt by how much the unit is off its '
                             'datasheet')
    add_force_argument(parser, 'RIG.yaml')
    add_rig_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Adopt and say what was added."""
    from hst_drive.diagnose.adopt import adopt
    from hst_drive.diagnose.result import UNIT_ALONE
    from hst_drive.fleet.campaigns import history_dates
    from hst_drive.rig import parse_rig
    from hst_drive.rig.yaml_file import read_yaml

    rig_file = rig_file_of(args)
    _refuse_inputs(args, rig_file)
    refuse_to_replace(args.output, args.force)
    diagnosis = read_json(args.diagnosis)
    rig = read_yaml(rig_file)
    adopted = adopt(rig, diagnosis, args.diagnosis, rig_file, formula=args.formula,
                    calibration=args.calibration, dates=history_dates(diagnosis))
    parse_rig(adopted, args.diagnosis)
    write_yaml(adopted, args.output)
    tell = say if args.output == '-' else print
    for name, values in adopted['effects'].items():
        tell(f'{args.output}: {name}: {_sizes(name, values)}')
    for name in sorted({*(rig.get('effects') or {})} - {*adopted['effects']}):
        tell(f'{args.output}: {name}: taken out, it is gone')
    for entry in diagnosis.get('sensor_delays', ()):
        late = 1e3 * adopted['sensors'][entry['channel']]['delay_s']
        tell(f"{args.output}: {entry['channel']}: reads {late:.2g} ms late")
    if args.calibration:
        tell(f"{args.output}: the unit's calibration "
             f"(number of quantities: {len(adopted['calibration'])})")
    for entry in diagnosis['effects']:
        rivals = entry.get('indistinguishable_from')
        if rivals:
            told = ['that is, the unit alone at the limits of its tolerances'
                    ] if UNIT_ALONE in rivals else []
            if {*rivals} - {UNIT_ALONE}:
                told.append((diagnosis.get('next_test') or {}).get('what')
                            or "'hst-drive design' writes a test that tells")
            tell(f"{args.output}: {entry['id']} is one of several that fit these logs; so may "
                 f"{' or '.join(rivals)}: {'; '.join(told)}")
    return 0


def _sizes(name: str, values: dict[str, float]) -> str:
    """Return the sizes of an effect in the units in which 'diagnose' prints them."""
    from hst_drive.effects import effect_of

    units = {entry.name: entry.unit for entry in effect_of(name).parameters}
    shown = {key: size(value, units[key]) for key, value in values.items()}
    return ', '.join(f'{key} = {number}' + (f' {unit}' if unit != '1' else '')
                     for key, (number, unit) in shown.items())


def _refuse_inputs(args: argparse.Namespace, rig_file: str) -> None:
    """Raise InputError if the output would take the place of what it is made of."""
    target = Path(args.output)
    if not target.is_file():
        return      # a new file, '-' or a pipe; what cannot be written is told when it is written
    if Path(rig_file).exists() and target.samefile(rig_file):
        raise InputError(f'{target}: is the rig that was diagnosed; choose another name, so '
                         'that both can be compared')
