# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Motor bench tables with a known hidden effect, by equations of their own.

Nothing of it comes from hst_drive: the oil follows Vogel's equation, gaps and frictions are
written in other forms than those that the tool fits, and motors scatter about their law of sizes.
"""
from dataclasses import dataclass, field

import numpy as np

HEADER = ('motor_displacement[cc/rev]', 'oil_temperature[degC]', 'load_torque[N.m]',
          'motor_speed[rpm]', 'supply_pressure[bar]', 'supply_flow[L/min]',
          'case_drain_flow[L/min]')
EFFECTS = ('elastic_leakage', 'orifice_leakage', 'hydrodynamic_drag', 'bearing_friction',
           'mixed_friction')


@dataclass
class Recipe:
    """What a table is made of: SI but cc/rev, degC, rpm where the name says so."""

    sizes_cc: tuple = (10.0, 16.0, 28.0)
    temperatures_degc: tuple = (40.0, 52.0, 65.0)
    speeds_rpm: tuple = (500.0, 750.0, 1000.0, 1250.0, 1500.0, 1750.0)
    pressures_bar: tuple = (50.0, 90.0, 130.0, 170.0, 210.0)
    gap: str = 'linear'
    friction: str = 'sum'
    effect: str = ''
    strength: float = 0.3
    scatter: float = 0.0
    noise: dict = field(default_factory=lambda: {
        'pressure': 5e-4, 'flow': 1.5e-3, 'torque': 2e-3, 'drain': 1e-2})
    numbers: dict = field(default_factory=dict)


def random_recipe(rng, effect=''):
    """Return a recipe of any kind."""
    count = int(rng.integers(1, 6))
    first = np.exp(rng.uniform(np.log(6.0), np.log(90.0)))
    sizes = np.round(first * np.exp(np.cumsum(rng.uniform(0.15, 0.5, count)) - 0.2), 1)
    warm = rng.uniform(30.0, 55.0)
    degrees = np.round(warm + np.cumsum(rng.uniform(7.0, 16.0, int(rng.integers(1, 5)))) - 7.0)
    top = rng.uniform(1000.0, 3000.0)
    speeds = np.round(np.linspace(top * rng.uniform(0.2, 0.45), top, int(rng.integers(5, 11))), -1)
    most = rng.uniform(130.0, 320.0)
    pressures = np.round(np.linspace(most * rng.uniform(0.15, 0.35), most,
                                     int(rng.integers(4, 8))), 1)
    scale = np.exp(rng.uniform(np.log(0.4), np.log(1.8)))
    return Recipe(
        tuple(sizes), tuple(degrees), tuple(speeds), tuple(pressures),
        str(rng.choice(['linear', 'plain', 'exponential', 'power'])),
        str(rng.choice(['sum', 'power', 'wilson', 'square root'])), effect,
        float(rng.uniform(0.2, 0.5)), float(rng.choice([0.0, 0.03, 0.06])),
        {'pressure': 4e-4 * scale, 'flow': 1.2e-3 * scale, 'torque': 2e-3 * scale,
         'drain': 1e-2 * scale},
        {'b': rng.uniform(0.0, 0.35), 'c': rng.uniform(0.08, 0.25), 'size': rng.uniform(-0.6, 0.9),
         'oil': rng.uniform(0.9, 1.0), 'slip': rng.uniform(0.02, 0.08),
         'split': rng.uniform(0.3, 0.6), 'constant': rng.uniform(0.005, 0.02),
         'load': rng.uniform(0.01, 0.03), 'viscous': rng.uniform(0.005, 0.025),
         'k': rng.uniform(0.5, 1.0)})


def viscosity_ratio(degc):
    """Return the viscosity over that at 50 degC, Vogel's equation with constants of a VG 46."""
    return np.exp(900.0 / (degc + 110.0) - 900.0 / 160.0)


