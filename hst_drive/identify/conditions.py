# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a machine before its logs are looked at, for the conditions that they have."""
from __future__ import annotations

from typing import Mapping, NamedTuple, Sequence

from hst_drive.channels import CHANNELS
from hst_drive.effects import effect_of
from hst_drive.effects.base import OIL_POWER
from hst_drive.effects.leakage_temperature import brought, OIL_LAW, POWER, POWER_SIGMA
from hst_drive.effects.slots import LEAKS
from hst_drive.measure.run import Run
from hst_drive.rig import Rig
from hst_drive.rig.fingerprint import CONDITIONS
from hst_drive.rig.schema import UNTOLD, UNTOLD_WAVES
from hst_drive.units import from_si
import numpy as np

_TAILS = (5.0, 95.0)    # percent of the readings: what a log visits now and then is no condition
# Beyond what was commissioned: a share of the highest value there, and K for temperatures.
_ROOM, _ROOM_TEMPERATURE = 0.1, 5.0
# What a hydromotor loses of its torque follows the viscosity by a power whose one sigma this is:
# dry friction by 0, viscous drag by 1, and on sheets that is a tenth of all.
_TORQUE_POWER = 0.1
_OTHERWISE = 0.25   # of that: what may go with the pressure otherwise than all losses of the sheet
# Mineral oil is softer by half a percent of its bulk modulus a kelvin; one sigma, 1/K.
_SOFTER = 0.005
_OIL = [entry.name for entry in OIL_POWER]
Effects = Mapping[str, dict[str, float]]


class Outside(NamedTuple):
    """A channel whose values (SI) lie beyond those that a machine was commissioned for."""

    channel: str
    low: float
    high: float
    commissioned_low: float
    commissioned_high: float

    @property
    def told(self) -> str:
        """Return it for people."""
        unit = CHANNELS[self.channel].display
        low, high, first, last = (f'{from_si(value, unit):.4g}' for value in self[1:])
        return f'{CHANNELS[self.channel].title} {low} to {high} {unit} (there {first} to {last})'


class Oil(NamedTuple):
    """
    The oil of some logs, and how a machine's leaks go with it.

    ``ratio`` is its median viscosity over that of the tables, 0 if not known; ``leaks`` are the
    ``OIL_POWER`` of new leaks: of a commissioned machine the power that was learnt, or that of
    any gap.
    """

    ratio: float
    leaks: dict[str, float]

    def within(self, values: dict[str, float]) -> dict[str, float]:
        """Return parameters of an effect, of a leak as this machine's go with their oil."""
        bare = {key: value for key, value in values.items() if key not in _OIL}
        return {**bare, **self.leaks} if len(bare) < len(values) else values

    def brought(self, effects: Effects) -> dict[str, dict[str, float]]:
        """Return adopted effects, leaks as large as they are in this oil."""
        return {name: brought(values, self.ratio) if self.ratio and _follows(values)
                else dict(values) for name, values in effects.items()}


class Prior(NamedTuple):
    """
    Factors of the unit: expected ones, how far off (share, one sigma), and their ties.

    ``torque`` is the share of its torque by which other oil may brake the hydromotor, one sigma.
    """

    expected: dict[str, float]
    sigmas: dict[str, float]
    ties: dict[tuple[str, str], float]
    oil: Oil
    torque: float = 0.0


def _follows(values: Mapping[str, float]) -> bool:
    """Say whether an effect of these parameters is a leak that follows the oil."""
    return bool(values.get(_OIL[0]))


