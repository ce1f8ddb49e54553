# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""One campaign: the drive with and without its effects, of the size that the plan asks for."""
from typing import NamedTuple

from bench.unseen import datasheet, machine, profiles, recorder, stepper
from bench.unseen.fault import Drawn, Scale, scale_of
from bench.unseen.kernel import along, packed
from bench.unseen.plan import Plan, plan
import numpy as np

ATTEMPTS = 6
TRIES = 9


class Log(NamedTuple):
    """One log before the sensors: commands, ground, oil, and the controller's own noise."""

    given: profiles.Commands
    rock: np.ndarray
    noise: np.ndarray
    since: float
    seed: int


class Setting(NamedTuple):
    """Everything of a campaign but its effects."""

    seed: int
    asked: Plan
    sheet: dict
    off: dict[str, float]
    healthy: machine.Machine
    scale: Scale
    noise: dict[str, float]
    logs: tuple[Log, ...]
    total: float
    torque: float


class Run(NamedTuple):
    """One log of the drive: what happened, what the sensors saw, how warm the oil was."""

    out: np.ndarray
    readings: dict[str, np.ndarray]
    celsius: np.ndarray


class Found(NamedTuple):
    """A campaign with its effects: sizes, main values, runs, and how far each signal moved."""

    setting: Setting
    sizes: tuple[float, ...]
    values: tuple[float, ...]
    runs: tuple[Run, ...]
    moves: dict[str, float]
    moves_each: tuple[dict[str, float], ...]


def setting(seed: int, attempt: int = 0) -> Setting:
    """Return machine, ground and operators of a seed; later attempts drill harder rock."""
    asked = plan(seed)
    rng = np.random.default_rng([seed, 2])
    sheet, _ = datasheet.other_size(rng) if asked.other_size else (datasheet.TEST_RIG, 1.0)
    off = {} if asked.on_datasheet else datasheet.one_machine(sheet, rng)
    healthy = machine.build(sheet, off, {})
    rng = np.random.default_rng([seed, 3, attempt])
    full = float(healthy.stroke_values[-1] * healthy.prime_speed / healthy.displacement)
    grid = max(round(asked.row / stepper.TICK), round(healthy.control_ticks))
    logs, since = [], 0.0
    noise = recorder.noise_of(sheet)
    for name, seconds in zip(asked.names, asked.seconds):
        given = profiles.commands(name, seconds, grid, full, attempt > 0, rng)
        ticks = len(given.setpoint)
        logs.append(Log(given, profiles.roughness(ticks, rng),
                        noise['motor_speed'] * rng.standard_normal(ticks), since,
                        int(rng.integers(2 ** 31))))
        since += ticks * stepper.TICK
    strongest = along(max(log.given.pprv.max() for log in logs), healthy.pprv_commands,
                      healthy.pprv_pressures)
    torque = 1.3 * strongest * healthy.load_displacement * healthy.gear / 0.88
    return Setting(seed, asked, sheet, off, healthy, scale_of(healthy), noise, tuple(logs), since,
                   torque)


def _drive(where: Setting, log: Log, changes: dict, manual: np.ndarray) -> Run:
    """Run one log with the changes of the effects."""
    fields = {name: value for name, value in changes.items() if name in machine.Machine._fields}
    extra = {name: value for name, value in changes.items() if name not in fields}
    m = machine.build(where.sheet, where.off, fields)
    ticks = len(log.given.setpoint)
    rng = np.random.default_rng(log.seed)
    celsius = profiles.oil(ticks, log.since, extra, rng)
    visc = np.ones(ticks)
    if 'oil.law' in extra:
        visc = profiles.viscosity_ratio(celsius, extra['oil.law']) ** extra['oil.power']
    event = profiles.events(extra.get('event', ''), ticks, log.since, where.total, rng)
    loading = along(log.given.pprv[0], m.pprv_commands, m.pprv_pressures)
    out = stepper.run(stepper.at_rest(m, loading), log.given.setpoint, manual,
                      log.given.pprv, log.rock, event, visc, log.noise, log.since,
                      stepper.steps_for(m, where.torque), packed(m))
    if not np.isfinite(out).all():
        raise FloatingPointError(f'seed {where.seed}: the drive ran away')
    readings = recorder.seen(out, extra, event, log.since, where.total, log.seed)
    return Run(out, readings, celsius)


def simulate(where: Setting, changes: dict) -> tuple[tuple[Run, ...], dict[str, float]]:
    """
    Run all logs with the changes, and without them under the commands that the first gave.

    Returns
    -------
    tuple
        The runs with the changes, and for each channel of the logs the difference (rms over all
        logs) in standard deviations of the sensor's noise.

    """
    runs, squares, count = [], dict.fromkeys(where.noise, 0.0), 0
    for log in where.logs:
        ill = _drive(where, log, changes, log.given.manual)
        well = _drive(where, log, {}, ill.out[:, stepper.U].copy())
        begin = log.given.before
        for name in squares:
            squares[name] += float(np.sum((ill.readings[name] - well.readings[name])[begin:] ** 2))
        count += len(ill.out) - begin
        runs.append(ill)
    moves = {name: float(np.sqrt(total / count) / where.noise[name])
             for name, total in squares.items() if name not in where.asked.missing}
    return tuple(runs), moves


def _sized(where: Setting, one: Drawn, band: tuple[float, float]) -> tuple[float, dict] | None:
    """Return a size that moves the worst signal as far as asked; None where none does."""
    rng = np.random.default_rng([where.seed, 4, one.seed])
    wanted = float(np.exp(rng.uniform(*np.log([band[0] * 1.1, band[1] / 1.1]))))
    low, high = np.log([one.fault.low, one.fault.high])
    size, best = 0.6 * low + 0.4 * high, None
    for _ in range(TRIES):
        _, moves = simulate(where, one.at(float(np.exp(size)), where.scale)[1])
        # An effect may not come up at all, as where no pressure opens a valve.
        worst = max(*moves.values(), 1e-9)
        if best is None or abs(np.log(worst / wanted)) < abs(np.log(best[2] / wanted)):
            best = float(np.exp(size)), moves, worst
        if abs(np.log(worst / wanted)) < 0.15 and band[0] <= worst <= band[1]:
            break
        if worst < wanted:
            low = size
        else:
            high = size
        guess = size + np.log(wanted / worst)
        inside = low + 0.05 * (high - low) < guess < high - 0.05 * (high - low)
        size = guess if inside else 0.5 * (low + high)
        if high - low < 0.02:
            break
    return best[:2] if best[2] >= BARELY else None


# Below this an effect is not called one.
BARELY = 2.0


def find(seed: int) -> Found:
    """Return the campaign of a seed: the same at each call."""
    for attempt in range(ATTEMPTS):
        where = setting(seed, attempt)
        found = [_sized(where, one, band) for one, band in zip(where.asked.drawn,
                                                               where.asked.bands)]
        if None not in found:
            break
    else:
        raise RuntimeError(f'seed {seed}: no size of '
                           f'{[one.fault.id for one in where.asked.drawn]} shows')
    changes, values = {}, []
    for one, (size, _) in zip(where.asked.drawn, found):
        value, own = one.at(size, where.scale)
        changes.update(own)
        values.append(value)
    runs, moves = simulate(where, changes)
    return Found(where, tuple(size for size, _ in found), tuple(values), runs,
                 moves if changes else {}, tuple(each for _, each in found))
