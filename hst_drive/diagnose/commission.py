# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Commissioning: one machine's fingerprint from logs of the time when it was healthy.

The unit's factors are fitted within the make's tolerances. Their covariance, that of blocks as
clusters, and by how much the machine differs from day to day are what a later diagnosis has in
place of these tolerances.
"""
from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from typing import Any, Callable, Mapping, NamedTuple, Sequence

from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.repeatability import DAY_TO_DAY, repeatability, start_errors
from hst_drive.diagnose.result import Diagnosis
from hst_drive.effects import catalogue
from hst_drive.effects.base import arguments, OIL_POWER
from hst_drive.effects.leakage_temperature import OIL_LAW, POWER, POWER_SIGMA
from hst_drive.errors import InputError
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.conditions import conditions, reach_of, thinning
from hst_drive.identify.fit import fit
from hst_drive.identify.intervals import FORM, spread
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.identify.unknowns import SIGMAS
from hst_drive.identify.zeros import LATE
from hst_drive.measure.run import Run
from hst_drive.rig import parse_rig, Rig
from hst_drive.rig.adopted import with_delays, with_inertia
from hst_drive.rig.fingerprint import entry_of, OIL_LAW_SIGMA, SECTION, STARTS, ZEROS
from hst_drive.rig.schema import DOUBTED, LOSSES, WAVES
from hst_drive.units import from_si
import numpy as np

_LESS = 0.5         # of a quantity, that no unit of a make lacks
_TOLD = 0.5         # of what was open, squared: with more left the logs told nothing
# What makes each quantity show.
_TESTS = {
    'motor.displacement': 'several speeds at little load, with the flow measured',
    'motor.inertia': 'quick steps of the command at little load',
    'line.bulk_modulus': 'steps of the load, at 100 Hz or more',
    'line.compressibility_under_pressure': 'steps of the load at low and at high pressure',
    **dict.fromkeys(('pump.displacement_between_points', *WAVES),
                    'slow sweeps of the pump command, with the flow measured'),
    'loading.pprv_between_points': 'slow sweeps of the PPRV command, with the torque measured',
    'pump.displacement_vs_command': 'several pump commands at little load',
    **dict.fromkeys(('pump.displacement_lag', 'pump.displacement_series_lag'),
                    'steps of the pump command, at 100 Hz or more'),
    'pump.leakage': 'low and high pressure at one pump command, with the flow measured',
    'motor.leakage': 'low and high pressure at one speed, with the flow measured',
    **dict.fromkeys(('motor.mechanical_efficiency', *LOSSES),
                    'low and high load, with the torque measured'),
    'loading.pump_mechanical_efficiency': 'low and high load, with the torque measured',
    'loading.pprv_pressure': 'several PPRV commands, with the torque measured',
    'loading.pprv_lag': 'steps of the PPRV command, with the torque measured',
    'charge.relief_pressure': 'both line pressures, or the charge pressure',
    'charge.pump_displacement': 'the charge pressure at low and high load',
    'gear.efficiency': 'low and high load, with the torque measured',
    'valve.rated_flow': 'several valve commands, with the speed measured',
    'valve.lag': 'steps of the valve command, at 100 Hz or more',
    'loading.pprv_override': 'several speeds at one PPRV command, with the torque measured',
}


class Quantity(NamedTuple):
    """
    A quantity of this machine: factor on the datasheet, how well it and the make are known.

    ``sigma`` and ``make`` are relative standard deviations; ``test`` is what would tell where the
    logs did not, else ''.
    """

    quantity: str
    factor: float
    sigma: float
    make: float
    test: str


class Commissioned(NamedTuple):
    """The machine's rig file as a mapping, and what people want to know of it."""

    rig: dict[str, Any]
    quantities: tuple[Quantity, ...]
    day_to_day: float
    from_logs: bool


