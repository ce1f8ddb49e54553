# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``margins``: how far the speed loop is from instability.

Linearises the drive over its operating range and prints the margins of the sampled PI loop with
the rig's gains, or with others. 'L at resonance' is the loop gain at the hydraulic resonance:
below -6 dB the resonance stays quiet whatever its phase is. With --choose, looks for the gains
with the best load rejection that keep 60 deg, 6 dB and a sensitivity peak of 2 everywhere.
"""
from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from hst_drive.cli.common import add_rig_argument, rig_of
from hst_drive.cli.output import add_json_argument, say, table, write_json
from hst_drive.errors import InputError

if TYPE_CHECKING:
    from hst_drive.control.margins import Margins, Plant
    from hst_drive.rig import Rig

HELP = 'stability margins of the speed controller over the operating range'
_RPM = math.pi / 30.0
_PHASE, _GAIN = math.radians(45.0), 10.0**(6.0 / 20.0)      # the least that the verdict accepts
_WANTED = {'phase_margin': math.radians(60.0), 'gain_margin': _GAIN, 'sensitivity_peak': 2.0}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_rig_argument(parser)
    parser.add_argument('--kp', type=float, metavar='V.s/rad', help="default: the rig's")
    parser.add_argument('--ki', type=float, metavar='V/rad', help="default: the rig's")
    parser.add_argument('--delay', type=int, default=0, metavar='SAMPLES',
                        help='samples between reading and command (default: 0)')
    parser.add_argument('--speed', type=float, nargs='+', metavar='RPM',
                        default=[25.0, 50.0, 100.0, 150.0], help='speeds (default: 25 50 100 150)')
    parser.add_argument('--load', type=float, nargs='+', metavar='N.m',
                        default=[0.0, 50.0, 100.0, 175.0, 250.0],
                        help='load torques (default: 0 50 100 175 250)')
    parser.add_argument('--choose', action='store_true', help='also look for better gains')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Print the table; leave with 0 whatever the verdict."""
    from hst_drive.control.margins import choose_gains, margins

    rig = rig_of(args)
    rig.require('pump', 'motor', 'line', 'loading', 'controller', purpose='the speed loop')
    kp = rig.controller.kp if args.kp is None else args.kp
    ki = rig.controller.ki if args.ki is None else args.ki
    if not (0.0 <= kp < math.inf and 0.0 <= ki < math.inf) or not 0 <= args.delay <= 100:
        raise InputError(f'--kp {kp:g} --ki {ki:g} --delay {args.delay}: expected numbers that '
                         'are not negative and a delay of at most 100 samples')
    step = rig.controller.sample_time
    points = _plants(rig, args.speed, args.load)
    plants = [plant for _, _, plant in points]
    found = [margins(plant, kp, ki, step, args.delay) for plant in plants]
    chosen = None
    if args.choose:
        try:
            chosen = choose_gains(plants, step, delay=args.delay, **_WANTED)
        except ValueError as error:
            say(str(error))
    if args.json != '-':
        print(_text(rig.name, kp, ki, points, found))
        if chosen:
            other = [margins(plant, *chosen, step, args.delay) for plant in plants]
            print(f'\n{_text(rig.name, *chosen, points, other)}')
    if args.json:
        write_json({'schema': 'hst_drive/margins/1', 'rig': rig.source or rig.name,
                    'kp': kp, 'ki': ki, 'delay_samples': args.delay,
                    'chosen': chosen and {'kp': chosen[0], 'ki': chosen[1]},
                    'points': [{'speed': speed, 'load_torque': load, 'margins': entry}
                               for (speed, load, _), entry in zip(points, found)]}, args.json)
    return 0


def _plants(rig: Rig, speeds: list[float],
            loads: list[float]) -> list[tuple[float, float, Plant]]:
    """Return speed (rad/s), load torque (N.m) and linear drive of each operating point."""
    from hst_drive.control.margins import Plant
    from hst_drive.model import Drive
    from hst_drive.model.steady import linearise, operating_point

    if any(not 0.0 < speed < 1e5 for speed in speeds) or any(not 0.0 <= m < 1e6 for m in loads):
        raise InputError('--speed, --load: expected speeds above 0 and below 1e5 rpm, found '
                         f'{", ".join(f"{speed:g}" for speed in speeds)}, and loads from 0 to 1e6 '
                         f'N.m, found {", ".join(f"{load:g}" for load in loads)}')
    drive = Drive(rig)
    points: list[tuple[float, float, Plant]] = []
    for speed in speeds:
        for load in loads:
            try:
                point = operating_point(drive, speed * _RPM, load)
            except InputError as error:
                say(f'left out: {speed:g} rpm, {load:g} N.m: {error}')
                continue
            torque = point.readings['load_torque']
            # Below the loading unit's least load there is one point, not several.
            if points and points[-1][0] == speed * _RPM and abs(points[-1][1] - torque) < 0.1:
                continue
            linear = linearise(drive, point)
            points.append((speed * _RPM, torque, Plant(linear.a, linear.b[:, 0], linear.c[0])))
    if not points:
        raise InputError('no operating point can be reached; choose other --speed and --load')
    return points


def _text(rig: str, kp: float, ki: float, points: list[tuple[float, float, Plant]],
          found: list[Margins]) -> str:
    rows = []
    for (speed, load, _), entry in zip(points, found):
        # A loop that is not stable has no margins: what a formula gives for them says nothing.
        phase, gain, peak = (math.degrees(entry.phase_margin), _decibel(entry.gain_margin),
                             entry.sensitivity_peak) if entry.stable else ('-', '-', '-')
        rows.append([speed / _RPM, load, entry.stable, phase, gain,
                     entry.crossover / (2 * math.pi), entry.resonance / (2 * math.pi),
                     entry.resonance_damping, _decibel(entry.resonance_gain), peak])
    return (f'{rig}: kp {kp:g} V.s/rad, ki {ki:g} V/rad\n'
            + table(['rpm', 'load N.m', 'stable', 'phase deg', 'gain dB', 'crossover Hz',
                     'resonance Hz', 'damping', 'L at resonance dB', 'Ms'], rows)
            + f'\n{_verdict(found)}')


def _verdict(found: list[Margins]) -> str:
    from hst_drive.control.margins import meets

    phase = math.degrees(min(entry.phase_margin for entry in found))
    gain = _decibel(min(entry.gain_margin for entry in found))
    quiet = _decibel(max(entry.resonance_gain for entry in found))
    unstable = sum(not entry.stable for entry in found)
    if unstable:
        return f'Unstable at {unstable} of {len(found)} operating points.'
    word = 'Well damped' if all(meets(entry, _PHASE, _GAIN) for entry in found) else \
        'Stable, but below 45 deg or 6 dB somewhere'
    return (f'{word}: at least {phase:.0f} deg and {gain:.1f} dB, loop gain at the resonance at '
            f'most {quiet:.1f} dB.')


def _decibel(factor: float) -> float:
    return 20.0 * math.log10(factor) if factor > 0.0 else -math.inf