def moved(effects: Effects, scales: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """
    Return the adopted leaks that follow the oil where factors of the unit move leakages.

    What is not known of the oil moves them as it moves what the table leaks there.
    """
    leaks = {}
    for name, values in effects.items():
        effect = effect_of(name)
        factor = scales.get(LEAKS.get(effect.slot, ''), 1.0)
        if _follows(values) and factor != 1.0:
            leaks[name] = {**values, effect.size.name: factor * values[effect.size.name]}
    return leaks


def prior(rig: Rig, runs: Sequence[Run], waves: bool = False) -> Prior:
    """
    Return what is known of the unit's factors, beside ``rig.calibration``.

    Where the oil is warmer or colder than it usually was when a machine was commissioned, its
    leakages are known no better than the power with which they follow the viscosity: any, or one
    that was learnt; so it is where a leak was adopted in other oil. Its torque losses and its
    bulk modulus are less well known, too. With ``waves`` those of the pump's displacement are
    asked for.
    """
    sigmas = {key: value for key, value in {
        **UNTOLD, **(UNTOLD_WAVES if waves else {}), **rig.scatter}.items() if value > 0}
    reach = reach_of('oil_temperature', runs, (50.0,))
    ratio = float(rig.viscosity_ratio(reach[0])) if reach else 0.0
    if not rig.fingerprint:
        return Prior({}, sigmas, {}, Oil(ratio, {}))
    expected, most, warmer = _thinner(rig, runs)
    learnt = rig.effects.get(OIL_LAW, {'exponent': POWER})['exponent']
    power, unsure = (0.0, rig.fingerprint.oil_law) if OIL_LAW in rig.effects else (
        POWER, POWER_SIGMA)
    furthest = max(map(abs, (most, *(
        float(np.log(values[_OIL[1]] / ratio)) for values in rig.effects.values()
        if ratio and _follows(values)))))
    # Both the power is not known, and one factor stands for all temperatures of these logs.
    spread = np.hypot(unsure * furthest, power * (most - expected))
    (lost, lost_loading), off = _torque_lost(rig), _TORQUE_POWER * abs(most)
    spreads = {key: value for key, value in {
        **dict.fromkeys(LEAKS.values(), spread),
        'line.bulk_modulus': _SOFTER * warmer,
        'motor.mechanical_efficiency': _OTHERWISE * off * lost,
        'loading.pump_mechanical_efficiency': off * lost_loading}.items() if key in sigmas}
    if off * lost:
        spreads['motor.torque_loss'] = off
    wider = {**sigmas, **{key: float(np.hypot(sigmas.get(key, 0.0), more))
                          for key, more in spreads.items()}}
    shrunk = {key: sigmas.get(key, 0.0) / wider[key] for key in spreads}
    return Prior({key: float(np.exp(power * expected)) for key in LEAKS.values()
                  if key in sigmas}, wider, {
        (one, other): value if one == other else (
            value * shrunk.get(one, 1.0) * shrunk.get(other, 1.0))
        for (one, other), value in rig.fingerprint.correlation.items()},
        Oil(ratio, dict(zip(_OIL, (learnt, ratio))) if ratio and learnt else {}),
        off * lost)


def _torque_lost(rig: Rig) -> list[float]:
    """Return the share of its torque that hydromotor and loading pump usually take away."""
    sheets = (rig.motor and rig.motor.mechanical_efficiency.z,
              rig.loading and rig.loading.pump_mechanical_efficiency.y)
    return [0.0 if values is None else float(1.0 / np.median(values) - 1.0) for values in sheets]


def _thinner(rig: Rig, runs: Sequence[Run]) -> tuple[float, float, float]:
    """
    Return by what factor (log) oil is thinner than when learnt: usually, and at most.

    And how much warmer or colder it is, K.
    """
    reach = reach_of('oil_temperature', runs, (_TAILS[0], 50.0, _TAILS[1]))
    if 'oil_temperature' not in rig.fingerprint.conditions or reach is None:
        return 0.0, 0.0, 0.0
    there = rig.fingerprint.conditions['oil_temperature']
    # One factor stood for all oil there, or a law: only what lies beyond is new.
    usual = reach[1] if OIL_LAW in rig.effects else rig.characterised_at
    learnt = np.clip([reach[0], usual, reach[2]], *there)
    thinner = np.log(rig.viscosity_ratio(learnt) / rig.viscosity_ratio(np.array(reach)))
    return (float(thinner[1]), float(thinner[np.abs(thinner).argmax()]),
            float(np.abs(reach - learnt).max()))


def faults_of(rig: Rig) -> dict[str, dict[str, float]]:
    """Return what a rig has adopted; how its leakages go with its oil was learnt, no fault."""
    return {name: dict(values) for name, values in rig.effects.items()
            if name != OIL_LAW or not rig.fingerprint}


def learnt(rig: Rig) -> set[str]:
    """Return the effects that were adopted from logs; others are the file's, as its tables are."""
    past = rig.provenance.get('adopted')
    told = [entry.get('intervals_95_percent') for entry in past if isinstance(entry, dict)] \
        if isinstance(past, list) else []
    found = {name for sizes in told if isinstance(sizes, dict) for name in sizes}
    return {name for name in rig.effects if name in found or name not in faults_of(rig)}


def thinning(rig: Rig, runs: Sequence[Run]) -> float:
    """Return by what factor (log) the oil of some logs is thinner at its warmest."""
    cold, warm = rig.viscosity_ratio(np.array(reach_of('oil_temperature', runs)))
    return float(np.log(cold / warm))


def outside(rig: Rig, runs: Sequence[Run]) -> tuple[Outside, ...]:
    """Return the channels that go beyond what the machine was commissioned for."""
    found = []
    for channel, (low, high) in (rig.fingerprint.conditions if rig.fingerprint else {}).items():
        reach = reach_of(channel, runs)
        room = _ROOM_TEMPERATURE if channel == 'oil_temperature' else \
            _ROOM * max(abs(low), abs(high))
        if reach is not None and (reach[0] < low - room or reach[1] > high + room):
            found.append(Outside(channel, *reach, low, high))
    return tuple(found)


def oil_untold(rig: Rig, runs: Sequence[Run]) -> bool:
    """Say whether nobody knows if a commissioned machine's oil is as warm as it was then."""
    return rig.fingerprint is not None and not (
        'oil_temperature' in rig.fingerprint.conditions and reach_of('oil_temperature', runs))


def conditions(runs: Sequence[Run]) -> dict[str, list[float]]:
    """Return the range of each channel that tells conditions, in the units of a rig file."""
    ranges = {}
    for channel, (suffix, unit) in CONDITIONS.items():
        reach = reach_of(channel, runs, (0.5, 99.5))
        if reach is not None:
            ranges[f'{channel}_{suffix}'] = [float(f'{from_si(end, unit):.5g}') for end in reach]
    return ranges


def reach_of(channel: str, runs: Sequence[Run],
             percentiles: Sequence[float] = _TAILS) -> tuple[float, ...] | None:
    """Return between which values a channel lies but for its tails; None if it is not there."""
    values = np.concatenate([run[channel] for run in runs if channel in run] or [np.empty(0)])
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    return tuple(map(float, np.percentile(values, percentiles)))
