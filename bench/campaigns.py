# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated campaigns of the diagnosis benchmark: development and score seeds apart."""
from __future__ import annotations

import random
from test.truth import EFFECTS, make_campaign, OUTSIDE
from typing import NamedTuple

from hst_drive.measure.run import Run
from hst_drive.units import parse_header, to_si
import numpy as np

SEEDS = {'dev': 10_000, 'score': 700_000}
COUNTS = {'none': 40, 'single': 100, 'pair': 24, 'outside': 44}
VISIBLE = 3.0       # noise deviations (rms) by which a detectable effect moves some signal
# A command that moves shows what the PI hides in the speed: its noise is its resolution.
_NOISE = {'pump_outlet_pressure[bar]': 0.12, 'motor_inlet_flow[L/min]': 0.05,
          'motor_speed[rpm]': 0.15, 'load_torque[N.m]': 0.5, 'pump_command[V]': 0.0025}


class Task(NamedTuple):
    """One campaign: what kind, its seed, hidden effects with relative sizes, and options."""

    kind: str
    seed: int
    effects: dict[str, float]
    options: dict


def tasks(part: str) -> list[Task]:
    """Return the campaigns of a part of the benchmark, always the same ones."""
    found = []
    seed = SEEDS[part]
    names, outside = sorted(EFFECTS), sorted(OUTSIDE)
    for kind, count in COUNTS.items():
        for number in range(count):
            seed += 1
            draw = random.Random(seed)
            if kind == 'single':
                chosen = [names[number % len(names)]]
            elif kind == 'pair':
                chosen = draw.sample(names, 2)
            elif kind == 'outside':
                chosen = [outside[number % len(outside)]]
            else:
                chosen = []
            sizes = {name: round(draw.uniform(0.5, 1.5), 2) for name in chosen}
            options = {'on_datasheet': draw.random() < 0.25,
                       'rate_hz': draw.choice([100, 100, 100, 50, 200])}
            found.append(Task(kind, seed, sizes, options))
    return found


def campaign(task: Task) -> tuple[list[Run], list[Run], dict, float]:
    """
    Make a campaign.

    Returns
    -------
    runs, holdout : list of Run
    truth : dict
        What was hidden.
    visible : float
        By how many noise deviations (rms, training logs) the effects move the signal that they
        move most, against the same campaign without them.

    """
    made = make_campaign(task.seed, task.effects, keep_exact=False, **task.options)
    visible = 0.0
    if task.effects:
        bare = make_campaign(task.seed, {}, keep_exact=False, **task.options)
        for name, columns in made.logs.items():
            for header, noise in _NOISE.items():
                if name != 'drilling_holdout' and header in columns:
                    moved = np.asarray(columns[header]) - np.asarray(bare.logs[name][header])
                    # The difference of two noisy readings holds the noise twice.
                    power = float(np.nanmean(moved**2)) / noise**2
                    visible = max(visible, np.sqrt(max(power - 2.0, 0.0)))
    runs = {name: _run(name, columns) for name, columns in made.logs.items()}
    held = runs.pop('drilling_holdout')
    return list(runs.values()), [held], made.truth, float(visible)


def _run(name: str, columns: dict) -> Run:
    channels = {}
    for header, values in columns.items():
        channel, unit = parse_header(header)
        channels[channel] = to_si(np.asarray(values, dtype=float), unit)
    return Run(name, channels.pop('time'), channels, name)
