# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which hidden effects could be seen at all, told by the truth generator alone.

A drive and its twin without the effect get the same commands, load roughness and sensor noise.
Their readings differ by what the effect does; what another unit within three tolerances could do
as well is taken away by a linear fit. Both remainders count in noise deviations of the sensor.
"""
from __future__ import annotations

from test.truth import Campaign, make_campaign
from test.truth.sensors import noise_of, UNITS

from bench.campaigns import HOLDOUT, Task
import numpy as np
from scipy.optimize import lsq_linear

MOVES = 3.0         # noise deviations (rms) by which an effect must move some signal
BEYOND = 1.0        # of them beyond what another unit could do
_SIGMAS = 3.0
_RATE = 20.0        # Hz: enough for the fit of the unit
_JUDGED = ('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_inlet_flow', 'motor_speed',
           'load_torque', 'case_drain_flow', 'pump_speed')
_TABLES = {
    'pump.displacement_vs_command': ('pump', 'displacement_vs_command', 'displacement_cc_rev'),
    'pump.leakage': ('pump', 'leakage_L_min', 'table'),
    'motor.leakage': ('motor', 'leakage_L_min', 'table'),
    'motor.mechanical_efficiency': ('motor', 'mechanical_efficiency', 'table'),
    'loading.pump_mechanical_efficiency': ('loading', 'pump_mechanical_efficiency',
                                           'efficiency'),
    'loading.pprv_pressure': ('loading', 'pprv_pressure_vs_command', 'pressure_bar'),
    'motor.displacement': ('motor', 'displacement_cc_rev'),
    'motor.inertia': ('motor', 'inertia_total_kg_m2'),
    'line.bulk_modulus': ('line', 'bulk_modulus_Pa'),
    'pump.displacement_lag': ('pump', 'displacement_lag_s'),
    'loading.pprv_lag': ('loading', 'pprv_lag_s'),
    'loading.pprv_override': ('loading', 'pprv_override_bar_per_L_min'),
}


def visible(task: Task, made: Campaign) -> dict[str, dict[str, float]]:
    """
    Return, by hidden effect, by how much it 'moves' the signal that it moves most, and 'beyond'.

    Each effect is judged beside the others of its campaign.
    """
    if not task.effects:
        return {}
    options = {**task.options, 'rate_hz': _RATE, 'logs': tuple(
        name for name in made.logs if name != HOLDOUT), 'keep_exact': False}
    options.pop('rig_seed', None)
    command = {name: {'setpoint': np.zeros(len(exact['u'])), 'manual': exact['u'],
                      'pprv': _per_ms(made.logs[name], len(exact['u'])), 'closed': False}
               for name, exact in made.exact.items()}

    def readings(effects: dict, sheet: dict) -> list[np.ndarray]:
        twin = make_campaign(task.seed, effects, sheet=sheet, command=command, **options)
        return [np.concatenate([np.nan_to_num(np.asarray(columns[header])) / noise
                                for columns in twin.logs.values()])
                for header, noise in _judged(made.sheet, twin)]

    full = {name: {'size': size, 'form': made.truth['forms'][name],
                   'parameters': _own(made, name)} for name, size in task.effects.items()}
    whole = readings(full, made.sheet)
    columns = []
    for key, sigma in made.sheet['tolerances_1_sigma_relative'].items():
        moved = readings(full, _other_unit(made.sheet, key, 1 + sigma))
        columns.append(np.concatenate([a - b for a, b in zip(moved, whole)]))
    jacobian = np.column_stack(columns)
    found = {}
    for name in full:
        without = readings({key: value for key, value in full.items() if key != name}, made.sheet)
        found[name] = remainder([a - b for a, b in zip(whole, without)], jacobian)
    return found


def remainder(parts: list[np.ndarray], jacobian: np.ndarray) -> dict[str, float]:
    """
    Return by how much an effect moves a signal, and by how much beyond what another unit does.

    Parameters
    ----------
    parts : list of ndarray
        What the effect does to each signal, in noise deviations.
    jacobian : ndarray
        What one tolerance of each number does to all of them.

    """
    share = lsq_linear(jacobian, np.concatenate(parts), (-_SIGMAS, _SIGMAS)).x
    left = np.split(np.concatenate(parts) - jacobian @ share, len(parts))
    return {'moves': _most(parts), 'beyond': _most(left)}


def detectable(seen: dict[str, dict[str, float]]) -> bool:
    """Say whether every hidden effect of a campaign could be seen."""
    return all(entry['moves'] >= MOVES and entry['beyond'] >= BEYOND for entry in seen.values())


def _own(made: Campaign, name: str) -> dict[str, float]:
    """Return the SI parameters of one effect, so that a twin has the same ones."""
    from test.truth.catalogue import ALL
    return {key: made.truth['si_parameters'][key] for key in (*ALL[name].typical,
                                                              *ALL[name].fixed)}


def _per_ms(columns: dict, count: int) -> np.ndarray:
    """Return the PPRV command per millisecond from its recorded rows."""
    rows = np.searchsorted(columns['time[s]'], np.arange(count) / 1000 + 1e-6) - 1
    return np.asarray(columns['pprv_command[V]'])[np.maximum(rows, 0)]


def _judged(sheet: dict, twin: Campaign) -> list[tuple[str, float]]:
    headers = next(iter(twin.logs.values()))
    return [(f'{name}[{UNITS[name][0]}]', noise_of(sheet, name)[0]) for name in _JUDGED
            if f'{name}[{UNITS[name][0]}]' in headers]


def _most(parts: list[np.ndarray]) -> float:
    return float(max(np.sqrt(np.mean(part**2)) for part in parts))


def _other_unit(sheet: dict, key: str, factor: float) -> dict:
    """Return a datasheet with one toleranced quantity scaled."""
    def scaled(node, path):
        if path:
            return {**node, path[0]: scaled(node[path[0]], path[1:])}
        if isinstance(node, list):
            return [scaled(entry, ()) for entry in node]
        return node * factor

    return scaled(sheet, _TABLES[key])