def commission(rig: dict, source: str, runs: Sequence[Run], day_to_day: float | None = None, *,
               progress: Callable[[str], None] = lambda text: None) -> Commissioned:
    """
    Return the fingerprint of a machine.

    Parameters
    ----------
    rig : dict
        Mapping of the rig file of the make.
    source : str
        That file, for messages.
    runs : sequence of Run
        Recordings of the machine while it was healthy.
    day_to_day : float, optional
        Repeatability, in tolerances of the make; else from the logs, if there are several, and
        ``DAY_TO_DAY``.
    progress : callable
        Called with a text while the work goes on.

    Raises
    ------
    InputError
        If something is missing in the model of these logs, or they tell nothing.

    """
    if SECTION in rig:
        raise InputError(f'{source}: is the file of a machine that was commissioned already; give '
                         "the make's, from which that was made")
    made, within = _of_make(rig, source)
    law = 0.0   # one sigma of the power of the viscosity that the leakages follow, once told
    curve: dict[str, float] = {}
    for run in runs:
        # Each by itself: from one day to the next a machine differs, and that is to be learnt.
        found = first = diagnose(within, [run], progress=progress)
        if found.verdict != 'none' and not law:
            # How its leakage goes with its oil is no fault of a machine.
            rig, law = _with_oil_law(rig, source, runs, sure=_of_oil(found))
            made, within = _of_make(rig, source)
            found = diagnose(within, [run], progress=progress) if law else found
        if found.verdict != 'none' and len(runs) > 1:
            # A short log alone may mislead; what is missing in the machine shows in all of them.
            found = diagnose(within, runs, progress=progress)
        if found.verdict != 'none' and not (law and _of_oil(found)):
            others = ', alone and with all others' if len(runs) > 1 else ''
            raise InputError(f'{run.source}{others}: cannot be commissioned as healthy: '
                             f'{(first if law else found).sentence} Mend or adopt that first, or '
                             'leave the log out')
        # What was asked for to find nothing missing is this machine's, and its logger's.
        if found.delays or found.inertia:
            rig = with_inertia(with_delays(rig, {
                entry.channel: entry.value for entry in found.delays}), found.inertia)
            made, within = _of_make(rig, source)
        curve |= {entry.quantity: entry.factor for entry in found.calibration
                  if entry.quantity in DOUBTED}
        if found.verdict == 'none' and len(found.logs) > 1:
            break
    if not law:
        rig, law = _with_oil_law(rig, source, runs)
        made, within = _of_make(rig, source)
    campaign = campaign_of(within, runs)
    if curve := {key: made.calibration.get(key, 1.0) * curve[key]
                 for key in curve.keys() - campaign.tolerances.keys()}:
        rig = {**rig, 'calibration': {**(rig.get('calibration') or {}), **curve}}
        made, within = _of_make(rig, source)
        campaign = campaign_of(within, runs)
    campaign = campaign.of_logs(all_to_fit=True)
    if campaign.by_balance and (late := campaign.late()).delays:
        # How late a sensor reads is the same for good.
        rig = with_delays(rig, {key.removesuffix(LATE): delay
                                for key, delay in calibrated(late).model.delays.items()})
        made, within = _of_make(rig, source)
        campaign = campaign_of(within, runs).of_logs(all_to_fit=True)
    if not campaign.tolerances:
        raise InputError(f"{source}: 'tolerances_1_sigma_relative' has no quantity that these "
                         'logs show: there is nothing to learn; add how far units of this make '
                         'differ')
    progress('commissioning the machine')
    fitted = calibrated(campaign)
    known = spread(campaign, fitted, between_points=0.0)
    from_logs = day_to_day is None and len(runs) > 1
    if day_to_day is None:
        day_to_day = float(f'{repeatability(campaign, fitted):.2g}') if from_logs else DAY_TO_DAY
    # Of the quantities first, then of the zeros of sensors.
    make = np.array([made.tolerances.get(key, sigma)
                     for key, sigma in {**campaign.tolerances, **campaign.zeros}.items()])
    covariance = known.covariances[:len(make), :len(make)] + np.diag((day_to_day * make)**2)
    sigmas = np.sqrt(np.diag(covariance))
    factors = {**made.calibration,
               **{key: made.calibration.get(key, 1.0) * factor
                  for key, factor in fitted.model.scales.items()}}
    unit = deepcopy(rig)    # with the law of its oil
    unit['calibration'] = {key: float(f'{value:.8g}') for key, value in factors.items()}
    correlation = np.round(covariance / np.outer(sigmas, sigmas), 4)
    sigmas = np.minimum(sigmas, make)   # no machine is less known than its make
    unit[SECTION] = {
        'sigma_relative': {key: float(f'{value:.4g}')
                           for key, value in zip(campaign.tolerances, sigmas)},
        'correlation': _positive(correlation).tolist(),
        'day_to_day_share_of_tolerance': day_to_day, 'conditions': conditions(runs)}
    if campaign.zeros:
        unit[SECTION][ZEROS] = dict(
            entry_of(name, made.zeros.get(name, 0.0) + fitted.model.zeros[name], sigma)
            for name, sigma in zip(campaign.zeros, sigmas[len(campaign.tolerances):]))
    if starts := start_errors(campaign, fitted):
        unit[SECTION][STARTS] = dict(entry_of(*entry) for entry in starts.items())
    if law:
        unit[SECTION][OIL_LAW_SIGMA] = float(f'{law:.3g}')
    warm = reach_of('oil_temperature', runs, (50.0,))
    if warm and not _follow_viscosity(made.effects):
        # What was learnt of the leakages holds for the oil as it was then.
        unit['characterised_at_oil_temperature_degC'] = round(float(from_si(warm[0], 'degC')), 1)
    unit['provenance'] = {**(rig.get('provenance') or {}),
                          SECTION: {'logs': [run.source for run in runs]}}
    return Commissioned(unit, tuple(
        Quantity(key, factors[key], float(sigma), float(tolerance),
                 _TESTS.get(key, '') if sigma**2 > _TOLD * tolerance**2 else '')
        for key, sigma, tolerance in zip(campaign.tolerances, sigmas, make)),
        day_to_day, from_logs)


