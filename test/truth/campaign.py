# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured campaigns with known hidden physics, made without the product's model."""

from __future__ import annotations

from dataclasses import dataclass, field
import json
from pathlib import Path

import numpy as np
import yaml

from . import catalogue, profiles, sensors, unit
from .kernel import OUT, run
from .terms import record

STATE_OF = {
    'motor_speed': 'w', 'motor_inlet_flow': 'q_motor', 'load_torque': 'torque',
    'pump_outlet_pressure': 'p1', 'motor_inlet_pressure': 'p2', 'motor_outlet_pressure': 'p_out',
    'pump_displacement': 'd_pump', 'pump_speed': 'w_pump', 'case_drain_flow': 'q_drain',
    'pump_command': 'u'}


@dataclass
class Campaign:
    """
    One campaign: what a user would have, and what only the maker knows.

    Attributes
    ----------
    logs : dict
        Log name to columns; a column is 'name[unit]' to its values (display units).
    truth : dict
        Hidden effects with sizes, forms and SI parameters, the unit's scatter, options.
    sheet : dict
        Datasheet of the rig, in the form of the rig's YAML file.
    exact : dict
        Log name to the noise-free states per millisecond (SI, names as in kernel.OUT).

    """

    logs: dict[str, dict[str, np.ndarray]]
    truth: dict
    sheet: dict
    exact: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)


