# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``commission``: one machine's fingerprint from logs of when it was healthy.

Writes a rig file with this machine's own factors, how well they are known, and for which
conditions; with '--rig UNIT.yaml' every verb goes by them. What the logs told nothing about stays
as far off as the make's tolerance lets it. Logs in which something is missing are refused.
"""
from __future__ import annotations

import argparse
from typing import Iterator, TYPE_CHECKING

from hst_drive.cli.common import (
    add_day_to_day_argument, add_log_arguments, day_to_day_of, read_logs, rig_file_of)
from hst_drive.cli.diagnose import progress_line, tell_notes
from hst_drive.cli.output import (
    add_force_argument, add_json_argument, refuse_inputs, refuse_to_replace, say, table,
    write_json, write_yaml)

if TYPE_CHECKING:
    from hst_drive.diagnose.commission import Commissioned

HELP = "learn a machine's own numbers, and how well they are known, from healthy logs"
SCHEMA = 'hst_drive/commission/1'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_log_arguments(parser)
    parser.add_argument('-o', '--output', metavar='UNIT.yaml', required=True,
                        help='rig file to write')
    add_day_to_day_argument(parser)
    add_force_argument(parser, 'UNIT.yaml')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Commission, write and print."""
    from hst_drive.diagnose.commission import commission
    from hst_drive.rig.yaml_file import read_yaml

    day_to_day = day_to_day_of(args)
    source = rig_file_of(args)
    refuse_inputs([text for text in (args.output, args.json) if text], [source, *args.logs])
    refuse_to_replace(args.output, args.force)
    rig = read_yaml(source)
    runs = read_logs(args.logs, args.channels)
    tell_notes(runs, args.rig)
    found = commission(rig, source, runs, day_to_day, progress=progress_line())
    write_yaml(found.rig, args.output)
    if args.json:
        write_json({'schema': SCHEMA, 'rig': source, 'logs': args.logs,
                    'quantities': [entry._asdict() for entry in found.quantities],
                    'day_to_day_share_of_tolerance': found.day_to_day,
                    'day_to_day_from_logs': found.from_logs,
                    'conditions': found.rig['commissioned']['conditions']}, args.json)
    tell = say if '-' in (args.output, args.json) else print
    tell(text(found))
    if args.output != '-':
        tell(f"\nwrote {args.output}: with --rig {args.output}, 'diagnose' says what has changed")
    return 0


def text(found: Commissioned) -> str:
    """Return the fingerprint for a terminal."""
    from hst_drive.effects.leakage_temperature import OIL_LAW
    from hst_drive.rig.fingerprint import OIL_LAW_SIGMA, STARTS, ZEROS

    rows = [[entry.quantity, f'{entry.factor:.4f}', f'{100 * entry.sigma:.2g}',
             f'{100 * entry.make:.2g}'] for entry in found.quantities]
    header = ['quantity', 'factor on the datasheet', 'known to [%, 1 sigma]', 'make [%, 1 sigma]']
    lines = [table(header, rows), '',
             'from day to day (one sigma): '
             f'{found.day_to_day:g} of the tolerance of the make, '
             + ('from these logs' if found.from_logs else 'as --day-to-day, or its default, says'),
             'commissioned for: ' + ', '.join(_conditions(found))]
    learnt = found.rig['commissioned']
    if zeros := learnt.get(ZEROS):
        lines.append('zeros of sensors (one sigma): ' + ', '.join(
            f'{name} {value:.3g} ({sigma:.2g})' for name, (value, sigma) in zeros.items()))
    if starts := learnt.get(STARTS):
        lines.append('starts from rest, the model errs by (rms): ' + ', '.join(
            f'{name} {value:.3g}' for name, value in starts.items()))
    law = (found.rig.get('effects') or {}).get(OIL_LAW)
    if law:
        power, sigma = law['exponent'], learnt.get(OIL_LAW_SIGMA, 0.0)
        lines.append("its leakage follows the oil's viscosity to the power "
                     f'{power:.2g}' + (f' (one sigma {sigma:.2g})' if sigma else '')
                     + (f": '{OIL_LAW}' is part of this machine, and no fault"
                        if power > 2.0 * sigma else ', which may be none'))
    untold = [entry for entry in found.quantities if entry.test]
    if untold:
        lines += ['', 'these logs tell little of (the tolerance of the make stays); what would '
                  'tell:', *(f'  {entry.quantity}: {entry.test}' for entry in untold)]
    return '\n'.join(lines)


def _conditions(found: Commissioned) -> Iterator[str]:
    """Yield between which values each channel lay."""
    from hst_drive.channels import CHANNELS
    from hst_drive.rig.fingerprint import CONDITIONS

    told = found.rig['commissioned']['conditions']
    for channel, (suffix, unit) in CONDITIONS.items():
        if f'{channel}_{suffix}' in told:
            low, high = told[f'{channel}_{suffix}']
            yield f'{CHANNELS[channel].title} {low:.4g} to {high:.4g} {unit}'
