# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as plain data: what ``diagnose --json`` writes, SI."""
from __future__ import annotations

from hst_drive.diagnose.result import Diagnosis, SCHEMA, Unknown
from hst_drive.effects import catalogue
from hst_drive.identify.evidence import Probability


def as_json(result: Diagnosis) -> dict:
    """Return the diagnosis in the form of schema hst_drive/diagnosis/1."""
    unknown = result.unknown
    return {
        'schema': SCHEMA, 'verdict': result.verdict,
        'sentence': result.sentence, 'rig': result.rig,
        'rig_digest': result.rig_digest, 'logs': result.logs,
        'held_out': result.held_out,
        'since': result.since,
        'outside_commissioned': [entry._asdict() for entry in result.outside],
        'effects': [{'id': entry.id,
                     'parameters': {key: value._asdict()
                                    for key, value in entry.parameters.items()},
                     'error_removed': entry.error_removed,
                     'indistinguishable_from': entry.indistinguishable_from,
                     'adopted': entry.adopted, 'change': entry.change}
                    for entry in result.effects],
        'ranking': [entry._asdict() for entry in result.ranking],
        'errors': {'before': result.ladder[0].training, 'after': result.ladder[-1].training},
        'holdout': {'before': result.ladder[0].holdout, 'after': result.ladder[-1].holdout},
        'ladder': [step._asdict() for step in result.ladder],
        'not_observable': sorted(result.not_observable),
        'not_observable_because': result.not_observable,
        'smallest_visible': {name: {'value': size,
                                    'unit': catalogue()[name].size.unit}
                             for name, size in result.smallest.items()},
        'calibration': [entry._asdict() for entry in result.calibration],
        'sensor_zeros': [entry._asdict() for entry in result.zeros],
        'rivals': result.rivals,
        'probability': _probability(result.probability),
        'unknown': _unknown(unknown) if unknown else None,
        'next_test': result.next_test._asdict() if result.next_test else None,
    }


def _probability(found: Probability) -> dict:
    return {'none': found.none, 'unknown': found.unknown,
            'sets': [{'effects': list(names), 'probability': share}
                     for names, share in found.sets],
            'effects': found.effects, 'calibrated': found.calibrated}


def _unknown(unknown: Unknown) -> dict:
    formula = unknown.formula
    return {**unknown._asdict(), 'formula': formula and {
        **formula._asdict(),
        'parameters': {key: value._asdict() for key, value in formula.parameters.items()}}}
