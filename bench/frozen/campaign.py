# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One campaign: a unit, its logs, what is wrong with it and by how much, written to a folder."""
import json
from pathlib import Path
from typing import NamedTuple

from bench.frozen import datasheet, profiles, sensors, solve
from bench.frozen.kind import Kind
from bench.frozen.plant import build, Plant, RPM
import numpy as np

#: s, step of the solver. Half of it changes the readings by less than 1e-4 of their noise; by up
#: to 0.15 where relief valve, cavitation or a small accumulator make the small rig stiff.
STEP = 2e-4
#: How many times its noise the worst signal moves (root mean square over a log), and how often.
CLASSES = {'small': (1.5, 3.0, 0.2), 'typical': (3.0, 12.0, 0.6), 'strong': (12.0, 40.0, 0.2)}
#: ms between two rows: 500 to 20 Hz, 100 Hz more often than others.
ROWS_MS = (2, 4, 5, 8, 10, 10, 10, 20, 25, 50)


class Setting(NamedTuple):
    """All that is settled before what is wrong has its size."""

    sheet: dict
    base: Plant
    which: dict[str, sensors.Sensor]
    missing: tuple[str, ...]
    inputs: dict[str, profiles.Profile]
    each_ms: int
    seed: list[int]


def pick(options: tuple, rng: np.random.Generator) -> object:
    """Return one of the options."""
    return options[int(rng.integers(len(options)))]


def setting(kinds: list[Kind], seed: list[int], **fixed: object) -> Setting:
    """
    Draw rig, unit, channels, row rate and profiles.

    ``fixed`` overrules what is drawn: rig, on_datasheet, each_ms, seconds, roughness, plain (no
    channel is missing and none is added).
    """
    rng = np.random.default_rng([*seed, 1])
    name = pick(('test rig',) * 9 + tuple(datasheet.SIZES), rng)
    sheet = datasheet.rig(fixed.get('rig', name))
    exact = fixed.get('on_datasheet', rng.random() < 0.25)
    base = build(sheet, datasheet.unit(sheet, None if exact else np.random.default_rng(
        [*seed, 2])))
    each = pick([ms for ms in ROWS_MS if ms <= min((k.slowest_ms for k in kinds), default=50)],
                rng)
    needed = {name for kind in kinds for name in kind.needs}
    which = sensors.sensors(sheet)
    extra = {'motor_inlet_pressure': 0.15, 'pump_speed': 0.15, 'pump_displacement': 0.1,
             'case_drain_flow': 0.1}
    missing = {name for name, share in extra.items() if rng.random() > share}
    optional = ('motor_inlet_flow', 'oil_temperature', 'speed_setpoint', 'load_torque')
    if rng.random() < 0.3:
        missing.add(rng.choice(optional, p=[0.35, 0.3, 0.2, 0.15]))
    if fixed.get('plain'):
        missing = set(extra)
    missing -= needed
    seconds = pick((40.0, 60.0, 60.0, 60.0, 80.0), rng)
    roughness = float(np.exp(rng.uniform(np.log(1e-3), np.log(1e-2))))
    patch = float(np.exp(rng.uniform(np.log(0.05), np.log(0.5))))
    heavy = rng.random() < 0.4 or any(k.heavy for k in kinds)
    inputs = {log: profiles.draw(
        log, np.random.default_rng([*seed, 3, i]), datasheet.nominal_speed(sheet),
        fixed.get('seconds', seconds), any(k.wide for k in kinds),
        fixed.get('roughness', roughness), patch, heavy) for i, log in enumerate(profiles.LOGS)}
    return Setting(sheet, base, {n: s for n, s in which.items() if n not in missing},
                   tuple(sorted(missing)), inputs, fixed.get('each_ms', each), seed)


def speed_noise(here: Setting, log: str) -> np.ndarray:
    """Noise [rpm] of the speed reading, each millisecond."""
    rng = np.random.default_rng([*here.seed, 4, profiles.LOGS.index(log)])
    return rng.standard_normal(len(here.inputs[log].oil)) * here.which['motor_speed'].noise


def simulate(here: Setting, plant: Plant, log: str, kinds: list[Kind],
             command: np.ndarray | None = None) -> np.ndarray:
    """Run a log, or replay its commands; return the solver's rows."""
    given, i = here.inputs[log], profiles.LOGS.index(log)
    t = np.arange(len(given.oil)) * 1e-3
    shake = np.zeros(len(t))
    for kind in kinds:
        if kind.shake:
            shake = kind.shake(np.random.default_rng([*here.seed, 5, i]), t)
    angle = np.random.default_rng([*here.seed, 6, i]).uniform(0, 2 * np.pi)
    rows = solve.run(plant, given.target, given.manual if command is None else command,
                     given.pprv, np.column_stack([given.rough, given.oil, shake]),
                     speed_noise(here, log) * RPM, STEP, angle)
    if not np.isfinite(rows).all():
        raise FloatingPointError(f'{log}, seed {here.seed}: the solver lost its way')
    return rows


