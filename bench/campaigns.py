# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated campaigns of the diagnosis benchmark: development and score seeds apart."""
from __future__ import annotations

import random
from test.truth import Campaign, EFFECTS, make_campaign, OUTSIDE
from test.truth.catalogue import TEMPERATURE
from test.truth.sensors import STANDARD
from typing import NamedTuple

from hst_drive.bag.align import finish_run
from hst_drive.measure.run import Run
from hst_drive.rig import Rig
from hst_drive.rig.load import parse_rig
from hst_drive.units import parse_header, to_si
import numpy as np

SEEDS = {'dev': 10_000, 'score': 18_700_000}    # scored: 700,000 to 17,700,000
ROUND = {'none': 12, 'single': len(EFFECTS), 'pair': 6, 'outside': len(OUTSIDE)}
ROUNDS = 5
HOLDOUT = 'drilling_holdout'
_MAY_MISS = ('motor_inlet_flow', 'load_torque', 'motor_speed', 'pump_outlet_pressure',
             'oil_temperature', 'speed_setpoint')
_MORE = ('motor_inlet_pressure', 'case_drain_flow', 'pump_speed')


class Task(NamedTuple):
    """One campaign: what kind, its seed, hidden effects with relative sizes, and options."""

    kind: str
    seed: int
    effects: dict[str, float]
    options: dict


def tasks(part: str, rounds: int = ROUNDS) -> list[Task]:
    """Return the campaigns of a part, always the same ones; a round has each effect once."""
    found = []
    names, outside = sorted(EFFECTS), sorted(OUTSIDE)
    for turn in range(rounds):
        seed = SEEDS[part] + 1000 * turn
        for kind, count in ROUND.items():
            for number in range(count):
                seed += 1
                draw = random.Random(seed)
                chosen = {'none': [], 'single': [names[number % len(names)]],
                          'pair': draw.sample(names, 2),
                          'outside': [outside[number % len(outside)]]}[kind]
                sizes = {name: round(draw.uniform(0.5, 1.5), 2) for name in chosen}
                options = _options(draw, seed)
                if any(name in TEMPERATURE for name in chosen):
                    options.pop('temperature', None)
                found.append(Task(kind, seed, sizes, options))
    return found


def _options(draw: random.Random, seed: int) -> dict:
    """Draw the unit, the rig and how it was recorded: half the campaigns are the usual ones."""
    options = {'on_datasheet': draw.random() < 0.25, 'rate_hz': 100.0}
    if draw.random() < 0.2:
        options['rig_seed'] = seed
    if draw.random() < 0.25:
        options['rate_hz'] = draw.choice([50.0, 200.0])
    if draw.random() < 0.25:
        options['temperature'] = draw.choice(['steady', 'warm', 'constant_warm'])
    if draw.random() < 0.1:
        options.update(jitter=5e-4, drop_out=0.01)
    kind = draw.random()
    if kind < 0.2:
        missing = draw.choice(_MAY_MISS)
        options['channels'] = tuple(name for name in STANDARD if name != missing)
    elif kind < 0.3:
        options['channels'] = (*STANDARD, draw.choice(_MORE))
    return options


def campaign(task: Task) -> Campaign:
    """Make what a user would have, and what only the maker knows."""
    return make_campaign(task.seed, task.effects, **task.options)


def as_runs(made: Campaign) -> tuple[Rig, list[Run], list[Run]]:
    """Return the rig, the logs to fit on and those held out, as a user gives them."""
    runs = {name: run_of(name, columns) for name, columns in made.logs.items()}
    held = runs.pop(HOLDOUT)
    return parse_rig(made.sheet), list(runs.values()), [held]


def run_of(name: str, columns: dict) -> Run:
    """Return the columns of a log (name[unit]) as a recording."""
    channels = {}
    for header, values in columns.items():
        channel, unit = parse_header(header)
        channels[channel] = to_si(np.asarray(values, dtype=float), unit)
    return finish_run(name, channels.pop('time'), channels, name, ())
