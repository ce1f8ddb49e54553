# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``adopt``: what a diagnosis found becomes part of the rig.

Writes the rig with the found effects, their values and the calibration of the unit; 'compare
--rig' with it shows how far the error falls, and the plant node runs with it.
"""
from __future__ import annotations

import argparse
import json
from pathlib import Path

from hst_drive.cli.common import add_rig_argument
from hst_drive.cli.output import write_text
from hst_drive.errors import InputError

HELP = 'write the rig with the effects that a diagnosis found'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('diagnosis', metavar='DIAGNOSIS.json',
                        help="what 'diagnose --json' wrote")
    parser.add_argument('-o', '--output', metavar='RIG.yaml', required=True,
                        help='rig file to write')
    add_rig_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Adopt and say what was added."""
    import yaml

    from hst_drive.diagnose.adopt import adopt
    from hst_drive.resources import share
    from hst_drive.rig.load import parse_rig, read_yaml

    diagnosis = read_json(args.diagnosis)
    rig_file = args.rig or str(share('config', 'rig', 'test_rig.yaml'))
    rig = read_yaml(rig_file)
    adopted = adopt(rig, diagnosis, args.diagnosis, rig_file)
    parse_rig(adopted, args.output)
    if Path(args.output).exists() and Path(args.output).samefile(rig_file):
        raise InputError(f'{args.output}: is the rig that was diagnosed; choose another name, so '
                         'that both can be compared')
    write_text(yaml.safe_dump(adopted, sort_keys=False, default_flow_style=None, width=99),
               args.output)
    for name, values in adopted['effects'].items():
        listed = ', '.join(f'{key} = {value:.4g}' for key, value in values.items())
        print(f'{args.output}: {name}: {listed}')
    return 0


def read_json(path: str) -> dict:
    """Read a JSON file; one line says what is wrong with it."""
    try:
        return json.loads(Path(path).read_text(encoding='utf-8'))
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror}); check the path') from None
    except ValueError as error:
        raise InputError(f'{path}: is not JSON ({error}); expected what '
                         "'hst-drive diagnose --json' wrote") from None