def _of_make(rig: dict, source: str) -> tuple[Rig, Rig]:
    """Return the rig of a file, and with limits within which its units are healthy."""
    made = parse_rig(rig, source)
    return made, replace(made, tolerances={key: _as_ratio(value)
                                           for key, value in made.tolerances.items()})


def _of_oil(found: Diagnosis) -> bool:
    return [entry.id for entry in found.effects] == [OIL_LAW] and found.verdict != 'unknown'


def _with_oil_law(rig: dict, source: str, runs: Sequence[Run],
                  sure: bool = False) -> tuple[dict, float]:
    """
    Return the rig file with how its leakages go with the viscosity, and one sigma of that power.

    0 if these logs do not tell it.

    From all logs, and what is known of any gap. A leakage is off its formula by ``FORM``: so far
    it may go astray while the oil gets thinner. ``sure``: these logs ask for it.
    """
    made, within = _of_make(rig, source)
    campaign = campaign_of(within, runs).of_logs(all_to_fit=True)
    told = all('oil_temperature' in run for run in runs) and not campaign.out_of_reach(OIL_LAW)
    if OIL_LAW in made.effects and not sure or not told:
        return rig, 0.0
    start = Model({OIL_LAW: {'exponent': POWER}})
    found = spread(campaign, fit(campaign, start, iterations=6, refresh=True), between_points=0.0)
    index = found.unknowns.names.index((OIL_LAW, 'exponent'))
    sigma = np.hypot(np.sqrt(found.covariances[index, index]),
                     FORM / max(thinning(made, runs), 1e-6))
    precision = np.array([POWER_SIGMA, sigma])**-2.0
    power = float(precision @ [POWER, found.values[index]] / precision.sum())
    if not sure and 1.0 / precision.sum() > _TOLD * POWER_SIGMA**2:
        return rig, 0.0
    return {**rig, 'effects': {**(rig.get('effects') or {}), OIL_LAW: {
        'exponent': float(f'{power:.3g}')}}}, float(precision.sum()**-0.5)


def _as_ratio(tolerance: float) -> float:
    """Return the tolerance whose limits hold a unit that is three of the given ones below."""
    return max(tolerance, -float(np.log1p(-min(SIGMAS * tolerance, _LESS))) / SIGMAS)


def _follow_viscosity(effects: Mapping[str, Mapping[str, float]]) -> bool:
    """Return whether an effect's size is one at the temperature of the rig file's tables."""
    known = catalogue(everything=True)
    return any({'viscosity_ratio', 'characterised_at'} & {*arguments(function)}
               for effect, values in effects.items() if values.get(OIL_POWER[0].name, 1.0)
               for _, function in known[effect].terms)


def _positive(correlation: np.ndarray) -> np.ndarray:
    """Return a correlation whose rounding leaves no mixture of quantities fixed."""
    least = np.linalg.eigvalsh(correlation)[0]
    room = 1e-3     # ten times what four digits round off
    return correlation if least >= room else np.round(
        (correlation + (room - least) * np.eye(len(correlation))) / (1.0 + room - least), 6)
