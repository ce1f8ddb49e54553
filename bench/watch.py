# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often the watch alarms although nothing is missing: hours of drilling, simulated.

    python -m bench.watch --hours 120
    python -m bench.watch --hours 10 --rig config/rig/closed_rig.yaml

Every half hour another unit drills: tolerances and sensor offsets drawn as the rig file and the
accuracies say, the load a new rock every few seconds with roughness, the speed held loosely so
that it wanders. A closed circuit turns forwards and backwards by turns. The watch starts anew with
each unit, so its learning is part of the test.
"""
from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
import math
import time

from hst_drive.model import Drive, SensorBank
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig, load_rig, Rig
from hst_drive.watch.calibration import Calibration
from hst_drive.watch.figures import FLOW, PRESSURE, SPEED, TORQUE
from hst_drive.watch.naming import Signatures
from hst_drive.watch.residuals import Balances, LEAD
from hst_drive.watch.samples import accuracy_of
from hst_drive.watch.stream import Window
from hst_drive.watch.watch import Watch
import numpy as np
from scipy.signal import lfilter

SIGNALS = (SPEED, TORQUE, PRESSURE, FLOW, 'pump_command', 'pprv_command', 'oil_temperature')
CLOSED = (SPEED, 'motor_torque', 'line_a_pressure', 'line_b_pressure', 'charge_pressure',
          'pump_command', 'oil_temperature')
_RATE = 100
_SECOND = 1_000_000_000     # ns
_PIECE = 20.0       # s between two corrections of the command
_SPEED = 100 * np.pi / 30


def unit(rig: Rig, random: np.random.Generator) -> tuple[dict[str, float], dict[str, float]]:
    """Draw a unit: factors by tolerance, and what its sensors are off."""
    accuracy = accuracy_of(rig)
    factors = {name: 1.0 + sigma * random.standard_normal()
               for name, sigma in rig.scatter.items()}
    return factors, {PRESSURE: accuracy.pressure * random.standard_normal(),
                     FLOW: accuracy.flow * random.standard_normal(),
                     TORQUE: accuracy.torque * random.standard_normal()}


def drilling(rig: Rig, seed: int, minutes: float, effects=None, begin: float = 0.0
             ) -> Iterator[dict[str, np.ndarray]]:
    """Yield pieces of a recording of one unit, with ``effects`` from ``begin`` (min) on."""
    random = np.random.default_rng(seed)
    factors, offsets = unit(rig, random)
    drive, later = Drive(rig), Drive(rig, effects)
    drive.scale(factors)
    later.scale(factors)
    bank = SensorBank(replace(rig, effects={}), seed)
    level = random.uniform(1.5, 3.5)
    command = operating_point(drive, _SPEED, pprv_command=level).pump_command
    state = drive.initial_state(pump_command=command, pprv_command=level, speed=_SPEED)
    count = round(_PIECE * _RATE)
    warm, clock = random.uniform(-4, 4), 0.0
    rough = np.zeros(1)
    for _ in range(round(minutes * 60 / _PIECE)):
        drive = drive if clock < 60 * begin else later
        at = clock + np.arange(count + 1) / _RATE
        rock = np.minimum((np.arange(count + 1) / _RATE / random.uniform(2, 12)).astype(int), 9)
        pprv = random.uniform(0.8, 4.2, 10)[rock]
        pump = command + 0.03 * np.sin(2 * np.pi * at / 7) + random.uniform(-0.1, 0.1, 10)[rock]
        load, rough = lfilter([1.0], [1.0, -0.9], 0.9 * random.standard_normal(count + 1),
                              zi=rough)
        inputs = {'pump_command': pump, 'pprv_command': pprv, 'load_disturbance': load,
                  'oil_temperature': 323.15 + warm + 0 * at}
        exact = drive.simulate(at, inputs, state)
        exact['oil_temperature'] = inputs['oil_temperature']
        exact[PRESSURE] = exact[PRESSURE] + offsets[PRESSURE]
        exact[FLOW] = exact[FLOW] * (1.0 + offsets[FLOW])
        exact[TORQUE] = exact[TORQUE] + offsets[TORQUE]
        readings = bank.read({name: exact[name] for name in rig.sensors})
        # The last sample of a piece is the first of the next.
        yield {name: {**readings, **inputs, **{key: readings[key] for key in rig.sensors}}[
            name][:-1] for name in SIGNALS}
        command *= 1.0 + 0.5 * (_SPEED / np.mean(exact[SPEED]) - 1.0)
        clock += _PIECE


def reversing(rig: Rig, seed: int, minutes: float, effects=None, begin: float = 0.0
              ) -> Iterator[dict[str, np.ndarray]]:
    """Yield the same of a closed circuit: a piece forwards, a piece backwards."""
    random = np.random.default_rng(seed)
    factors, _ = unit(rig, random)
    accuracy = accuracy_of(rig)
    drive, later = (CircuitModel(rig, found, factors) for found in (None, effects))
    offsets = {name: size * random.standard_normal() for name, size in zip(
        CLOSED, (0.0, accuracy.torque, *3 * (accuracy.pressure,), 0.0, 0.0))}
    bank = SensorBank(replace(rig, effects={}), seed)
    state, memory = drive.at_rest(), np.full(drive.circuit.memory, math.nan)
    count, warm, way = round(_PIECE * _RATE), random.uniform(-4, 4), 1.0
    within = np.arange(count + 1) / _RATE
    moving = np.clip(np.minimum(within, _PIECE - within) / 2.0, 0.0, 1.0)
    ideal = rig.cross_port_relief.set_pressure * rig.motor.displacement
    for piece in range(round(minutes * 60 / _PIECE)):
        rock = np.minimum((within / random.uniform(2, 12)).astype(int), 9)
        load = random.uniform(0.05, 0.4, 10)[rock] * ideal * moving
        inputs = {'motor_torque': way * load, 'pump_command': way * (
            0.9 + (random.uniform(2.0, 6.0) + 0.2 * np.sin(within)) * moving),
            'oil_temperature': np.full(count + 1, rig.characterised_at + warm)}
        model = drive if piece * _PIECE < 60 * begin else later
        exact = {**model.run(piece * _PIECE + within, inputs, {}, state, memory=memory), **inputs}
        readings = bank.read({name: exact[name] for name in rig.sensors if name in exact})
        yield {name: ({**exact, **readings}[name] + offsets[name])[:-1] for name in CLOSED}
        way = -way


def watch_unit(rig: Rig, seed: int, minutes: float, effects=None, begin: float = 0.0,
               judged: Rig | None = None) -> tuple[int, list[str]]:
    """
    Return the watched blocks of one unit and what alarmed, each alarm once.

    It drills as drawn from ``rig`` and is judged by that, or by ``judged``.
    """
    judged = judged or rig
    closed = rig.circuit == 'closed'
    balances = Balances(judged, CLOSED if closed else SIGNALS)
    watch = Watch(Calibration(balances.spread, balances.correlation), Signatures(balances.model))
    alarms: list[str] = []
    held: dict[str, np.ndarray] | None = None
    before: tuple[str, ...] = ()
    second = 0
    for piece in (reversing if closed else drilling)(rig, seed, minutes, effects, begin):
        first = 0 if held is None else round(LEAD * _RATE)
        held = piece if held is None else {
            name: np.concatenate([held[name][-first:], values]) for name, values in piece.items()}
        lead = round(LEAD * _RATE)
        for start in range(lead, len(held[SPEED]) - _RATE + 1, _RATE):
            part = slice(start - lead, start + _RATE)
            second += 1
            window = Window(second * _SECOND, np.arange(lead + _RATE) / _RATE,
                            {name: values[part] for name, values in held.items()})
            inside = second * _SECOND + round(LEAD * _SECOND)
            block = balances.of(window, inside, inside + _SECOND)
            if isinstance(block, str):
                continue
            verdict = watch.add(block)
            new = set(verdict.failing) - set(before)
            named = ' or '.join(entry.effect for entry in verdict.effects)
            alarms += [f'unit {seed}, block {watch.blocks}: {name}: {named}'
                       for name in sorted(new)]
            before = verdict.failing
    return watch.blocks, alarms


def main() -> int:
    """Run the units and print hours and alarms."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--hours', type=float, default=120.0)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--minutes', type=float, default=30.0, help='per unit')
    parser.add_argument('--rig', help='file of a closed circuit; without it the test rig')
    args = parser.parse_args()
    rig = load_rig(args.rig) if args.rig else default_rig()
    blocks, alarms, units = 0, [], 0
    began = time.monotonic()
    while blocks < args.hours * 3600:
        done, found = watch_unit(rig, args.seed + units, args.minutes)
        units, blocks = units + 1, blocks + done
        alarms += found
        if found or units % 10 == 0:
            print(f'{units} units, {blocks / 3600:.1f} h, {len(alarms)} alarms, '
                  f'{time.monotonic() - began:.0f} s', *found, sep='\n  ', flush=True)
    print(f'{blocks / 3600:.1f} hours of drilling, {units} units, {len(alarms)} false alarms')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
