# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The next test as text and as JSON."""
from __future__ import annotations

from hst_drive.bag.topics import CHANNEL_FIELDS
from hst_drive.channels import CHANNELS
from hst_drive.design.design import Design
from hst_drive.report.terminal import table
from hst_drive.units import from_si


def text(result: Design, output: str | None, rig_file: str | None = None) -> str:
    """Return the advice for a terminal; the ``rig_file`` is what was given as --rig."""
    rivals = ', '.join(' + '.join(names) for names in result.rivals)
    lines = [f'to tell apart: {rivals}', '', sentence(result), '']
    lines += [f'test, {result.trial.duration:.0f} s: {result.trial.words}']
    if output:
        topics = ''.join(f' --topic {CHANNEL_FIELDS[name][0].name}' for name in result.sensors
                         if not CHANNEL_FIELDS[name][0].on)
        rig = f' --rig {rig_file}' if rig_file else ''
        lines += [f"written to {output}; play it with 'hst-drive run {output}{rig}{topics}', then "
                  'diagnose its recording together with the first logs']
    lines += ['', 'what remains between the model of one and the fit of the other (sigma: '
              'linearised, as\nthe search ranks tests; played with noise it may be less):',
              _differences(result)]
    if result.options:
        lines += ['', 'significance expected with one more sensor (linearised):', table(
            ['channel', 'sigma'], sorted(result.options.items(), key=lambda item: -item[1]))]
    return '\n'.join(lines)


def open_nothing(diagnosis: dict, source: str) -> str:
    """Say that a diagnosis leaves nothing to tell apart."""
    said = (diagnosis.get('next_test') or {}).get('what') or \
        'nothing in it is ambiguous: there is nothing to separate'
    return f"{source}: the verdict is '{diagnosis.get('verdict')}'; {said}"


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
    unit = CHANNELS[sensor].display
    return f'{from_si(result.difference(sensor), unit):.2g} {unit}'


def _differences(result: Design) -> str:
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
