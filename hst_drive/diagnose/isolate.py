# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where an unknown may enter, and how large it is over time.

A wrong equation moves the replayed signals in a direction of its own: oil that the pump side
loses lowers flow and speed together, oil lost in the hydromotor the speed alone, a missing
torque shows as pressure, a wrong load as torque alone, and a wrong torque reading as torque and
pressure together. How large the unknown is says the balance that it enters, fed with the other
measured signals: no motion that the model gets wrong blurs it.
"""
from __future__ import annotations

from typing import Container, NamedTuple

from hst_drive.channels import LINES, PRESSURES
from hst_drive.errors import InputError
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.zeros import as_read
from hst_drive.measure.circuit import CircuitReplay
from hst_drive.measure.part import PartReplay
from hst_drive.measure.turns import SLOW, turn
from hst_drive.measure.where import AT_NOISE
from hst_drive.model.circuits import Balance
from hst_drive.model.part import PartModel
import numpy as np
from scipy.ndimage import gaussian_filter1d

_QUIET = 1.5        # noise ratio above which a signal is moved by more than another's sensor
_ANGLE = ('motor_angle_cos', 'motor_angle_sin')
_LOAD = ('pprv_command', 'motor_speed', 'oil_temperature', 'load_torque', *_ANGLE,
         'pprv_command_rate', 'pprv_command_history', 'pprv_command_creep')
_TORQUE = (*PRESSURES[::-1], 'motor_speed', 'oil_temperature', *_ANGLE)
_PUMP = (*PRESSURES[::-1], 'pump_command', 'oil_temperature', 'pump_command_rate',
         'pump_command_history', 'pump_speed')


class Location(NamedTuple):
    """
    Where an unknown may enter.

    ``moves`` maps signals to how far they move per unit of the unknown, SI; ``reads`` are the
    variables that it may depend on, ``formula`` the effect that can carry it (or ''), ``balance``
    the balance of a part that shows its size and ``sign`` what that balance's error means.
    """

    name: str
    enters: str
    signal: str
    unit: str
    moves: dict[str, float]
    reads: tuple[str, ...]
    formula: str = ''
    balance: str = ''
    sign: float = 1.0


def locations(campaign: Campaign) -> list[Location]:
    """Return the locations that the channels can tell apart."""
    rig = campaign.rig
    if campaign.by_balance:
        return _parts(campaign)
    per_torque = 1.0 / (0.88 * rig.motor.displacement)
    flow, speed, pressure = 'motor_inlet_flow', 'motor_speed', 'pump_outlet_pressure'
    torque, displacement = 'load_torque', rig.motor.displacement
    outlet = 'motor_outlet_pressure'
    found = [
        Location('oil delivered by the pump', 'flow', flow, 'm^3/s',
                 {flow: 1.0, speed: 1.0 / displacement}, _PUMP, 'formula_pump_flow', 'pump flow'),
        Location('oil that turns the hydromotor', 'flow', speed, 'm^3/s',
                 {speed: 1.0 / displacement}, _TORQUE, 'formula_motor_flow', 'hydromotor speed',
                 displacement),
        Location('flow reading', 'sensor', flow, 'm^3/s', {flow: 1.0}, (flow, *_TORQUE),
                 'formula_flow_reading'),
        Location('torque of the hydromotor', 'torque', pressure, 'N.m', {pressure: -per_torque},
                 _TORQUE, 'formula_torque', 'hydromotor torque'),
        Location('return line', 'torque', outlet, 'Pa', {outlet: 1.0, pressure: 1.0}, _TORQUE),
        Location('load torque', 'load', torque, 'N.m', {torque: 1.0}, _LOAD, 'formula_load'),
        Location('torque reading', 'sensor', torque, 'N.m', {torque: -1.0, pressure: per_torque},
                 ('load_torque', *_TORQUE)),
    ]
    have = set(campaign.signals)
    kept: list[Location] = []
    for location in found:
        moves = {name: move for name, move in location.moves.items() if name in have}
        # Without its partner signal a sensor's location is that of the physical one.
        if moves and not (location.enters == 'sensor' and len(moves) < len(location.moves)):
            if not any(set(other.moves) == set(moves) and len(moves) == 1 and
                       other.enters == location.enters for other in kept):
                kept.append(location._replace(moves=moves, signal=next(iter(moves))))
    return kept


def _parts(campaign: Campaign) -> list[Location]:
    """Return one location per balance of the logs of a part."""
    displacement = campaign.drive.motor_displacement
    found = {}
    for replay in campaign.replays:
        for signal, entry in replay.balances.items():
            reads = _read(entry, isinstance(replay, CircuitReplay))
            sign = entry.sign * (displacement if entry.swept else 1.0)
            found[signal] = Location(entry.place, entry.enters, signal, entry.unit,
                                     {signal: 1.0 / sign}, reads, entry.formula, entry.name, sign)
    return list(found.values())


def _read(entry: Balance, in_circuit: bool) -> tuple[str, ...]:
    """Return what a missing term of a balance may depend on."""
    if in_circuit:
        return {'flow': (*LINES, 'motor_speed', 'pump_command', 'oil_temperature', 'pump_speed'),
                'torque': (*LINES, 'motor_speed', 'oil_temperature', *_ANGLE)}.get(
                    entry.enters, _PUMP)
    if any('pump_command' in need for need in entry.needs):
        return _PUMP
    if entry.enters == 'load':
        return _LOAD
    return ('motor_inlet_flow', *_TORQUE) if entry.name == 'line' else _TORQUE


def smooth_errors(campaign: Campaign, model: Fit) -> list[dict[str, np.ndarray]]:
    """Return model minus measurement over the floor, smoothed, log by log."""
    logs: list[dict[str, np.ndarray]] = [{} for _ in campaign.replays]
    for error, column in zip(model.errors, campaign.columns):
        logs[column.log][column.signal] = smooth(
            campaign, column.log, np.clip(column.weighed(error), -50, 50))
    return logs


def smooth(campaign: Campaign, log: int, values: np.ndarray) -> np.ndarray:
    """Return values of a log without what is faster than ``SLOW``; of a table as they are."""
    replay = campaign.replays[log]
    if replay.static:
        return values
    return gaussian_filter1d(values, max(SLOW / replay.run.sample_time, 0.5))


def _used(campaign: Campaign, log: int, signal: str) -> np.ndarray:
    used = np.zeros(len(campaign.replays[log].run), dtype=bool)
    for column in campaign.columns:
        if column.log == log and column.signal == signal:
            used[column.fit] = used[column.judge] = True
    return used


def only_read(campaign: Campaign, model: Fit, moves: Container[str]) -> bool:
    """Say whether a sensor may be at fault that moves these signals: the others are right."""
    ratios = campaign.ratios(model.errors, True)
    return all(value <= _QUIET for name, value in ratios.items() if name not in moves)


def locate(campaign: Campaign, model: Fit) -> Location | None:
    """Return the location whose direction holds most of the error; None if there is none."""
    errors = smooth_errors(campaign, model)
    best, most = None, 0.0
    kinds = [campaign.ratios(model.errors, held_out) for held_out in (True, False)]
    # Not where all that it moves is down to the noise while other signals are not.
    open_ = {name for name in {**kinds[0], **kinds[1]}
             if max(kind.get(name, 0.0) for kind in kinds) > AT_NOISE}
    for location in locations(campaign):
        moved = set(location.moves)
        if open_ and not open_ & moved:
            continue
        if location.enters == 'sensor' and not (only_read(campaign, model, moved)
                                                and moved <= (open_ or {*kinds[0]})):
            continue
        held = 0.0
        for index, log in enumerate(errors):
            size, weight = _project(campaign, index, log, location)
            held += float(size @ size) * weight
        # One more signal always holds more noise: a location must earn it.
        held *= 1.0 if len(moved) == 1 else 0.98
        if held > most:
            best, most = location, held
    return best


def _project(campaign: Campaign, index: int, errors: dict[str, np.ndarray],
             location: Location) -> tuple[np.ndarray, float]:
    """Return the size of the unknown over one log, and the weight of its square."""
    top: np.ndarray | float = 0.0
    bottom = 0.0
    for name, move in location.moves.items():
        if name in errors:
            scaled = move / campaign.floors[index][name]
            top = top - scaled * errors[name]
            bottom += scaled**2
    return top / max(bottom, 1e-30) * np.ones(len(campaign.replays[index].run)), bottom


def sizes(campaign: Campaign, model: Fit,
          location: Location) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the unknown over time in the location's unit, and which samples count, log by log."""
    errors = smooth_errors(campaign, model)
    values, counts = [], []
    for index in range(len(campaign.replays)):
        found = None if campaign.by_balance else _from_balance(campaign, model, location, index)
        if found is None:
            found = _project(campaign, index, errors[index], location)[0]
        used = _used(campaign, index, location.signal) & np.isfinite(found)
        values.append(smooth(campaign, index, np.where(used, found, 0.0)))
        counts.append(used)
    return values, counts


def _from_balance(campaign: Campaign, model: Fit, location: Location,
                  index: int) -> np.ndarray | None:
    """Return the error of the location's own balance; None if the log does not close it."""
    if not location.balance:
        return None
    part = PartModel(campaign.rig, campaign.switched(model.model), model.model.scales)
    part.zeros, part.delays = as_read(campaign.rig, model.model)
    try:
        replay = PartReplay(campaign.replays[index].run, part)
    except InputError:
        return None
    signal = next((name for name, balance in replay.balances.items()
                   if balance.name == location.balance), None)
    if signal is None or replay.static:
        return None
    own = campaign.replays[index].inputs.get('motor_angle')
    if own is not None and 'motor_angle' in replay.inputs:
        turn(replay, float(own[0] - replay.inputs['motor_angle'][0]))
    return location.sign * (replay.run[signal] - replay.predict(part)[signal])