def make_campaign(seed: int, effects: dict | None = None, on_datasheet: bool = False,
                  rate_hz: float = 100.0, channels: tuple[str, ...] | None = None,
                  duration: float = 60.0, *, temperature: str | dict = 'auto',
                  gentle: bool = False, rig_seed: int | None = None, sheet: dict | None = None,
                  jitter: float = 0.0, stamp_noise: float = 0.0, drop_out: float = 0.0,
                  sensor_filter: float = 0.0, delay: dict[str, float] | None = None,
                  noise: float = 1.0, roughness: float = 0.5,
                  logs: tuple[str, ...] = profiles.LOGS,
                  command: dict[str, dict] | None = None, unit_seed: int | None = None,
                  keep_exact: bool = True) -> Campaign:
    """
    Make the logs of one campaign.

    Parameters
    ----------
    seed : int
        Everything random follows from it. The same seed with other effects gives the same
        commands, unit, roughness and noise.
    effects : dict
        Identifier to relative size (1: typical), or to {'size', 'form', 'parameters'}.
    on_datasheet : bool
        True: the unit has the datasheet's numbers; False: another unit within tolerances.
    rate_hz : float
        Rows per second, 20 to 500.
    channels : tuple of str
        Measured channels beside time; None: the eight of the sample campaigns.
    duration : float
        Length of each log, s.
    logs : tuple of str
        Which of `profiles.LOGS` to make.
    temperature : str or dict
        'auto' (warm where an effect needs it), 'steady', 'warm', 'cold', 'constant_warm', or
        {log: (start, end)} in degC.
    gentle : bool
        Closed loop at 100 rpm in every log.
    rig_seed : int
        Makes a rig of another size (its datasheet is `Campaign.sheet`).
    sheet : dict
        A datasheet of one's own, instead.
    jitter, stamp_noise : float
        Scatter (s) of the sampling times, and of the stamps against them.
    drop_out : float
        Share of readings that are missing (NaN).
    sensor_filter : float
        Time constant (s) of a filter in every analogue sensor but speed.
    delay : dict
        Channel to delay (s).
    noise, roughness : float
        Sensor noise relative to the datasheet; load roughness (N m, one sigma).
    command : dict
        Log name to {'setpoint' rpm, 'manual' V, 'pprv' V, 'closed'} per ms, replaces the drawn.
    unit_seed : int
        The unit is that of another seed: the same machine on another day.
    keep_exact : bool
        False: do not keep the noise-free states (30 MB for four logs of 60 s).

    """
    if sheet is None:
        sheet = unit.datasheet() if rig_seed is None else unit.other_rig(rig_seed)
    factor = unit.scatter(sheet, np.random.default_rng(
        [seed if unit_seed is None else unit_seed, 3]), on_datasheet)
    tabs = unit.tables(sheet, factor)
    values = unit.numbers(sheet, factor)
    torque_scale = sheet['motor']['displacement_cc_rev'] / 195
    flow_scale = sheet['pump']['max_displacement_cc_rev'] / 28
    speed_scale = flow_scale / torque_scale
    chosen = catalogue.resolve(effects or {}, np.random.default_rng([seed, 2]),
                               (torque_scale, flow_scale, speed_scale))
    flat = dict.fromkeys(catalogue.parameters(), 0.0)
    flat.update({f'f_{name}': 0.0 for name in catalogue.ALL})
    for name, one in chosen.items():
        flat.update(one['si_parameters'])
        flat[f'f_{name}'] = float(catalogue.ALL[name].forms.index(one['form']))
    numbers = record({**values, **flat})
    if temperature == 'auto':
        temperature = 'warm' if any(n in catalogue.TEMPERATURE for n in chosen) else 'steady'
    options = {'channels': channels or sensors.STANDARD, 'stamp_noise': stamp_noise,
               'drop_out': drop_out, 'sensor_filter': sensor_filter, 'delay': delay or {},
               'noise': noise}
    shared = {'si_parameters': {k: v for one in chosen.values()
                                for k, v in one['si_parameters'].items()},
              'form': {k: one['form'] for one in chosen.values()
                       for k in one['si_parameters']}}
    measured, exact = {}, {}
    for name in logs:
        here = np.random.default_rng([seed, 10 + profiles.LOGS.index(name)])
        n = int(round(duration * 1000))
        do = (command or {}).get(name) or profiles.commands(name, n, here, gentle)
        grid_temp = profiles.temperature(name, n, temperature)
        heat = chosen.get('leakage_temperature')
        visc = profiles.viscosity_factor(grid_temp, heat['form'] if heat else '',
                                         flat['k_visc'])
        rough = profiles.roughness(n, here, roughness * torque_scale)
        sigma = sensors.noise_of(sheet, 'motor_speed')[0] * noise
        tick_noise = here.standard_normal((n + 9) // 10) * sigma
        setpoint = do['setpoint'] * unit.RPM * speed_scale
        out = run(numbers, *tabs, setpoint, do['manual'], do['closed'], do['pprv'], grid_temp,
                  visc, rough, tick_noise * unit.RPM, profiles.QUANTUM)
        states = {key: out[:, i] for i, key in enumerate(OUT)}
        signal = {channel: states[key] for channel, key in STATE_OF.items()}
        signal.update(pprv_command=do['pprv'], speed_setpoint=setpoint,
                      oil_temperature=grid_temp, motor_speed=states['w_filtered'],
                      speed_noise=tick_noise)
        times = sensors.sample_times(duration, rate_hz, jitter, here)
        measured[name] = sensors.sample(signal, times, sheet, shared, here, options)
        if keep_exact:
            exact[name] = states
    truth = {
        'effects': [n if n in catalogue.EFFECTS else f'unknown:{n}' for n in chosen],
        'si_parameters': shared['si_parameters'], 'unit_on_datasheet': on_datasheet,
        'forms': {n: one['form'] for n, one in chosen.items()},
        'sizes': {n: one['size'] for n, one in chosen.items()},
        'enters': {n: one['enters'] for n, one in chosen.items()},
        'depends_on': {n: one['depends_on'] for n, one in chosen.items()},
        'scatter': factor, 'seed': seed, 'rig_seed': rig_seed, 'rate_hz': rate_hz,
        'temperature': temperature, 'gentle': gentle,
    }
    return Campaign(measured, truth, sheet, exact)


def write_campaign(campaign: Campaign, folder: str | Path) -> Path:
    """Write one CSV per log, truth.json and the rig's datasheet rig.yaml; return the folder."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, columns in campaign.logs.items():
        table = np.column_stack(list(columns.values()))
        np.savetxt(folder / f'{name}.csv', table, fmt='%.9g', delimiter=',',
                   header=','.join(columns), comments='')
    (folder / 'truth.json').write_text(json.dumps(campaign.truth, indent=1) + '\n')
    (folder / 'rig.yaml').write_text(yaml.safe_dump(campaign.sheet, sort_keys=False))
    return folder
