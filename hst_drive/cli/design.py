# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``design``: the next test, for effects that the logs cannot tell apart.

Takes the rivals from a diagnosis, or from --effects, and writes a load and command profile of at
most two minutes within the rig's limits, for 'hst-drive run' or the nodes load_profile and
controller. Chosen is the test in which the rivals come out furthest apart after each has been
fitted to the other, the unit's tolerances included. Where no test will do, it names the sensor.
"""
from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hst_drive.cli.common import add_rig_argument, read_json, rig_of
from hst_drive.cli.output import (
    add_force_argument, add_json_argument, check_target, refuse_to_replace, table, write_json,
    write_yaml)
from hst_drive.errors import InputError
from hst_drive.units import from_si

if TYPE_CHECKING:
    from hst_drive.diagnose.design import Design

HELP = 'write the test that separates effects which the logs cannot'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('diagnosis', metavar='DIAGNOSIS.json', nargs='?',
                        help="what 'diagnose --json' wrote")
    parser.add_argument('-o', '--output', metavar='SCENARIO.yaml',
                        help='scenario file to write (default: show the advice only)')
    add_force_argument(parser, 'SCENARIO.yaml')
    add_rig_argument(parser)
    parser.add_argument('--effects', metavar='A,B',
                        help='tell these apart (default: what the diagnosis could not)')
    parser.add_argument('--duration', metavar='S', type=float, default=120.0,
                        help='longest test, 20 to 120 s (default: 120)')
    parser.add_argument('--closed-loop', action='store_true',
                        help='let the controller hold the speed (default: give its commands)')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Design and say what to expect."""
    from hst_drive.cli.diagnose import progress_line
    from hst_drive.diagnose.design import design
    from hst_drive.diagnose.rivals import by_name, matched, of_diagnosis, widened
    from hst_drive.diagnose.trials import limits

    wanted = [name.strip() for name in args.effects.split(',') if name.strip()] \
        if args.effects is not None else None
    if args.diagnosis is None and wanted is None:
        raise InputError('DIAGNOSIS.json or --effects: expected at least one of the two')
    if args.output:
        refuse_to_replace(args.output, args.force)
        check_target(args.output)
    rig = rig_of(args)
    if args.diagnosis is None:
        rivals = by_name(wanted, rig.sensors)
    else:
        diagnosis = read_json(args.diagnosis)
        rivals = of_diagnosis(diagnosis, args.diagnosis, wanted)
        if rivals is not None and diagnosis.get('rig_digest') not in (None, rig.digest):
            raise InputError(f'{rig.source or rig.name}: is not the rig that was diagnosed '
                             f"({diagnosis.get('rig')}); give that one with --rig")
    if rivals is None:
        said = (diagnosis.get('next_test') or {}).get('what') or \
            'nothing in it is ambiguous: there is nothing to separate'
        print(f"{args.diagnosis}: the verdict is '{diagnosis.get('verdict')}'; {said} "
              '(--effects A,B asks for a test that tells two apart)')
        return 0
    limits(rig)
    models = matched(rig, rivals)
    likely = len(models)
    if not rivals.asked:
        models = widened(rig, models, rivals.channels)
    result = design(rig, models, rivals.channels, duration=args.duration,
                    closed_loop=args.closed_loop, likely=likely, progress=progress_line())
    if args.output:
        write_yaml(result.content, args.output)
    if args.json:
        write_json(as_json(result, args.output), args.json)
    if args.json != '-':
        print(text(result, args.output))
    return 0


def text(result: Design, output: str | None) -> str:
    """Return the advice for a terminal."""
    from hst_drive.bag.topics import CHANNEL_FIELDS

    rivals = ', '.join(' + '.join(names) for names in result.rivals)
    lines = [f'to tell apart: {rivals}', '', sentence(result), '']
    lines += [f'test, {result.trial.duration:.0f} s: {result.trial.words}']
    if output:
        topics = ''.join(f' --topic {CHANNEL_FIELDS[name][0].name}' for name in result.sensors
                         if not CHANNEL_FIELDS[name][0].on)
        lines += [f"written to {output}; play it with 'hst-drive run {output}{topics}', then "
                  'diagnose its recording together with the first logs']
    lines += ['', 'what remains between the model of one and the fit of the other (sigma: '
              'linearised, as\nthe search ranks tests; played with noise it may be less):',
              _differences(result)]
    if result.options:
        lines += ['', 'significance expected with one more sensor (linearised):', table(
            ['channel', 'sigma'], sorted(result.options.items(), key=lambda item: -item[1]))]
    return '\n'.join(lines)


def sentence(result: Design) -> str:
    """Return the advice in a sentence or two."""
    worst = 'sigma for the worst pair, played with noise and judged together with plain drilling'
    apart = f'separates them ({result.significance:.1f} {worst})'
    if result.unclear:
        apart = ('separates the others; if it is '
                 + ' or '.join(map(' + '.join, result.unclear)) + ', a rival may remain')
        if result.gauges:
            apart += f": {' or '.join(result.gauges)} would tell"
    if result.advice == 'profile':
        return f'A test with the sensors that are there {apart}.'
    alone = ('No test within the limits is enough with the sensors that are there '
             f'({result.without_sensor:.1f} {worst})')
    if result.sensors:
        added = ' and '.join(f'a sensor for {name} (the rivals differ there by '
                             f'{_difference(result, name)})' for name in result.sensors)
        test = 'any test' if result.advice == 'sensor' else 'this test'
        return f'{alone}. With {added} {test} {apart}.'
    remedy = ' or '.join(result.gauges) or 'a measurement of the part itself'
    return f'{alone}, and no sensor that could be added changes that. The test below is the best '\
           f'there is; if it leaves them apart by too little, only {remedy} will tell.'


def _difference(result: Design, sensor: str) -> str:
    from hst_drive.measure.run import CHANNELS

    unit = CHANNELS[sensor].display
    return f'{from_si(result.difference(sensor), unit):.2g} {unit}'


def _differences(result: Design) -> str:
    from hst_drive.measure.run import CHANNELS

    rows = []
    for pair in result.pairs:
        names = (' + '.join(result.rivals[pair.truth]), ' + '.join(result.rivals[pair.rival]))
        signal = max(pair.differences, key=lambda name: pair.differences[name].floors)
        found, unit = pair.differences[signal], CHANNELS[signal].display
        rows.append([*names, signal, f'{from_si(found.rms, unit):.3g}',
                     f'{from_si(found.largest, unit):.3g}', unit, f'{found.floors:.1f}',
                     f'{pair.significance:.1f}'])
    return table(['if it is', 'and not', 'shows in', 'rms', 'largest', 'unit', 'times the noise',
                  'sigma'], rows)


def as_json(result: Design, output: str | None) -> dict:
    """Return the design in the form of schema hst_drive/design/2 (SI)."""
    return {
        'schema': 'hst_drive/design/2', 'advice': result.advice, 'sentence': sentence(result),
        'separates': result.rivals, 'significance': result.significance,
        'significance_without_sensor': result.without_sensor,
        'sensors': {name: {'difference': result.difference(name)} for name in result.sensors},
        'gauges': result.gauges, 'unclear': result.unclear,
        'sensor_options': result.options,
        'duration': result.trial.duration,
        'what': result.trial.words,
        'scenario_file': output,
        'scenario': result.content,
        'pairs': [{'if': result.rivals[pair.truth], 'not': result.rivals[pair.rival],
                   'significance': pair.significance,
                   'differences': {name: found._asdict()
                                   for name, found in pair.differences.items()}}
                  for pair in result.pairs],
    }
