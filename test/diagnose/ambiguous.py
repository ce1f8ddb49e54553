# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A drive whose first log leaves rivals, and what the advised test makes of them."""
from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from test.truth import make_campaign, write_campaign
from test.truth.profiles import quantise
from test.truth.sensors import STANDARD
from typing import NamedTuple

from hst_drive.bag import read_log
from hst_drive.design.design import design
from hst_drive.design.rivals import matched, widened
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.next_test import of_diagnosis
from hst_drive.diagnose.result import as_json, Diagnosis
from hst_drive.effects import catalogue
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario
from hst_drive.measure.run import Run
from hst_drive.rig import Rig
from hst_drive.units import from_si
import numpy as np


class Outcome(NamedTuple):
    """Before and after the advised test."""

    truth: str
    seed: int
    before: str
    rivals: tuple[str, ...]
    advice: str
    test: str
    expected: float
    after: str
    named: tuple[str, ...]
    left: tuple[str, ...] = ()
    gauges: tuple[str, ...] = ()

    @property
    def kept(self) -> bool:
        """Whether a set with the truth stays, and the design named the gauge that tells."""
        standing = (*self.named, *self.left)
        return len(self.named) == 1 and bool(self.left) and self.truth in standing and any(
            catalogue()[name].gauge in self.gauges for name in standing)

    @property
    def right(self) -> bool:
        """
        Whether the ambiguity is gone and the name right.

        An 'unknown' beside it counts: a wide test also shows how far the truth is off the formula.
        """
        return self.named == (self.truth,) and not self.left


def first_log(truth: str, seed: int) -> Run:
    """Return 30 s of drilling at one speed and one temperature, by the truth generator."""
    return _run(make_campaign(seed, {truth: 1.0}, gentle=True, logs=('drilling',),
                              temperature='steady', duration=30.0, keep_exact=False), 'drilling')


def advised_log(truth: str, seed: int, content: dict, rig: Rig,
                sensors: tuple[str, ...] = ()) -> Run:
    """Return what the truth generator records of a scenario in open loop, on the same unit."""
    scenario = parse_scenario(content, LoadingUnit.of(rig.loading))
    time = np.arange(int(round(scenario.duration * 1000))) // 10 / 100
    command = {'setpoint': np.zeros(len(time)), 'closed': False,
               'manual': quantise(scenario.pump_command.sample(time)),
               'pprv': quantise([scenario.load.pprv_command(at) for at in time.tolist()])}
    oil = tuple(float(from_si(scenario.oil_temperature(at), 'degC'))
                for at in (0.0, scenario.duration))
    channels = STANDARD + tuple(name for name in sensors if name not in STANDARD)
    return _run(make_campaign(seed, {truth: 1.0}, logs=('open_loop',), channels=channels,
                              duration=scenario.duration, temperature={'open_loop': oil},
                              command={'open_loop': command}, keep_exact=False), 'open_loop')


def _run(campaign, name: str) -> Run:
    with TemporaryDirectory() as folder:
        return read_log(str(Path(write_campaign(campaign, folder), f'{name}.csv')))


def named(result: Diagnosis) -> tuple[str, ...]:
    """Return the effects that a diagnosis found."""
    return tuple(entry.id for entry in result.effects)


def case(rig: Rig, truth: str, seed: int, duration: float = 120.0) -> Outcome | None:
    """Diagnose, design, record and diagnose again; None if the first log was not ambiguous."""
    first = first_log(truth, seed)
    before = diagnose(rig, [first])
    if before.verdict != 'ambiguous':
        return Outcome(truth, seed, before.verdict, (), '', '', 0.0, '', named(before))
    rivals = of_diagnosis(as_json(before), 'diagnosis')
    likely = matched(rig, rivals)
    result = design(rig, widened(rig, likely, rivals.channels), rivals.channels,
                    duration=duration, likely=len(likely))
    second = advised_log(truth, seed, result.content, rig, result.sensors)
    after = diagnose(rig, [first, second])
    return Outcome(truth, seed, before.verdict, tuple('+'.join(entry) for entry in rivals.names),
                   ' '.join((result.advice, *result.sensors)), result.trial.words,
                   result.significance, after.verdict, named(after),
                   tuple(entry for found in after.effects
                         for entry in found.indistinguishable_from), result.gauges)
