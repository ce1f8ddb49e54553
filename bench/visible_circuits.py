# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which effects hidden on other circuits could be seen at all; see ``visible``."""
from __future__ import annotations

from test.truth.closed import catalogue, readings
from test.truth.closed.make import Campaign, make_campaign

from bench.visible import remainder
import numpy as np

_ROW = 50           # ms: enough for the fit of the unit
_NONE = 1e-6        # of an effect: its campaign keeps the oil that warms up


def visible(made: Campaign) -> dict[str, dict[str, float]]:
    """Return, by hidden effect, by how much it 'moves' a signal, and 'beyond' another unit."""
    truth = made.truth
    if not truth['sizes']:
        return {}
    logs = tuple(name for name in made.logs if name != 'holdout')
    command = {name: made.exact[name]['u'] for name in logs}
    warm = {name for name in truth['sizes'] if _known(made)[name].warm}

    def twin(sizes: dict[str, float], unit: dict[str, float]) -> list[np.ndarray]:
        return _read(make_campaign(
            truth['circuit'], truth['seed'], sizes, forms=truth['forms'], logs=logs, unit=unit,
            channels=[name for name in truth['channels'] if name != 'motor_displacement_command'],
            command=command, changes={'sheet': made.sheet}), logs)

    whole = _read(made, logs)
    tolerances = made.sheet['tolerances_1_sigma_relative']
    jacobian = np.column_stack([
        np.concatenate([a - b for a, b in zip(twin(truth['sizes'], {key: 1 + sigma}), whole)])
        for key, sigma in tolerances.items()])
    return {name: remainder([a - b for a, b in zip(whole, twin(
        {key: _NONE if key == name else size for key, size in truth['sizes'].items()
         if key != name or key in warm}, {}))], jacobian) for name in truth['sizes']}


def _known(made: Campaign) -> dict[str, catalogue.Effect]:
    circuit = made.truth['circuit']
    return {**catalogue.LISTED[circuit], **catalogue.OUTSIDE[circuit]}


def _read(made: Campaign, logs: tuple[str, ...]) -> list[np.ndarray]:
    """Return what sensors without noise read, in their noise, channel by channel."""
    known = _known(made)
    form = {key: chosen for name, chosen in made.truth['forms'].items()
            for key in (*known[name].typical, *(known[name].fixed or {}))}
    found = []
    for channel in made.truth['channels']:
        key, _, size, quantity = readings.CHANNELS[channel]
        if quantity and quantity != 'K':
            noise = size * made.sheet['sensors'][channel][f'noise_std_{quantity}']
            found.append(np.concatenate([readings.ideal(
                channel, made.exact[log][key][::_ROW], made.truth['si_parameters'], form)
                for log in logs]) / noise)
    return found
