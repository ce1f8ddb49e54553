# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from hst_drive.effects import catalogue, effect_of, Parameter
from hst_drive.errors import InputError
from hst_drive.identify.conditions import Outside
from hst_drive.identify.evidence import Probability
from hst_drive.plain import plain

SCHEMA = 'hst_drive/diagnosis/1'
# Among what is indistinguishable from an effect: none, but a unit at the limits of its tolerances.
UNIT_ALONE = 'none'


class Value(NamedTuple):
    """A fitted parameter with its 95 % interval, SI."""

    value: float
    low: float
    high: float
    unit: str


def not_known(low: float, high: float, parameter: Parameter) -> str:
    """Say why an interval of a parameter, SI, tells nothing; empty if it does."""
    if low >= high:
        return 'not fitted'
    if low <= parameter.low and high >= parameter.high:
        return 'not determined'
    return ''


class Found(NamedTuple):
    """
    An effect that the model lacks.

    ``error_removed`` is the share of the held-out squared error above the noise that this step
    removed; ``indistinguishable_from`` are effects that explain these logs as well, and
    ``UNIT_ALONE`` if the unit does. ``adopted`` are its parameters, SI, as the rig has them, of a
    leak in the oil of these logs: then it has changed since.
    """

    id: str
    parameters: dict[str, Value]
    error_removed: float
    indistinguishable_from: tuple[str, ...]
    adopted: dict[str, float] = {}

    @property
    def change(self) -> str:
        """What an adopted effect did: 'grown', 'shrunk' or 'gone'; '' for a new one."""
        if not self.adopted:
            return ''
        size, now = next(iter(self.parameters.items()))
        neutral = effect_of(self.id).parameter(size).neutral
        if now.low <= neutral <= now.high and not now.low <= self.adopted[size] <= now.high:
            return 'gone'
        grown = abs(now.value - neutral) > abs(self.adopted[size] - neutral)
        return 'grown' if grown else 'shrunk'


class Ranked(NamedTuple):
    """
    A candidate alone: held-out noise ratio and evidence.

    ``evidence`` is half the fall of the weighted squared error (training, held-out and priors)
    against the calibrated baseline: the natural logarithm of the likelihood ratio with errors
    closer than 0.1 s counted as one, less what further parameters gain by chance.
    """

    id: str
    holdout_noise_ratio: float
    evidence: float


class Step(NamedTuple):
    """A rung of the ladder: what was added, and the noise ratios then."""

    added: str
    training: dict[str, float]
    holdout: dict[str, float]


class Formula(NamedTuple):
    """
    A formula for an unknown as an effect that can be adopted.

    ``before`` and ``after`` are held-out noise ratios without and with it, ``factors`` what the
    unit's quantities are multiplied with beside it, and ``beside`` the effects that are on then.
    """

    id: str
    parameters: dict[str, Value]
    before: dict[str, float]
    after: dict[str, float]
    factors: dict[str, float]
    beside: dict[str, dict[str, float]]


class Unknown(NamedTuple):
    """
    Where a structured error remains, on what it depends, and a formula for it.

    ``explained`` is the share of the unknown's squared size on held-out blocks that the formula
    takes; ``formula`` is None if no formula of the drive's variables lowers the error.
    """

    enters: str
    signal: str
    depends_on: tuple[str, ...]
    expression: str
    terms: tuple[dict, ...] = ()
    explained: float = 0.0
    formula: Formula | None = None


class NextTest(NamedTuple):
    """
    What would separate effects that these logs cannot.

    ``models`` are the explanations that fit these logs alike: id to parameters, SI.
    """

    separates: tuple[str, ...]
    what: str
    models: tuple[dict[str, dict[str, float]], ...] = ()


class Zero(NamedTuple):
    """
    What a sensor reads beyond the truth throughout, by its channel, SI; or how late, s.

    ``sigmas`` counts it in the standard deviation of what it may be.
    """

    channel: str
    value: float
    unit: str
    sigmas: float


class Calibrated(NamedTuple):
    """A quantity of this unit: factor on the datasheet, in tolerances, and at its limit or not."""

    quantity: str
    factor: float
    sigmas: float
    at_limit: bool