def make(recipe, rng):
    """Return rows (as HEADER) and the truth: SI arrays of the losses, and of the hidden part."""
    number = {'b': 0.2, 'c': 0.15, 'size': -0.35, 'oil': 1.0, 'slip': 0.04, 'split': 0.45,
              'constant': 0.012, 'load': 0.018, 'viscous': 0.015, 'k': 0.7} | recipe.numbers
    grid = np.array([(s, t, p, n) for s in recipe.sizes_cc for t in recipe.temperatures_degc
                     for p in recipe.pressures_bar for n in recipe.speeds_rpm])
    cc, degc, bar, rpm = grid.T
    degc = degc + rng.normal(0.0, 0.15, len(degc))
    rpm = rpm + rng.normal(0.0, 0.5, len(rpm))
    bar = bar * (1.0 + rng.normal(0.0, 2e-3, len(bar)))
    own = {name: dict(zip(recipe.sizes_cc, np.exp(rng.normal(0.0, recipe.scatter,
                                                             len(recipe.sizes_cc)))))
           for name in ('leak', 'torque')}
    displacement, speed, pressure = cc * 1e-6 / (2 * np.pi), rpm * np.pi / 30, bar * 1e5
    middle_cc = np.exp(np.mean(np.log(recipe.sizes_cc)))
    size, fast = cc / middle_cc, rpm / max(recipe.speeds_rpm)
    hard = bar / max(recipe.pressures_bar)
    oil = viscosity_ratio(degc)
    flow_unit = middle_cc * 1e-6 / (2 * np.pi) * max(recipe.speeds_rpm) * np.pi / 30
    torque_unit = cc * 1e-6 / (2 * np.pi) * max(recipe.pressures_bar) * 1e5

    laminar = number['slip'] * flow_unit * size**number['size'] * hard / oil**number['oil']
    laminar *= {'linear': (1 + number['b'] * bar / 100) / (1 + number['c'] * (rpm / 1000 - 1)),
                'plain': 1.0, 'exponential': np.exp(1.3 * number['b'] * hard
                                                    - number['c'] * rpm / 1000),
                'power': (bar / 100)**(0.7 * number['b']) * (rpm / 1000)**-number['c']
                }[recipe.gap]
    laminar *= [own['leak'][value] for value in cc]
    friction = torque_unit * {
        'sum': (number['constant'] * size**-0.4 + number['load'] * hard
                + number['viscous'] * oil**number['k'] * fast),
        'power': (number['constant'] + number['load'] + number['viscous'])
        * hard**0.45 * fast**0.25 * oil**0.2 * size**-0.1,
        'wilson': number['constant'] + number['load'] * hard + number['viscous'] * oil * fast,
        'square root': number['constant'] + number['load'] * hard
        + number['viscous'] * np.sqrt(oil * fast * 1.2)}[recipe.friction]
    friction = friction * [own['torque'][value] for value in cc]

    hidden_flow, hidden_torque = np.zeros(len(cc)), np.zeros(len(cc))
    strength = recipe.strength
    if recipe.effect == 'elastic_leakage':
        stretch = 0.9 * strength
        hidden_flow = laminar * ((1 + stretch * hard)**3 - 1)
    elif recipe.effect == 'orifice_leakage':
        hidden_flow = strength * np.mean(laminar) * np.sqrt(hard) * size**(2 / 3)
    elif recipe.effect == 'hydrodynamic_drag':
        hidden_torque = 1.5 * strength * np.mean(friction / torque_unit) * torque_unit \
            * fast**2 * size**0.67
    elif recipe.effect == 'bearing_friction':
        hidden_torque = 1.6 * strength * np.mean(friction / torque_unit) * torque_unit * hard**1.6
    elif recipe.effect == 'mixed_friction':
        hidden_torque = 3.0 * strength * np.mean(friction / torque_unit) * torque_unit \
            * np.exp(-(fast / 0.3))
    external = number['split'] * (laminar + hidden_flow)
    leakage = laminar + hidden_flow
    torque = pressure * displacement - friction - hidden_torque
    flow = displacement * speed + leakage
    noise = {name: 1 + level * rng.normal(size=len(cc)) for name, level in recipe.noise.items()}
    torque_scatter = recipe.noise['torque'] * torque.max() * 0.4 * rng.normal(size=len(cc))
    rows = np.column_stack([cc, degc.round(1), torque + torque_scatter, rpm,
                            bar * noise['pressure'], flow * noise['flow'] * 6e4,
                            external * noise['drain'] * 6e4])
    truth = {'leakage': leakage, 'external': external, 'torque_loss': friction + hidden_torque,
             'hidden_flow': hidden_flow, 'hidden_torque': hidden_torque, 'torque': torque,
             'flow': flow}
    return rows, truth


def write(path, rows, drain=True):
    """Write a table as a CSV file, with or without the case drain flow."""
    columns = len(HEADER) - (0 if drain else 1)
    lines = [','.join(HEADER[:columns])]
    lines += [','.join(f'{value:.6g}' for value in row[:columns]) for row in rows]
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return path
