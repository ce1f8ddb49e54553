# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Write campaigns: `python -m test.truth.closed.make --circuit closed --seed 1 -o FOLDER`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
import json
import math
from pathlib import Path

import numpy as np
import yaml

from . import catalogue, circuit, readings, rigs, valve, work
from .common import STEP
from ..terms import record

KINDS = ('none', 'single', 'pair', 'unlisted')
KERNEL = {'closed': circuit, 'valve': valve}
CHANCE = {
    'closed': {'charge_pressure': 0.7, 'motor_torque': 0.75, 'pump_torque': 0.4,
               'pump_speed': 0.5, 'pump_displacement': 0.35, 'case_drain_flow': 0.4},
    'valve': {'pump_outlet_pressure': 0.4, 'motor_torque': 0.8, 'case_drain_flow': 0.4}}
DRIVER = ('pump_speed', 'pump_outlet_pressure')    # where measured, it may wander
GEAR = ('gear_backlash', 'gearbox_loss')    # need one
# a measurement that would take the effect in
BLIND = {'pump_speed_droop': 'pump_speed', 'supply_sag': 'pump_outlet_pressure'}
LIMIT = 2.5     # step times rate: beyond 2.78 a Runge-Kutta step of fourth order swings up


@dataclass
class Campaign:
    """One campaign: logs and datasheet as a user has them; truth and noise-free states."""

    logs: dict[str, dict[str, np.ndarray]]
    truth: dict
    sheet: dict
    exact: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)


def draw_effects(kind: str, name: str, rng: np.random.Generator) -> dict[str, float]:
    """Return {id: relative size} of a kind of campaign."""
    listed, outside = list(catalogue.LISTED[name]), list(catalogue.OUTSIDE[name])
    if kind == 'none':
        return {}
    if kind == 'unlisted':
        ids = [str(rng.choice(outside))]
    elif kind == 'pair':
        ids = [str(x) for x in rng.choice(listed, 2, replace=False)]
    else:
        ids = [str(rng.choice(listed))]
    low, high = (0.7, 1.6) if kind == 'pair' else (0.5, 2.0)
    return {i: round(float(np.exp(rng.uniform(np.log(low), np.log(high)))), 3) for i in ids}


def draw_channels(name: str, effects: list[str], rng: np.random.Generator) -> list[str]:
    """Return the measured channels: those that the effects need, others by chance."""
    known = {**catalogue.LISTED[name], **catalogue.OUTSIDE[name]}
    needed = {c for i in effects for c in known[i].needs}
    blind = {BLIND[i] for i in effects if i in BLIND}
    out = ['speed_setpoint', 'oil_temperature', 'line_a_pressure', 'line_b_pressure',
           'motor_speed']
    out.insert(0, 'pump_command' if name == 'closed' else 'valve_command')
    for channel, chance in CHANCE[name].items():
        if (rng.random() < chance or channel in needed) and channel not in blind:
            out.append(channel)
    return out


def machine(sheet: dict, factor: dict[str, float], chosen: dict[str, dict], rng, detail: float,
            channels: list[str]) -> dict[str, float]:
    """Return all numbers of a unit and of what is hidden in it (SI), as the kernels read them."""
    name, scale = sheet['circuit'], rigs.scales(sheet)
    known = {**catalogue.LISTED[name], **catalogue.OUTSIDE[name]}
    fast = 9.0 if name == 'closed' else 6.0
    seen = any(c in channels for c in DRIVER)
    flat = {**catalogue.blank(), **rigs.numbers(sheet, factor, rng, detail)}
    flat.update(
        k_visc=1.0, q_rated=scale['Q'], w_rated=scale['W'], t_rated=scale['T'],
        w_sign=0.008 * scale['W'], ff=fast / scale['W'], kp=0.08 * fast / scale['W'],
        ki=fast / scale['W'], droop0=(0.01 if seen else 0.0005) * detail,
        engine_torque=scale['P'] * flat.get('d_pump', 0.0) * 1.1 + 1e-9)
    for ident, one in chosen.items():
        flat.update(one['si_parameters'])
        flat[f'f_{ident}'] = float(known[ident].forms.index(one['form']))
    return flat


