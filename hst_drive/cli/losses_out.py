# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What else the verb ``losses`` gives: the best motor for a duty, a fitted motor in a rig."""
from __future__ import annotations

import argparse
from collections.abc import Callable

from hst_drive.cli.output import refuse_to_replace, table, write_yaml
from hst_drive.errors import InputError
from hst_drive.losses.export import ends_of, motor_section
from hst_drive.losses.selection import Duty, select, ZONE
from hst_drive.losses.study import Study
from hst_drive.losses.table import Bench
from hst_drive.units import from_si, to_si
import numpy as np


def check(args: argparse.Namespace, bench: Bench) -> None:
    """Refuse impossible wishes before the work."""
    if args.temperature is not None and not -40.0 <= args.temperature <= 200.0:
        raise InputError(f'--temperature {args.temperature:g}: expected -40 to 200 degC')
    if args.duty:
        _duty(args.duty)
    if args.output:
        refuse_to_replace(args.output, args.force)
        _size(args, bench)
    elif args.motor is not None or args.rig:
        raise InputError('--motor and --rig say what -o writes; add -o RIG.yaml')


def _duty(texts: list[str]) -> list[Duty]:
    out = []
    for text in texts:
        try:
            numbers = [float(part) for part in text.split(':')]
        except ValueError:
            numbers = []
        if len(numbers) not in (2, 3) or not all(0 < value < 1e7 for value in numbers):
            raise InputError(f'--duty {text}: expected TORQUE:SPEED[:SHARE] in N.m and rpm, all '
                             "above 0, as '20:1200:0.6'")
        share = numbers[2] if len(numbers) == 3 else 1.0
        out.append(Duty(numbers[0], to_si(numbers[1], 'rpm'), share))
    return out


def _size(args: argparse.Namespace, bench: Bench) -> float:
    """Return the asked motor's displacement as the bench has it, m^3/rad."""
    _, sizes = bench.levels('size')
    if args.motor is None:
        if len(sizes) == 1:
            return float(sizes[0])
        raise InputError(f'-o {args.output}: the bench has motors of '
                         f'{_listed(sizes)} cc/rev; choose one with --motor')
    wanted = to_si(args.motor, 'cc/rev')
    near = int(np.argmin(np.abs(sizes - wanted)))
    if abs(sizes[near] / wanted - 1.0) > 0.01:
        raise InputError(f'--motor {args.motor:g}: the bench has motors of {_listed(sizes)} '
                         'cc/rev; choose one of these')
    return float(sizes[near])


def _listed(sizes: np.ndarray) -> str:
    return ', '.join(f'{from_si(value, "cc/rev"):.4g}' for value in sizes)


