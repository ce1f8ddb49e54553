# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Days in the life of machines of the frozen generator, for ``bench.doses``."""
from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from bench.frozen import campaign, listed, profiles, sensors
from hst_drive.bag import read_log
from hst_drive.measure.run import Run
import numpy as np

_FIRST = 920_000    # seed
_LOGS = ('drilling', 'speed_sweep')
_ROUGH, _ROUGHER = 3e-3, 1e-2       # share of the load
_USUAL = 50.0       # degC
# What one number of a kind is at our typical size; leakages at 100 bar.
_TYPICAL = {'motor_leakage': lambda base: 4 / 3 * 1e-5 / base.q_nominal,
            'pump_leakage': lambda base: 4 / 3 * 1e-5 / base.q_nominal,
            'bearing_friction': lambda base: 12.0 / base.t_nominal,
            'pump_lag': lambda base: 0.08, 'entrained_air': lambda base: 0.015}


def day(machine: int, number: int, effect: str = '', dose: float = 0.0, *,
        celsius: float | None = None, rougher: bool = False) -> tuple[dict, list[Run]]:
    """Return datasheet and recordings of a machine on a day of its life."""
    fixed = {'rig': 'test rig', 'plain': True, 'each_ms': 10, 'seconds': 30.0,
             'roughness': _ROUGHER if rougher else _ROUGH}
    unit = campaign.setting([], [_FIRST, machine], **fixed)
    random = np.random.default_rng([_FIRST, machine, number])
    # A share of what leaks goes with the viscosity, each machine its own.
    base = unit.base._replace(visc_share=float(
        np.random.default_rng([_FIRST, machine]).uniform(0.0, 1.0)))
    here = campaign.setting([], [_FIRST + 1 + machine, number], **fixed)
    warmer = 0.0 if celsius is None else celsius - _USUAL
    here = here._replace(base=base, inputs={
        log: inputs._replace(oil=inputs.oil + warmer) for log, inputs in here.inputs.items()})
    kinds = [listed.KINDS[effect](random, base)] if effect else []
    sizes = [dose * _TYPICAL[effect](base)] if effect else []
    return unit.sheet, [_recorded(here, log, kinds, sizes) for log in _LOGS]


def _recorded(here: campaign.Setting, log: str, kinds: list, sizes: list[float]) -> Run:
    rows = campaign.simulate(here, campaign.with_faults(here.base, kinds, sizes), log, kinds)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f'{log}.csv'
        sensors.write(
            path, rows, sensors.clean(rows, here.inputs[log].oil, here.which, {}), here.which,
            here.inputs[log].target, here.each_ms, campaign.speed_noise(here, log),
            np.random.default_rng([*here.seed, 7, profiles.LOGS.index(log)]),
            here.base.p_top / 1e5, {}, here.missing)
        return read_log(path)