def finer(flat: dict[str, float]) -> int:
    """Return by what the solver's step must be divided, so that charge and check valves settle."""
    if 'v_charge' not in flat:
        return 1
    fastest = 1.1 * flat['bulk'] * (
        (flat['g_charge'] + flat['g_check0']) / flat['v_charge']
        + flat['g_check0'] / flat['volume'])
    return math.ceil(STEP * fastest / LIMIT)


def make_campaign(name: str, seed: int, effects: dict[str, float] | None = None, *,
                  kind: str = 'none', on_datasheet: bool = False, detail: float = 1.0,
                  noise: float = 1.0, duration: float = 40.0, forms: dict | None = None,
                  logs: tuple[str, ...] = work.LOGS, channels: list[str] | None = None,
                  refine: int = 1, changes: dict | None = None, unit: dict | None = None,
                  command: dict[str, np.ndarray] | None = None,
                  delay: dict[str, float] | None = None) -> Campaign:
    """
    Make one campaign of a circuit.

    Parameters
    ----------
    name : str
        closed or valve.
    seed : int
        Everything random follows from it; rig, unit and commands do not depend on what is hidden
        (but an effect of the gear needs a gear).
    effects : dict
        Identifier to relative size; None draws them.
    kind : str
        Of KINDS: what is drawn.
    on_datasheet : bool
        The unit has the datasheet's numbers.
    detail : float
        Size of what no datasheet tells (see rigs.numbers).
    noise : float
        Sensor noise relative to the datasheet.
    duration : float
        Length of each log, s.
    forms : dict
        Identifier to its form; others are drawn.
    logs : tuple of str
        Which of work.LOGS.
    channels : list of str
        Measured channels; None draws them.
    refine : int
        Divides the solver's step.
    changes : dict
        Numbers of the unit to set (SI, see machine), and 'sheet': a datasheet of one's own
        of that circuit.
    unit : dict
        Toleranced number to a factor on what this unit has.
    command : dict
        Log to its command per millisecond, V: nothing is controlled.
    delay : dict
        Channel to how late it is read, s.

    """
    changes = dict(changes or {})
    if effects is None:
        effects = draw_effects(kind, name, np.random.default_rng([seed, 2]))
    sheet = changes.pop('sheet', None) or rigs.draw(
        name, np.random.default_rng([seed, 1]), any(i in GEAR for i in effects))
    scale = rigs.scales(sheet)
    chosen = catalogue.resolve(name, effects, np.random.default_rng([seed, 3]), scale, forms)
    rng = np.random.default_rng([seed, 4])
    factor = {key: value * (unit or {}).get(key, 1.0)
              for key, value in rigs.scatter(sheet, rng, on_datasheet).items()}
    channels = channels or draw_channels(name, list(effects), np.random.default_rng([seed, 5]))
    if 'second_displacement_cc_rev' in sheet['motor']:
        channels = [*channels, 'motor_displacement_command']
    known = {**catalogue.LISTED[name], **catalogue.OUTSIDE[name]}
    warm = any(known[i].warm for i in effects)
    value = {k: v for one in chosen.values() for k, v in one['si_parameters'].items()}
    form = {k: one['form'] for one in chosen.values() for k in one['si_parameters']}
    flat = machine(sheet, factor, chosen, rng, detail, channels)
    if warm and 'k_visc' not in value:
        flat['k_visc'] = 0.0
    flat.update(changes)
    seen = any(c in channels for c in DRIVER)
    rate = float(np.random.default_rng([seed, 6]).choice([50.0, 100.0, 200.0]))
    measured, exact, heat = {}, {}, {}
    for log in logs:
        here = np.random.default_rng([seed, 10 + work.LOGS.index(log)])
        n = int(round(duration * 1000))
        do = work.commands(log, n, scale, here, flat['u_zero'], name, flat['d_second'] > 0)
        if command:
            do.update(manual=command[log], closed=False)
        degrees = work.temperature(n, warm, here)
        fluid = work.fluidity(degrees, form.get('k_visc', 'walther'), flat['k_visc'])
        engine = work.engine(n, (0.004 if seen else 0.0003) * detail, here)
        sigma = sheet['sensors']['motor_speed']['noise_std_rpm'] * rigs.RPM * noise
        tick = here.standard_normal((n + 9) // 10) * sigma
        d_motor = flat['d_motor'] + (flat['d_second'] - flat['d_motor']) * work.switched(
            do['small'])
        out = KERNEL[name].run(record(flat), do['setpoint'], do['manual'], do['closed'],
                               do['rock'], do['push'], fluid, degrees, engine, tick,
                               do['breakout'], d_motor, refine * finer(flat))
        states = {key: out[:, i] for i, key in enumerate(KERNEL[name].OUT)}
        states.update(setpoint=do['setpoint'], small=do['small'], temperature=degrees, noise=tick)
        measured[log] = readings.sample(states, channels, rate, sheet, value, form, here,
                                        noise, delay or {})
        exact[log] = states
        heat[log] = [round(float(degrees[0]), 2), round(float(degrees[-1]), 2)]
    listed = catalogue.LISTED[name]
    truth = {
        'effects': {i: s for i, s in effects.items() if i in listed},
        'unlisted': any(i not in listed for i in effects),
        'enters': {i: one['enters'] for i, one in chosen.items()},
        'depends_on': {i: one['depends_on'] for i, one in chosen.items()},
        'seed': seed, 'circuit': name, 'sizes': effects,
        'forms': {i: one['form'] for i, one in chosen.items()}, 'si_parameters': value,
        'look_alikes': {i: catalogue.look_alikes(name, i, channels) for i in chosen},
        'scatter': factor, 'unit_on_datasheet': on_datasheet, 'detail': detail,
        'rate_hz': rate, 'channels': channels, 'oil_temperature_degC': heat}
    return Campaign(measured, truth, sheet, exact)


def write_campaign(campaign: Campaign, folder: Path) -> Path:
    """Write one CSV per log, truth.json and rig.yaml; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for log, columns in campaign.logs.items():
        np.savetxt(folder / f'{log}.csv', np.column_stack(list(columns.values())), fmt='%.8g',
                   delimiter=',', header=','.join(columns), comments='')
    (folder / 'truth.json').write_text(json.dumps(campaign.truth, indent=1) + '\n')
    sheet = json.loads(json.dumps(campaign.sheet))    # no anchors of shared lists
    text = yaml.safe_dump(sheet, sort_keys=False, default_flow_style=None, width=99)
    (folder / 'rig.yaml').write_text(text)
    return folder


def main(argv: list[str] | None = None) -> None:
    """Read the arguments and write the campaigns of `count` seeds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--circuit', choices=('closed', 'valve'), default='closed')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--count', type=int, default=1)
    parser.add_argument('--kind', choices=KINDS, help='drawn from the seed when not given')
    parser.add_argument('--effect', help='id, id=size, or several by comma')
    parser.add_argument('--duration', type=float, default=40.0, help='of each log, s')
    parser.add_argument('--on-datasheet', action='store_true')
    parser.add_argument('--detail', type=float, default=1.0)
    parser.add_argument('-o', '--out', type=Path, required=True)
    a = parser.parse_args(argv)
    for i in range(a.count):
        seed, effects = a.seed + i, None
        rng = np.random.default_rng([seed, 7])
        kind = a.kind or str(rng.choice(KINDS, p=(0.15, 0.5, 0.2, 0.15)))
        if a.effect:
            effects = {}
            for item in a.effect.split(','):
                ident, _, size = item.partition('=')
                effects[ident] = float(size) if size else round(
                    float(np.exp(rng.uniform(np.log(0.5), np.log(2.0)))), 3)
        campaign = make_campaign(a.circuit, seed, effects, kind=kind, detail=a.detail,
                                 on_datasheet=a.on_datasheet, duration=a.duration)
        print(write_campaign(campaign, a.out / f'{i:04d}'))


if __name__ == '__main__':
    main()
