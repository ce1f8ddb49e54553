# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A fleet as plain data: what ``fleet --json`` writes, SI; days as dates."""
from __future__ import annotations

from hst_drive.fleet.life import Lives
from hst_drive.fleet.summary import Followed, Machine, Summary
from hst_drive.fleet.words import day, far, of_machine, sentence

SCHEMA = 'hst_drive/fleet/2'


def as_json(lives: Lives, summary: Summary) -> dict:
    """Return the fleet in the form of schema hst_drive/fleet/2."""
    return {
        'schema': SCHEMA, 'sentence': sentence(summary),
        'machines': [_machine(machine) for machine in summary.machines],
        'outliers': [{'median': entry.median, 'z': entry.z, **entry.point._asdict()}
                     for entry in summary.outliers],
        'failures': [{'campaign': name, 'reason': reason} for name, reason in summary.failures],
        'undated': summary.undated,
        'rows': lives.rows}


def _machine(machine: Machine) -> dict:
    return {**machine._asdict(), 'told': of_machine(machine),
            'followed': [_followed(entry) for entry in machine.followed],
            'events': [{'after': day(entry.after), 'before': day(entry.before),
                        'what': entry.what, 'effects': list(entry.effects)}
                       for entry in machine.events]}


def _followed(entry: Followed) -> dict:
    growth, history, left = entry.growth, entry.history, entry.remaining

    def reached(ordinal: float) -> str | None:
        return None if far(ordinal, growth.now) else day(ordinal)

    return {
        'effect': entry.effect, 'parameter': entry.parameter, 'unit': entry.unit,
        'kind': growth.kind, 'size': list(growth.level),
        'rate_per_day': list(growth.rate),
        'since': None if growth.since is None else day(growth.since),
        'season': growth.season, 'limit': entry.limit,
        'remaining': left and {
            'low': reached(left.low), 'middle': reached(left.middle), 'high': reached(left.high),
            'reached': left.reached},
        'dates': [day(value) for value in history.days], 'values': growth.usual.values.tolist(),
        'sigmas': growth.usual.sigmas.tolist()}
