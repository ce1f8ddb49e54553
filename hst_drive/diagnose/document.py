# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as plain data: what ``diagnose --json`` writes, SI."""
from __future__ import annotations

from hst_drive.diagnose.result import Diagnosis, SCHEMA
from hst_drive.effects import catalogue
from hst_drive.plain import plain


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
        'rivals': result.rivals,
        'probability': {
            'none': found.none, 'unknown': found.unknown,
            'sets': [{'effects': names, 'probability': share} for names, share in found.sets],
            'effects': found.effects, 'calibrated': found.calibrated},
        'unknown': result.unknown,
        'next_test': result.next_test,
    })