def _temperature(args: argparse.Namespace, bench: Bench) -> float:
    """Return the asked oil temperature, or the middle level of the table, K."""
    if args.temperature is not None:
        return to_si(args.temperature, 'degC')
    _, levels = bench.levels('temperature')
    return float(np.sort(levels)[len(levels) // 2])


def selection(args: argparse.Namespace, study: Study, oil: Callable) -> dict:
    """Return the motors for a duty, the best first."""
    temperature = _temperature(args, study.bench)
    found = select(study, _duty(args.duty), float(oil(temperature)))
    return {'oil_temperature': temperature, 'best': found[0].displacement,
            'motors': [{**entry._asdict(), 'zone': entry.zone._asdict()} for entry in found]}


def selection_text(content: dict) -> str:
    """Return the selection for people."""
    best = content['motors'][0]
    degc = from_si(content['oil_temperature'], 'degC')
    first = (f'For this duty at {degc:.0f} degC the motor of '
             f'{from_si(best["displacement"], "cc/rev"):.4g} cc/rev is the most efficient: '
             f'{100 * best["efficiency"]:.1f} % (95 %: {100 * best["low"]:.1f} to '
             f'{100 * best["high"]:.1f}).')
    if all(entry['outside'] for entry in content['motors']):
        first += ' No motor was measured at all points of the duty: this extrapolates.'
    rows = []
    for entry in content['motors']:
        at = entry['zone']
        bounds = '; '.join(f'{from_si(speed, "rpm"):.0f} rpm {low:.3g} to {high:.3g}'
                           for speed, low, high in at['bounds'])
        rows.append([f'{from_si(entry["displacement"], "cc/rev"):.4g}',
                     100 * entry['efficiency'],
                     from_si(max(point['pressure'] for point in entry['points']), 'bar'),
                     entry['outside'], 100 * at['best'], bounds])
    return (first + '\n' + table(
        ['cc/rev', 'efficiency %', 'highest bar', 'points outside bench', 'best %',
         f'reasonable zone (within {100 * ZONE:.0f} points of the best), N.m'], rows))


def write_rig(args: argparse.Namespace, study: Study, oil: Callable) -> str:
    """Write the fitted motor into a rig file and say so."""
    from hst_drive.rig import load_rig
    from hst_drive.rig.load import default_rig_file
    from hst_drive.rig.yaml_file import read_yaml

    size = _size(args, study.bench)
    temperature = _temperature(args, study.bench)
    source = args.rig or default_rig_file()
    load_rig(source)
    rig = read_yaml(source)
    old = dict(rig.get('motor') or {})
    section = motor_section(study, size, float(oil(temperature)), *ends_of(study, size))
    changed = []
    if not args.rig:
        changed = _scaled(rig, old, section['displacement_cc_rev'])
    rig['motor'] = {**old, **section}
    degc = float(f'{from_si(temperature, "degC"):.4g}')
    rig['characterised_at_oil_temperature_degC'] = degc
    rig['name'] = f'{rig.get("name", "rig")}, motor of {section["displacement_cc_rev"]:g} cc/rev'
    rig['provenance'] = {**(rig.get('provenance') or {}), 'motor': {
        'bench': study.bench.source, 'oil': args.oil, 'oil_temperature_degC': degc,
        'formulas': {name: entry.best[0].text for name, entry in study.searches.items()},
        'held_out_error_over_noise': {name: round(float(entry.error_after), 3)
                                      for name, entry in study.searches.items()},
        **({'scaled_to_the_motor': changed} if changed else {})}}
    if rig.get('effects') or rig.get('calibration'):
        for key in ('effects', 'calibration'):
            rig.pop(key, None)
        changed.append('effects and calibration of the old motor left out')
    write_yaml(rig, args.output)
    load_rig(args.output)
    return (f'Wrote {args.output}: the fitted motor of {section["displacement_cc_rev"]:g} cc/rev '
            f'at {degc:g} degC' + (f' ({"; ".join(changed)})' if changed else '') + '.')


def _scaled(rig: dict, motor: dict, displacement: float) -> list[str]:
    """
    Scale the shipped rig's load, inertia and gains to a motor of another size.

    So that the loading unit brakes it at the pressures that it brakes its own motor at, and the
    speed loop has the gain that it was tuned for.
    """
    ratio = displacement / motor['displacement_cc_rev']
    rig['loading']['gear_ratio'] = float(f'{rig["loading"]["gear_ratio"] * ratio:.6g}')
    motor['inertia_total_kg_m2'] = float(f'{motor["inertia_total_kg_m2"] * ratio**2:.6g}')
    for key in ('kp_V_per_rad_s', 'ki_V_per_rad'):
        rig['controller'][key] = float(f'{rig["controller"][key] * ratio:.6g}')
    return [f'loading.gear_ratio {rig["loading"]["gear_ratio"]:g}',
            f'motor.inertia_total_kg_m2 {motor["inertia_total_kg_m2"]:g}',
            f'controller gains x {ratio:.3g}']


__all__ = ['check', 'selection', 'selection_text', 'write_rig']
