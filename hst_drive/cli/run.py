# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``run``: the nodes, each its own process, with a scenario, recorded in a bag.

SCENARIO is the name of a shipped scenario or a file. Simulated time runs as fast as it goes
unless --speed or --realtime says otherwise; the same scenario and seed then give the same bag.
Ctrl-C ends the run early and leaves a complete bag.
"""
from __future__ import annotations

import argparse
import sys

from hst_drive.cli.common import add_rig_argument
from hst_drive.cli.output import add_json_argument, say, table, write_json
from hst_drive.units import from_si

HELP = 'start the nodes with a scenario and record a bag'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('scenario', metavar='SCENARIO', help='name of a shipped one, or a file')
    parser.add_argument('-o', '--output', metavar='FOLDER',
                        help='rosbag2 folder to create (default: scenario and time of day)')
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument('--fast', action='store_true',
                      help='simulated time, as fast as it goes (default)')
    pace.add_argument('--speed', metavar='X', type=float,
                      help='simulated time, X seconds per second')
    pace.add_argument('--realtime', action='store_true', help='the clock on the wall')
    add_rig_argument(parser)
    parser.add_argument('--effect', metavar='ID.PARAMETER=VALUE', action='append', default=[],
                        help='hidden in the plant; SI, or with a unit: =5[L/min] (repeatable); '
                             'parameters of it that are not given have their typical values')
    parser.add_argument('--effects-from', metavar='S', type=float, default=0.0,
                        help='the hidden effects act from this time of the run on')
    parser.add_argument('--seed', type=int, help="of the sensors' noise (default: scenario's)")
    parser.add_argument('--duration', metavar='S', type=float, help='end earlier or later')
    parser.add_argument('--log', metavar='FILE', help='drilling log whose torque is the load, or '
                        "(scenario 'recorded') a recording: bag or CSV")
    parser.add_argument('--channels', metavar='MAP.yaml',
                        help="foreign names of that recording's channels to ours")
    parser.add_argument('--rate', metavar='HZ', type=float, default=100.0,
                        help='samples per second (default: 100)')
    parser.add_argument('--topic', metavar='NAME', action='append', default=[],
                        help='publish and record a reading that is off by default (repeatable)')
    parser.add_argument('--truth', action='store_true',
                        help='record the values without noise as well, under truth/')
    parser.add_argument('--priority', metavar='N', type=int, default=0,
                        help='real-time priority (3 to 99) for steady timing with --realtime; '
                        'needs root or an rtprio limit')
    parser.add_argument('--verbose', action='store_true', help='show what the nodes say')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Run the scenario and say how it went."""
    from hst_drive.nodes.plan import make_plan, Options
    from hst_drive.nodes.runner import execute, RunFailed

    plan = make_plan(Options(
        args.scenario, args.output, args.realtime, args.speed, args.rig, args.log, args.channels,
        effects=tuple(args.effect), effects_from=args.effects_from, seed=args.seed,
        duration=args.duration, rate=args.rate, topics=tuple(args.topic), truth=args.truth,
        priority=args.priority))
    for note in plan.notes:
        say(f'note: {note}')
    say(f'{plan.title}: {plan.duration:g} s, recording to {plan.output}')
    faults: list[str] = []

    def heard(name: str, line: str) -> None:
        # A fault is told again with each state of the stop that it brings about.
        fault = line.rpartition(']: ')[2].rpartition(';')[0]
        if args.verbose and name != 'run':
            say(f'  {name}: {line}')
        if name == 'run':
            say(f'note: {line}')
        elif name == 'controller' and '[ERROR]' in line and fault not in faults:
            faults.append(fault)
            say(f'note: the controller stopped the drive: {fault}')

    try:
        result = execute(plan, progress_line(plan.duration), heard)
    except RunFailed as problem:
        say(f'hst-drive run: {problem}')
        return 1
    result['controller_stopped'] = faults
    if args.json:
        write_json(result, args.json)
    if args.json != '-':
        print(report(result))
    return 130 if result['interrupted'] else 0


def progress_line(duration: float):
    """Return a function that shows the progress: a line that renews itself, or the last only."""
    def show(done: float, wall: float, last: bool) -> None:
        if last or sys.stderr.isatty():
            factor = f', {done / wall:.1f} x real time' if wall else ''
            print(f'\r{done:8.1f} of {duration:g} s{factor}   ', file=sys.stderr, flush=True,
                  end='\n' if last else '')

    return show


def report(result: dict) -> str:
    """Return the figures as text."""
    rows: list[tuple[str, object]] = [
        ('simulated time [s]', result['seconds']), ('messages', result['messages']),
        ('times real time', f"{result['real_time_factor']:.3g}")]
    speed = result['speed']
    if speed:
        rows += [('mean speed [rpm]', f"{from_si(speed['mean'], 'rpm'):.2f}"),
                 ('mean error [rpm]', f"{from_si(speed['mean_error'], 'rpm'):+.3f}"),
                 ('rms error [rpm]', f"{from_si(speed['rms_error'], 'rpm'):.3f}"),
                 ('worst excursion [rpm]', f"{from_si(speed['worst_error'], 'rpm'):+.2f} "
                  f"at {speed['worst_at']:.2f} s"),
                 ('counted from', f"{speed['from']:.2f} s, when the set point was reached; "
                  'after each jump of it, when it was reached again')]
    rows += [('the controller stopped the drive', fault) for fault in result['controller_stopped']]
    where = f"bag: {result['bag']}" if result['bag'] else 'nothing was recorded'
    head = 'interrupted; the bag is complete up to there\n' if result['interrupted'] else ''
    cells = [(name, value if isinstance(value, str) else f'{value:g}') for name, value in rows]
    return f"{head}{table(('run', ''), cells)}\n{where}"