def with_faults(base: Plant, kinds: list[Kind], sizes: list[float]) -> Plant:
    """Return the machine with what is wrong."""
    for kind, size in zip(kinds, sizes):
        base = base._replace(**kind.plant(size))
    return base


def reading_faults(kinds: list[Kind], sizes: list[float], which: str) -> dict[str, list]:
    """Return the faults of readings by channel: ``sensor`` or ``word``."""
    faults: dict[str, list] = {}
    for kind, size in zip(kinds, sizes):
        for channel, fault in getattr(kind, which)(size).items():
            faults.setdefault(channel, []).append(fault)
    return faults


class Gauge:
    """How far a kind moves the readings of a setting, the same commands given."""

    def __init__(self, here: Setting) -> None:
        """Run the healthy machine."""
        self.here = here
        self.logs = [log for log in profiles.LOGS if 'holdout' not in log]
        self.healthy = {log: simulate(here, here.base, log, []) for log in self.logs}

    def said(self, rows: np.ndarray, log: str, kinds: list[Kind], sizes: list[float]) -> dict:
        """Return readings without noise, the converters' faults included."""
        here = self.here
        said = sensors.clean(rows, here.inputs[log].oil, here.which,
                             reading_faults(kinds, sizes, 'sensor'))
        t = np.arange(len(rows)) * 1e-3
        for channel, faults in reading_faults(kinds, sizes, 'word').items():
            for fault in faults:
                said[channel] = fault(t, said[channel], rows)
        said.pop('oil_temperature', None)
        return said

    def moves(self, kind: Kind, size: float) -> float:
        """Return the largest movement of a signal in its noise, root mean square over a log."""
        plant = with_faults(self.here.base, [kind], [size])
        worst = 0.0
        for log in self.logs:
            before = self.healthy[log]
            after = before if not kind.plant(size) else simulate(
                self.here, plant, log, [kind], before[::solve.SAMPLE, 0].copy())
            healthy, ill = (self.said(before, log, [], []), self.said(after, log, [kind], [size]))
            for name, values in healthy.items():
                off = np.sqrt(np.mean((ill[name] - values)[::3] ** 2))
                worst = max(worst, float(off) / self.here.which[name].noise)
        return worst

    def size(self, kind: Kind, goal: float, rng: np.random.Generator) -> tuple[float, float]:
        """Return the size that moves the worst signal so far, within 8 %, and its movement."""
        if kind.sizes:
            size = float(pick(kind.sizes, rng))
            return size, self.moves(kind, size)
        low, high = np.log(kind.low), np.log(kind.high)
        at, found = 0.5 * (low + high), (kind.low, 0.0)
        for _ in range(9):
            moved = self.moves(kind, float(np.exp(at)))
            found = float(np.exp(at)), moved
            miss = np.log(max(moved, 1e-6) / goal)
            if abs(miss) < 0.08:
                break
            if miss > 0:
                high = at
            else:
                low = at
            # Most movements go with the size: try that, within the bounds.
            guess = at - miss
            at = guess if low + 0.02 * (high - low) < guess < high - 0.02 * (high - low) \
                else 0.5 * (low + high)
        return found


def parameters(base: Plant, kinds: list[Kind], sizes: list[float]) -> dict:
    """Return the numbers of what is wrong, in SI units."""
    found = {}
    for kind, size in zip(kinds, sizes):
        found[kind.id] = {k: float(f'{v:.5g}') for k, v in
                          {**kind.plant(size), **kind.parameters(size)}.items()}
    return found


def write(folder: Path, here: Setting, kinds: list[Kind], sizes: list[float],
          truth: dict) -> None:
    """Write the logs, the rig where it is not the test rig, and the truth last."""
    folder.mkdir(parents=True, exist_ok=True)
    plant = with_faults(here.base, kinds, sizes)
    words = {name: faults[0] for name, faults in reading_faults(kinds, sizes, 'word').items()}
    for i, log in enumerate(profiles.LOGS):
        rows = simulate(here, plant, log, kinds)
        said = sensors.clean(rows, here.inputs[log].oil, here.which,
                             reading_faults(kinds, sizes, 'sensor'))
        sensors.write(folder / f'{log}.csv', rows, said, here.which, here.inputs[log].target,
                      here.each_ms, speed_noise(here, log),
                      np.random.default_rng([*here.seed, 7, i]), here.base.p_top / 1e5, words,
                      here.missing)
    if here.sheet['name'] != 'test rig':
        (folder / 'rig.yaml').write_text(datasheet.rig_text(here.sheet) + '\n', encoding='utf-8')
    (folder / 'truth.json').write_text(json.dumps(truth, indent=1) + '\n', encoding='utf-8')
