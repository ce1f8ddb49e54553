# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Lives of machines whose truth is known: rows as the three rounds of a fleet leave them."""
from datetime import date, timedelta

from hst_drive.fleet.life import Lives
import numpy as np

from . import stubs

START = date(2024, 1, 10)
SIGMA = 3e-14
TYPICAL = 1e-12


def rows(machine, days, sizes, effect='motor_leakage', parameter='conductance',
         unit='m^3/(s.Pa)', sigma=SIGMA, seed=0, warm=50.0):
    """Return rows of campaigns and of sizes of one effect of a machine."""
    random = np.random.default_rng(seed)
    found, followed = [], []
    for place, (day, size) in enumerate(zip(days, sizes)):
        value = size + sigma * random.standard_normal()
        when = (START + timedelta(days=int(day))).isoformat()
        named = value > 4 * sigma
        diagnosis = stubs.answer(value, effect) if named else {
            'verdict': 'none', 'sentence': 'Nothing is missing.', 'effects': []}
        common = {'campaign': f'{machine}/{when}', 'machine': machine, 'date': when,
                  'reason': None}
        first = place < 2
        found.append({**common, 'status': 'commissioned' if first else 'done',
                      'diagnosis': None if first else diagnosis})
        followed.append({**common, 'status': 'done', 'sizes': {effect: {
            'parameter': parameter, 'unit': unit, 'value': value, 'sigma': sigma}},
            'oil_temperature': warm if np.isscalar(warm) else warm[place]})
    return found, followed


def together(*machines):
    """Return machines as one fleet."""
    names = {row['machine'] for found, _ in machines for row in found}
    return Lives([row for found, _ in machines for row in found],
                 {name: f'units/{name}.yaml' for name in names},
                 [row for _, followed in machines for row in followed])


def fleet():
    """Return a fleet: one wears, one was repaired, one has other oil, some do nothing."""
    days = np.arange(12) * 61
    wear = TYPICAL * days / days[-1]
    oil = np.where(days < 300, 0.0, -0.15)
    machines = [
        rows('wears', days, wear, seed=1),
        rows('steady', days, np.full(12, 0.5 * TYPICAL), seed=2),
        rows('repaired', days, np.where(days < 400, 1.5 * wear, 0.0), seed=3),
        rows('oil', days, oil, 'line.bulk_modulus', 'change', '1', sigma=0.01, seed=4),
        rows('sound', days, np.zeros(12), seed=5), rows('new', days[:2], wear[:2], seed=6),
        *(rows(f'other_{k}', days[:3], [0.5 * TYPICAL] * 3, seed=10 + k) for k in range(6)),
        rows('far <off>', days[:3], [9 * TYPICAL] * 3, seed=30)]
    for found, followed in machines[3:4]:     # another's name is not found in the diagnoses
        for row in found:
            row['diagnosis'] = row['diagnosis'] and {
                'verdict': 'none', 'sentence': 'Nothing is missing.', 'effects': []}
    machines[4][0][-1].update(status='failed', reason='no <rows>', diagnosis=None)
    return together(*machines)
