# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which seed gets what: of each twenty the same kinds, and every effect equally often."""
from typing import NamedTuple

from bench.unseen import (listed_flow, listed_signals, listed_torque, unlisted_drive,
                          unlisted_ends)
from bench.unseen.fault import draw, Drawn, Fault
import numpy as np

# gear_backlash is not among them: the open circuit never turns back and its load always brakes,
# so that the play of the gear is never passed. The closed and the valve circuit's are not either.
LISTED: tuple[Fault, ...] = (*listed_flow.FLOW, *listed_torque.TORQUE, *listed_signals.ACTUATOR,
                             *listed_signals.SENSOR)
UNLISTED: tuple[Fault, ...] = (*unlisted_drive.FLOW, *unlisted_drive.TORQUE,
                               *unlisted_drive.ACTUATOR, *unlisted_ends.LOAD,
                               *unlisted_ends.SENSOR)
BLOCK = ('none',) * 4 + ('single',) * 8 + ('pair',) * 3 + ('unlisted',) * 5
# How far the worst signal moves, in standard deviations of its sensor's noise.
BANDS = ((2.0, 5.0), (5.0, 15.0), (15.0, 40.0))
ROWS = (0.002, 0.005, 0.01, 0.02, 0.05)


class Plan(NamedTuple):
    """What a seed asks for."""

    kind: str
    drawn: tuple[Drawn, ...]
    bands: tuple[tuple[float, float], ...]
    on_datasheet: bool
    other_size: bool
    row: float
    seconds: tuple[float, ...]
    names: tuple[str, ...]
    missing: tuple[str, ...]
    jitter: float
    lost: float


def _from_deck(deck: tuple[Fault, ...], index: int) -> Fault:
    """Return the card at an index of a deck that is shuffled anew after its last card."""
    turn, place = divmod(index, len(deck))
    return deck[np.random.default_rng([turn, len(deck)]).permutation(len(deck))[place]]


def _chosen(seed: int, rng: np.random.Generator) -> tuple[str, tuple[Drawn, ...]]:
    """Return the kind of a seed's campaign and its effects."""
    block, place = divmod(seed, len(BLOCK))
    order = np.random.default_rng([block, 20]).permutation(len(BLOCK))
    kind = BLOCK[order[place]]
    if kind == 'none':
        return kind, ()
    if kind == 'pair':
        while True:
            first, second = (LISTED[i] for i in rng.choice(len(LISTED), 2, replace=False))
            one, other = draw(first, rng), draw(second, rng)
            alike = second.id in one.also or first.id in other.also
            # One model of the line holds either its mass or its losses.
            one_line = {first.id, second.id} == {'line_inertance', 'line_loss'}
            if not alike and not one_line and first.enters != second.enters:
                return kind, (one, other)
    rank = sum(BLOCK[order[i]] == kind for i in range(place))
    deck = LISTED if kind == 'single' else UNLISTED
    return kind, (draw(_from_deck(deck, block * BLOCK.count(kind) + rank), rng),)


def plan(seed: int) -> Plan:
    """Return what a seed asks for."""
    rng = np.random.default_rng([seed, 1])
    kind, drawn = _chosen(seed, rng)
    bands = tuple(BANDS[rng.integers(len(BANDS))] for _ in drawn)
    slowest = min([0.05, *(one.fault.row for one in drawn)])
    row = float(rng.choice([row for row in ROWS if row <= slowest]))
    names = ['drilling', 'sweep', 'manual', 'holdout']
    more = rng.random()
    if more < 0.2:
        names.insert(1, 'drilling_2')
    elif more < 0.35:
        names.remove('manual' if rng.random() < 0.5 else 'sweep')
    length = 30.0 if rng.random() < 0.7 else float(rng.choice([20.0, 40.0, 60.0]))
    missing: tuple[str, ...] = ()
    if rng.random() < 0.3:
        # The signal by which the effect shows best stays, as far as it is a sensor's own error.
        may = [name for name in ('load_torque', 'motor_inlet_flow', 'oil_temperature',
                                 'speed_setpoint')
               if not any(name == one.fault.signal for one in drawn)
               and not (name == 'oil_temperature'
                        and any(one.fault.id == 'leakage_temperature' for one in drawn))]
        missing = tuple(rng.choice(may, rng.integers(1, 3), replace=False).tolist())
    jitter = float(rng.uniform(0.05, 0.2)) if rng.random() < 0.25 else 0.0
    lost = float(rng.uniform(0.002, 0.02)) if rng.random() < 0.25 else 0.0
    return Plan(kind, drawn, bands, bool(rng.random() < 0.25), bool(rng.random() < 0.25), row,
                (length,) * len(names), tuple(names), missing, jitter, lost)
