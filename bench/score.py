# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of the diagnosis benchmark."""
from __future__ import annotations

from itertools import permutations

from bench.visible import BEYOND, detectable, MOVES
from hst_drive.cli.output import table
import numpy as np
from scipy.stats import norm


def wilson(hits: int, count: int) -> str:
    """Return a share with its 95 % interval by Wilson."""
    if not count:
        return 'no cases'
    z = float(norm.ppf(0.975))
    share = hits / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * np.sqrt(share * (1 - share) / count
                                             + z * z / (4 * count * count))
    return f'{100 * share:.1f} % ({100 * (middle - half):.1f} to {100 * (middle + half):.1f})'


def named(row: dict) -> set[str]:
    """Return all ids that an answer holds possible."""
    return set(row['found']).union(*row['rivals'])


def true(row: dict) -> set[str]:
    """Return the ids that were hidden."""
    return set(row['effects'])


def matched(row: dict) -> bool:
    """Say whether each hidden effect is named, or held possible in the place of one named."""
    groups = [{name, *rivals} for name, rivals in zip(row['found'], row['rivals'])]
    return len(groups) == len(row['effects']) and any(
        all(name in group for name, group in zip(order, groups))
        for order in permutations(row['effects']))


def wrong(row: dict) -> bool:
    """Say whether an answer names, without a doubt, what is not there."""
    return row['verdict'] == 'missing_effect' and not set(row['found']) <= true(row)


def right(row: dict) -> bool:
    """Say whether an answer is as good as these logs allow."""
    if row['kind'] == 'none' or not row['detectable']:
        return not wrong(row) and not (row['kind'] == 'none' and row['verdict'] != 'none')
    if row['kind'] == 'outside':
        return row['verdict'] == 'unknown' and row['place'] in row['enters'].values()
    if row['kind'] == 'pair':
        return set(row['found']) == true(row)
    return set(row['found'][:1]) == true(row) and row['verdict'] != 'unknown' and not wrong(row)


def report(rows: list[dict]) -> str:
    """Return the table."""
    rows = [{**row, 'detectable': detectable(row['seen'])} for row in rows]
    groups = {kind: [row for row in rows if row['kind'] == kind and row['detectable']]
              for kind in ('none', 'single', 'pair', 'outside')}
    none, single, pair, outside = groups.values()
    lines = []

    def add(what: str, good, among: list[dict], goal: str = '') -> None:
        lines.append([what, wilson(sum(bool(good(row)) for row in among), len(among)),
                      str(len(among)), goal])

    add('single: first name right', lambda row: set(row['found'][:1]) == true(row), single,
        '97 %')
    add('single: truth in the reported set', lambda row: true(row) <= named(row), single, '99 %')
    add('single: called unknown', lambda row: row['verdict'] == 'unknown', single)
    add('single, all: first name right', lambda row: set(row['found'][:1]) == true(row),
        [row for row in rows if row['kind'] == 'single'])
    add('none: false alarm', lambda row: row['verdict'] != 'none', none, 'at most 1 %')
    add('all: confident and wrong', wrong, rows, 'at most 2 %')
    add('pair: exact', lambda row: set(row['found']) == true(row), pair, '90 %')
    add('pair: exact, or a look-alike in its place', matched, pair)
    add('pair: both in the reported set', lambda row: true(row) <= named(row), pair)
    add('outside: flagged unknown', lambda row: row['verdict'] == 'unknown', outside, '97 %')
    add('outside: right balance, of those flagged',
        lambda row: row['place'] in row['enters'].values(),
        [row for row in outside if row['verdict'] == 'unknown'], '95 %')
    values = [value for row in rows if row['detectable'] for value in row['values'].values()]
    lines.append(['size: 95 % interval covers the truth', wilson(
        sum(low <= number <= high for _, low, high, number in values), len(values)),
        str(len(values)), '90 to 98 %'])
    errors = [abs(value / number - 1) for value, _, _, number in values]
    after = [row['after'] for row in single if true(row) <= set(row['found'])]
    reported = [len(named(row)) for row in single if row['found']]
    seconds = [row['seconds'] for row in rows]
    spent = [row['cpu_seconds'] for row in rows]
    for what, numbers, text, goal in (
            ('single: mean size of the reported set', reported, '{0:.2f}', 'at most 1.5'),
            ('single: held-out noise ratio after, median', after, '{1:.2f}', 'at most 1.1'),
            ('size: relative error, median', errors, '{1:.3f}', 'at most 0.05'),
            ('seconds per diagnosis: median, greatest', seconds, '{1:.1f}, {2:.1f}', 'at most 15'),
            ('processor seconds: median, greatest', spent, '{1:.1f}, {2:.1f}', '')):
        shown = text.format(np.mean(numbers), np.median(numbers), max(numbers)) if numbers else '-'
        lines.append([what, shown, str(len(numbers)), goal])
    return (table(['measure', 'result', 'cases', 'goal'], lines) + '\n\n'
            f'Detectable (all rows but those with "all"): a measured signal of the training logs '
            f'moves by\n{MOVES:g} noise deviations rms against a twin without the effect under '
            f'the same commands, and by\n{BEYOND:g} beyond what another unit could do. Sizes: '
            'where the truth has the same formula as ours.\n')