@dataclass(frozen=True)
class Diagnosis:
    """
    The answer: a verdict and all that it rests on.

    Attributes
    ----------
    verdict : str
        'none', 'missing_effect', 'ambiguous' or 'unknown'.
    sentence : str
        The answer for people.
    effects : tuple of Found
        What to add, in the order in which the error falls.
    ranking : tuple of Ranked
        Every candidate alone, the best first.
    ladder : tuple of Step
        Datasheet (or the unit as commissioned), calibrated unit, then one step per effect.
    not_observable : dict of str to str
        Effects that these logs cannot show, and why.
    smallest : dict of str to float
        The size of each other effect (first parameter, SI) from which on the evidence of these
        logs is expected to decide for it.
    calibration : tuple of Calibrated
        How this unit is off its datasheet.
    zeros : tuple of Zero
        How its sensors are off at zero.
    probability : Probability
        Of each set of effects, of none and of something unlisted.
    unknown, next_test
        See there; None if there is nothing to say.
    rivals : dict of str to str
        Effects that lost, and why.
    rig, rig_digest : str
        The baseline, by its file and by what it says.
    logs, held_out : tuple of str
        All recordings, and those of them that only judged; without any, a third of each did.
    outside : tuple of Outside
        Channels beyond what the machine was commissioned for.
    since : tuple of str
        The recordings that it was commissioned on, if it was.
    delays : tuple of Zero
        How late its sensors read.
    inertia : float
        That of the hydromotor's shaft, kg.m^2, where the rig file gives none and logs told; or 0.

    """

    verdict: str
    sentence: str
    effects: tuple[Found, ...]
    ranking: tuple[Ranked, ...]
    ladder: tuple[Step, ...]
    not_observable: dict[str, str]
    smallest: dict[str, float]
    calibration: tuple[Calibrated, ...]
    zeros: tuple[Zero, ...]
    probability: Probability
    unknown: Unknown | None = None
    next_test: NextTest | None = None
    rivals: dict[str, str] = field(default_factory=dict)
    rig: str = ''
    rig_digest: str = ''
    logs: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    outside: tuple[Outside, ...] = ()
    since: tuple[str, ...] = ()
    delays: tuple[Zero, ...] = ()
    inertia: float = 0.0


def require_schema(content: object, source: str) -> None:
    """Raise InputError if what was read from a file has not the schema of a diagnosis."""
    found = content.get('schema') if isinstance(content, dict) else None
    if found != SCHEMA:
        raise InputError(f"{source}: key 'schema' is {found!r}, expected '{SCHEMA}'; give the "
                         "file that 'hst-drive diagnose --json' wrote")


def as_json(result: Diagnosis) -> dict:
    """Return the diagnosis in the form of schema hst_drive/diagnosis/1."""
    found = result.probability
    return plain({
        'schema': SCHEMA, 'verdict': result.verdict,
        'sentence': result.sentence, 'rig': result.rig,
        'rig_digest': result.rig_digest, 'logs': result.logs,
        'held_out': result.held_out,
        'since': result.since,
        'outside_commissioned': result.outside,
        'effects': [{**entry._asdict(), 'change': entry.change} for entry in result.effects],
        'ranking': result.ranking,
        'errors': {'before': result.ladder[0].training, 'after': result.ladder[-1].training},
        'holdout': {'before': result.ladder[0].holdout, 'after': result.ladder[-1].holdout},
        'ladder': result.ladder,
        'not_observable': sorted(result.not_observable),
        'not_observable_because': result.not_observable,
        'smallest_visible': {name: {'value': size,
                                    'unit': catalogue()[name].size.unit}
                             for name, size in result.smallest.items()},
        'calibration': result.calibration,
        'sensor_zeros': result.zeros,
        'sensor_delays': result.delays,
        'inertia': {'value': result.inertia, 'unit': 'kg.m^2'} if result.inertia else None,
        'rivals': result.rivals,
        'probability': {
            'none': found.none, 'unknown': found.unknown,
            'sets': [{'effects': names, 'probability': share} for names, share in found.sets],
            'effects': found.effects, 'calibrated': found.calibrated},
        'unknown': result.unknown,
        'next_test': result.next_test,
    })
