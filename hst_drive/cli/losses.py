# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``losses``: the steady-state losses of motors from a bench table.

BENCH.csv has a row per operating point: motor_displacement[cc/rev], oil_temperature[degC],
load_torque[N.m], motor_speed[rpm], supply_pressure[bar], supply_flow[L/min] and, optionally,
case_drain_flow[L/min]; the unit in the header counts. Identifies the loss resistances by Eqs. (2)
to (4) of the motor-loss paper, fits their characteristics, judges them on left-out rows, tries the
paper's stated trends, ranks the field's loss models and names the physical term that the simple
form lacks. A table of transmissions (pump_speed, motor_speed, no torque) is read for leakage.
"""
from __future__ import annotations

import argparse

from hst_drive.cli.output import add_json_argument, say, write_json
from hst_drive.errors import InputError

HELP = 'steady-state losses of motors from a bench table: characteristics, trends, missing term'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bench', metavar='BENCH.csv', help='table of operating points')
    parser.add_argument('--channels', metavar='MAP.yaml',
                        help='foreign column names and units to ours, constants for all rows')
    parser.add_argument('--oil', metavar='GRADE', default='ISO VG 46',
                        help='viscosity grade, config/oil_grades.yaml (default: ISO VG 46)')
    parser.add_argument('--oils', metavar='OILS.yaml', help='own grades, as config/oil_grades.yaml')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print what the table says."""
    from hst_drive.bag.bench_table import read_points
    from hst_drive.cli import losses_text as text
    from hst_drive.cli.oils import oil_of
    from hst_drive.losses.resistances import identify
    from hst_drive.losses.study import LEAST_ROWS, study
    from hst_drive.losses.table import bench_of

    table = read_points(args.bench, args.channels)
    oil = oil_of(args.oil, args.oils)
    for note in table.notes:
        say(f'{args.bench}: {note}')
    bench = bench_of(table.columns, table.headers, table.lines, table.constants, table.source, oil)
    for note in bench.notes:
        say(f'{args.bench}: {note}')
    found = identify(bench)
    content = text.head(bench, args.oil)
    done = None
    if len(bench) < LEAST_ROWS:
        say(f'{args.bench}: {len(bench)} rows determine no curves (at least {LEAST_ROWS}); only '
            'the resistances of the rows follow')
    else:
        say(f'fitting {len(bench)} rows')
        done = study(bench)
        content |= text.studied(done)
    content['rows'] = text.rows(bench, found, done)
    if args.json != '-':
        print(text.shown(content, bench, found, done))
    if args.json:
        write_json(content, args.json)
    return 0


__all__ = ['add_arguments', 'HELP', 'InputError', 'run']
