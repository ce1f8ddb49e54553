# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``simulate`` does: a scenario, or commands, on the model with noisy sensors."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from hst_drive.api import given
from hst_drive.channels import COMMANDS
from hst_drive.design.rehearse import INPUTS, rehearse
from hst_drive.errors import InputError
from hst_drive.load import load_scenario, LoadingUnit, parse_scenario
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.circuit_model import part_model, refuse_placeless
from hst_drive.report.effects import chosen
from hst_drive.rig import Rig
from hst_drive.rig.adopted import read_effects
import numpy as np


def play(rig: Rig, asked: Any, effects: Mapping[str, Any] | Iterable[str] | None,
         seed: int) -> Run:
    """
    Return the recording of a simulated run.

    Parameters
    ----------
    rig : Rig
        A whole drive.
    asked : Run, dict, str or path
        Commands, or a scenario: its mapping, its file or the name of a shipped one.
    effects : mapping or iterable of str, optional
        As for ``simulate``.
    seed : int
        Of everything random.

    """
    rig.require('pump', 'motor', 'line', 'relief_valve', 'loading', purpose='simulate')
    more: dict[str, Any]
    if isinstance(effects, Mapping):
        more = read_effects(given.sizes(effects, 'effects'), 'simulate', rig.sizes)
    else:
        more = {name: {} for name in given.ids(effects or (), 'effects') if chosen(name)}
    refuse_placeless(part_model(rig), more)
    if isinstance(asked, Run):
        return _commanded(rig, asked, more, seed)
    if isinstance(asked, Mapping):
        scenario = parse_scenario(dict(asked), LoadingUnit.of(rig.loading))
    else:
        scenario = load_scenario(asked, rig)
    run = rehearse(Drive(rig, {**scenario.hidden_effects, **more}), scenario, seed)
    kept = {*(rig.sensors or run.channels), *INPUTS}
    # It is not the scenario's file that holds it.
    return replace(run, source=f'{scenario.title}, seed {seed}', channels={
        name: values for name, values in run.channels.items() if name in kept})


def _commanded(rig: Rig, commands: Run, effects: Mapping[str, Any], seed: int) -> Run:
    for name in COMMANDS:
        if name not in commands:
            raise InputError(f'{commands.source}: {name} is missing; the model needs it')
        if not np.isfinite(commands[name]).all():
            raise InputError(f'{commands.source}: {name} has rows without a number; fill them')
    inputs = {name: commands[name] for name in INPUTS if name in commands}
    drive = Drive(rig, effects)
    temperature = inputs.setdefault(
        'oil_temperature', np.full(len(commands), rig.characterised_at))
    readings = SensorBank(rig, seed).read(
        {**drive.simulate(commands.time, inputs), 'oil_temperature': temperature})
    return Run(f'{commands.name}, simulated', commands.time, {**readings, **{
        name: inputs[name] for name in INPUTS[:2]}}, f'{commands.name}, simulated, seed {seed}')
