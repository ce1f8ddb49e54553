# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Do stated probabilities hold? ``python -m bench.reliability ROWS.jsonl... --plot FILE.png``.

Reads what ``bench.frozen.score``, ``bench.diagnosis`` and ``bench.circuits`` wrote. An answer is
right if its most probable explanation is the truth: the exact set, *unknown* for what is not
listed, or *none*.
"""
from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import NamedTuple, Sequence

from hst_drive.cli.output import table
import numpy as np

BANDS = (0.0, 0.5, 0.8, 0.95, 1.0)
_LEAST = 1e-4   # probability that a truth is given that was not among the explanations


class Answer(NamedTuple):
    """What one diagnosis told: its highest probability, whether that was right, the truth's."""

    told: float
    right: bool
    truth: float


def answer(row: dict) -> Answer:
    """Return what a row tells."""
    given, truth = row['probability'], row.get('truth', row)
    shares = {frozenset(): given['none'], frozenset(['unknown']): given['unknown']}
    for entry in given['sets']:
        # What is true of all machines of a kind is neither right nor wrong.
        names = frozenset(entry['effects']) - {*row.get('always', ())}
        shares[names] = shares.get(names, 0.0) + entry['probability']
    true = frozenset(['unknown'] if truth['kind'] in ('unlisted', 'outside')
                     else truth['effects'])
    most = max(shares, key=shares.get)
    return Answer(shares[most], most == true, max(shares.get(true, 0.0), _LEAST))


def bands(answers: Sequence[Answer]) -> list[tuple[float, float, int, float, float]]:
    """Return low and high end, answers, mean told and share that was right, by band."""
    found = []
    for low, high in zip(BANDS, BANDS[1:]):
        own = [entry for entry in answers if low <= entry.told < high + (high == 1.0)]
        if own:
            found.append((low, high, len(own), float(np.mean([entry.told for entry in own])),
                          float(np.mean([entry.right for entry in own]))))
    return found


def calibration_error(answers: Sequence[Answer]) -> float:
    """Return the expected calibration error over the bands."""
    return sum(count * abs(told - right) for *_, count, told, right in bands(answers)) / len(
        answers)


def log_score(answers: Sequence[Answer]) -> float:
    """Return the mean logarithm of the probability that the truth was given."""
    return float(np.mean(np.log([entry.truth for entry in answers])))


def plot(answers: Sequence[Answer], path: str) -> None:
    """Draw how often answers were right over what they told."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4, 4), layout='constrained')
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color='grey', linewidth=1)
    for *_, count, told, right in bands(answers):
        axes.plot(told, right, 'o', color='C0', markersize=4 + count**0.5)
        axes.annotate(f' {count}', (told, right))
    axes.set(xlabel='told', ylabel='share that was right', xlim=(0, 1.05), ylim=(-0.05, 1.05))
    figure.savefig(path, dpi=120)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog='python -m bench.reliability', description=__doc__)
    parser.add_argument('rows', nargs='+', type=Path, metavar='ROWS.jsonl')
    parser.add_argument('--plot', metavar='FILE.png')
    args = parser.parse_args(arguments)
    rows = [json.loads(line) for path in args.rows
            for line in path.read_text(encoding='utf-8').splitlines()]
    answers = [answer(row) for row in rows if row.get('probability')]
    if not answers:
        parser.error('no row has probabilities')
    print(table(['told', 'campaigns', 'mean', 'right'], [
        [f'{low:g} to {high:g}', count, f'{told:.2f}', f'{right:.2f}']
        for low, high, count, told, right in bands(answers)]))
    print(f'expected calibration error {calibration_error(answers):.3f}, '
          f'log score {log_score(answers):.3f}')
    if args.plot:
        plot(answers, args.plot)


if __name__ == '__main__':
    main()
