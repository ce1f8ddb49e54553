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
from datetime import datetime
from pathlib import Path
import shutil
import signal
import sys
import time

from hst_drive.cli.common import add_rig_argument, rig_of
from hst_drive.cli.output import add_json_argument, say, table, write_json
from hst_drive.errors import InputError

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
                        help='hidden in the plant; SI, or with a unit: =5[L/min] (repeatable)')
    parser.add_argument('--seed', type=int, help='of the sensors\' noise (default: scenario\'s)')
    parser.add_argument('--duration', metavar='S', type=float, help='end earlier or later')
    parser.add_argument('--log', metavar='FILE', help='drilling log whose torque is the load')
    parser.add_argument('--rate', metavar='HZ', type=float, default=100.0,
                        help='samples per second (default: 100)')
    parser.add_argument('--topic', metavar='NAME', action='append', default=[],
                        help='publish and record a reading that is off by default (repeatable)')
    parser.add_argument('--truth', action='store_true',
                        help='record the values without noise as well, under truth/')
    parser.add_argument('--verbose', action='store_true', help='show what the nodes say')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Run the scenario and say how it went."""
    plan = make_plan(args)
    for note in plan.notes:
        say(f'note: {note}')
    try:
        result = execute(plan, verbose=args.verbose)
    except RunFailed as problem:
        say(f'hst-drive run: {problem}')
        return 1
    print(report(result))
    if args.json:
        write_json(result, args.json)
    return 130 if result['interrupted'] else 0


class RunFailed(RuntimeError):
    """A node has died; the text says which, why, and what is left."""


class Plan(argparse.Namespace):
    """What a run consists of: ``parameters`` by node, ``output``, ``duration``, ``notes``."""


def make_plan(args: argparse.Namespace) -> Plan:
    """
    Turn arguments into the nodes' parameters.

    Raises
    ------
    InputError
        For anything that a node would refuse: nothing is started then.

    """
    from hst_drive.load import load_scenario
    from hst_drive.nodes import wiring
    from hst_drive.nodes.settings import effect_texts, parse_effects

    rig = rig_of(args)
    scenario = load_scenario(args.scenario, rig, args.log)
    duration = scenario.duration if args.duration is None else args.duration
    for name, value, low, high in (('--duration', duration, 0.1, 1e6),
                                   ('--rate', args.rate, 1.0, 1000.0),
                                   ('--speed', 1.0 if args.speed is None else args.speed,
                                    1e-3, 1e4)):
        if not low <= value <= high:
            raise InputError(f'{name} {value:g}: expected {low:g} to {high:g}')
    seed = scenario.seed if args.seed is None else args.seed
    if not 0 <= seed < 2**31:
        raise InputError(f'--seed {seed}: expected 0 to 2147483647')
    output = Path(args.output or f'{Path(args.scenario).stem}_{datetime.now():%Y%m%d_%H%M%S}')
    if output.exists():
        raise InputError(f'{output}: exists already; bags are not overwritten: choose another '
                         'name with -o or remove it')
    effects = {**scenario.hidden_effects, **parse_effects(args.effect)}
    wiring.readings(args.topic)
    rig_file = str(Path(args.rig).resolve()) if args.rig else ''
    source = Path(scenario.source)
    common = {'lockstep': not args.realtime, 'partners': list(wiring.NODES)}
    extra = {'extra_topics': args.topic or [''], 'truth': args.truth}
    start = _start(rig, effects, scenario)
    law = rig.controller
    notes = {'scenario': args.scenario, 'seed': seed, 'rig': rig.name,
             'effects': ' '.join(effect_texts(effects))}
    parameters = {
        'plant': {**common, **extra, 'rig': rig_file, 'seed': seed, 'rate': float(args.rate),
                  'duration': float(duration), 'speed': float(args.speed or 0.0),
                  'effects': effect_texts(effects) or [''], 'progress': True,
                  'start_speed': start[0], 'start_pprv_command': start[1]},
        'load_profile': {**common, 'scenario': str(source.resolve()), 'rig': rig_file,
                         'rate': float(args.rate),
                         'log': str(Path(args.log).resolve()) if args.log else ''},
        'controller': {**common, 'mode': scenario.mode, 'kp': law.kp, 'ki': law.ki,
                       'sample_time': law.sample_time, 'u_clamp_min': law.output_limits[0],
                       'u_clamp_max': law.output_limits[1], 'start_command': start[2]},
        'estimator': {**common, 'rig': rig_file},
        'recorder': {**common, **extra, 'output': str(output.resolve()),
                     'notes': [f'{key}={value}' for key, value in notes.items()]},
    }
    return Plan(parameters=parameters, output=output, duration=duration, notes=scenario.notes,
                title=scenario.title, closed_loop=scenario.mode == 'closed_loop')


def _start(rig, effects, scenario) -> tuple[float, float, float]:
    """Return speed (rad/s), PPRV command and pump command (V; -1: none) to start with."""
    rig.require('pump', 'motor', 'line', 'relief_valve', 'loading', 'controller',
                purpose='a run of the nodes')
    if scenario.start == 'rest':
        return 0.0, 0.0, -1.0
    from hst_drive.model import Drive
    from hst_drive.model.steady import operating_point

    speed, command = scenario.speed_setpoint(0.0), scenario.load.pprv_command(0.0)
    point = operating_point(Drive(rig, effects), speed, pprv_command=command)
    return float(speed), float(command), float(point.pump_command)


def execute(plan: Plan, verbose: bool = False) -> dict:
    """
    Run the nodes until the end, Ctrl-C or a failure; return the figures of the run.

    Raises
    ------
    InputError
        If a node refuses its parameters.
    RunFailed
        If a node dies; the bag is closed.

    """
    from hst_drive.nodes.session import NodeDied, Session

    signals: list[int] = []
    progress = {'time': 0.0, 'wall': 0.0, 'messages': 0}
    before = {number: signal.signal(number, lambda got, _: signals.append(got))
              for number in (signal.SIGINT, signal.SIGTERM)}
    died = None
    say(f'{plan.title}: {plan.duration:g} s, recording to {plan.output}')
    try:
        with Session(plan.parameters, lambda name, line: _hear(progress, name, line),
                     (lambda name, line: say(f'  {name}: {line}')) if verbose
                     else (lambda name, line: None)) as session:
            try:
                while not signals and not session.check():
                    _show(progress, plan.duration)
                    time.sleep(0.05)
                _show(progress, plan.duration, last=True)
            except NodeDied as problem:
                died = problem
            session.stop()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if died:
        _fail(plan, died, progress)
    return _figures(plan, progress, bool(signals))


def _hear(progress: dict, name: str, line: str) -> None:
    word, *numbers = line.split()
    if name == 'plant' and word == 'progress':
        progress['time'], progress['wall'] = map(float, numbers)
    elif name == 'recorder' and word == 'recorded':
        progress['messages'] = int(numbers[0])


def _show(progress: dict, duration: float, last: bool = False) -> None:
    if not sys.stderr.isatty() and not last:
        return
    done, wall = progress['time'], progress['wall']
    factor = f', {done / wall:.1f} x real time' if wall else ''
    print(f'\r{done:8.1f} of {duration:g} s{factor}   ', file=sys.stderr, flush=True,
          end='\n' if last else '')


def _fail(plan: Plan, died, progress: dict) -> None:
    from hst_drive.bag.mcap_bag import recover_command

    folder, kept = plan.output, ''
    if folder.is_dir() and not (folder / 'metadata.yaml').is_file():
        kept = f'; the bag was cut off, save it with: {recover_command(folder)}'
    elif folder.is_dir() and not progress['messages']:
        shutil.rmtree(folder)   # made by this very run, and nothing in it
    elif folder.is_dir():
        kept = (f"; {folder} holds the first {progress['time']:.1f} s, "
                f"{progress['messages']} messages")
    if died.code == 2 and died.lines:
        raise InputError(died.lines[-1])
    for line in died.lines:
        say(f'  {died.name}: {line}')
    why = f': {died.reason}' if died.reason else ''
    raise RunFailed(f'{died}{why}{kept}')


def _figures(plan: Plan, progress: dict, interrupted: bool) -> dict:
    import numpy as np

    from hst_drive.bag import read_log

    result = {'schema': 'hst_drive/run/1', 'bag': str(plan.output), 'interrupted': interrupted,
              'seconds': progress['time'], 'messages': progress['messages'],
              'real_time_factor': progress['time'] / progress['wall'] if progress['wall'] else 0.0,
              'speed': None}
    if not progress['messages']:
        if plan.output.is_dir():
            shutil.rmtree(plan.output)   # made by this very run, and nothing in it
        return {**result, 'bag': None}
    record = read_log(plan.output)
    if plan.closed_loop and 'motor_speed' in record and 'speed_setpoint' in record:
        speed, wanted = record['motor_speed'], record['speed_setpoint']
        near = np.flatnonzero(np.abs(speed - wanted) <= 0.02 * np.abs(wanted))
        if near.size:
            error = (speed - wanted)[near[0]:]
            worst = int(np.nanargmax(np.abs(error)))
            result['speed'] = {
                'unit': 'rad/s', 'from': float(record.time[near[0]] - record.time[0]),
                'mean': float(np.nanmean(speed[near[0]:])),
                'mean_error': float(np.nanmean(error)), 'rms_error': float(
                    np.sqrt(np.nanmean(error**2))), 'worst_error': float(error[worst]),
                'worst_at': float(record.time[near[0] + worst] - record.time[0])}
    return result


def report(result: dict) -> str:
    """Return the figures as text."""
    from hst_drive.units import from_si

    rows: list[tuple[str, object]] = [
        ('simulated time [s]', result['seconds']), ('messages', result['messages']),
        ('times real time', result['real_time_factor'])]
    speed = result['speed']
    if speed:
        rows += [('mean speed [rpm]', f"{from_si(speed['mean'], 'rpm'):.2f}"),
                 ('mean error [rpm]', f"{from_si(speed['mean_error'], 'rpm'):+.3f}"),
                 ('rms error [rpm]', f"{from_si(speed['rms_error'], 'rpm'):.3f}"),
                 ('worst excursion [rpm]', f"{from_si(speed['worst_error'], 'rpm'):+.2f} "
                  f"at {speed['worst_at']:.2f} s"),
                 ('counted from', f"{speed['from']:.2f} s, when the set point was reached")]
    where = f"bag: {result['bag']}" if result['bag'] else 'nothing was recorded'
    head = 'interrupted; the bag is complete up to there\n' if result['interrupted'] else ''
    return f"{head}{table(('run', ''), [(a, b if isinstance(b, str) else f'{b:g}') for a, b in rows])}\n{where}"
