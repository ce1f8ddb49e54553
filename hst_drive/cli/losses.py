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
from typing import TYPE_CHECKING

from hst_drive.cli.output import add_force_argument, add_json_argument, say, write_json
from hst_drive.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from hst_drive.losses.table import Bench

HELP = 'steady-state losses of motors from a bench table: characteristics, trends, missing term'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bench', metavar='BENCH.csv', help='table of operating points')
    parser.add_argument('--channels', metavar='MAP.yaml',
                        help='foreign column names and units to ours, constants for all rows')
    parser.add_argument('--oil', metavar='GRADE', default='ISO VG 46',
                        help='viscosity grade, config/oil_grades.yaml (default: ISO VG 46)')
    parser.add_argument('--oils', metavar='OILS.yaml',
                        help='grades of yours, in a file like config/oil_grades.yaml')
    parser.add_argument('--temperature', type=float, metavar='DEGC',
                        help='of the oil, for --duty and --motor (default: middle of the table)')
    parser.add_argument('--duty', nargs='+', metavar='TORQUE:SPEED[:SHARE]',
                        help='which motor is best: points in N.m and rpm, share of the time')
    parser.add_argument('--motor', type=float, metavar='CC/REV',
                        help='the motor that -o writes (default: the only one)')
    parser.add_argument('-o', '--output', metavar='RIG.yaml',
                        help='write the fitted motor into a rig file')
    parser.add_argument('--rig', metavar='RIG.yaml',
                        help='the rig that the motor goes into (default: the shipped test rig, '
                             'its load scaled to the motor)')
    add_force_argument(parser, 'RIG.yaml')
    parser.add_argument('--plot', metavar='FOLDER|FILE.pdf',
                        help="draw the maps and the paper's figures 6 to 27: PNGs into a folder, "
                             'or all pages into one PDF')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print what the table says."""
    from hst_drive.bag.bench_table import read_points
    from hst_drive.losses.table import bench_of
    from hst_drive.report import transmissions as many
    from hst_drive.rig.oils import oil_of

    table = read_points(args.bench, args.channels)
    if many.is_transmissions(table):
        asked = [name for name in ('duty', 'output', 'plot') if getattr(args, name)]
        if asked:
            raise InputError(f'--{asked[0]}: {args.bench} is a table of transmissions without '
                             'flow and torque; give a motor bench table')
        content, shown = many.study_transmissions(table)
        _say_all(args.bench, table.notes)
    else:
        oil = oil_of(args.oil, args.oils)
        bench = bench_of(table.columns, table.headers, table.lines, table.constants,
                         table.source, oil)
        _say_all(args.bench, table.notes + bench.notes)
        content, shown = _motors(args, bench, oil)
    if args.json:
        write_json(content, args.json)
    if args.json != '-':
        print(shown)
    return 0


def _say_all(source: str, notes: tuple[str, ...]) -> None:
    for note in notes:
        say(f'{source}: {note}')


def _motors(args: argparse.Namespace, bench: Bench, oil: Callable) -> tuple[dict, str]:
    """Return the result of a motor bench table, as plain data and as text."""
    from hst_drive.cli import losses_out as out
    from hst_drive.losses.resistances import identify
    from hst_drive.losses.study import LEAST_ROWS, study
    from hst_drive.report import losses as text

    out.check(args, bench)
    found, done = identify(bench), None
    if len(bench) < LEAST_ROWS:
        asked = [name for name in ('duty', 'output', 'plot') if getattr(args, name)]
        if asked:
            raise InputError(f'{args.bench}: {len(bench)} rows determine no curves (at least '
                             f'{LEAST_ROWS}), which --{asked[0]} needs; measure more points')
        say(f'{args.bench}: {len(bench)} rows determine no curves (at least {LEAST_ROWS}); only '
            'the resistances of the rows follow')
    else:
        say(f'fitting {len(bench)} rows ...')
        done = study(bench)
    content = text.as_json(bench, args.oil, found, done)
    parts = [text.shown(content, bench, found, done)]
    if args.duty:
        content['selection'] = out.selection(args, done, oil)
        parts.append(out.selection_text(content['selection']))
    if args.output:
        parts.append(out.write_rig(args, done, oil))
    if args.plot:
        from hst_drive.report.loss_figures import draw

        for path in draw(done, args.plot, say):
            say(f'wrote {path}')
    return content, '\n\n'.join(parts)
