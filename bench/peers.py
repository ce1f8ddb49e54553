# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What others would use, on the same campaigns: ``python -m bench.peers FOLDER --json OUT.jsonl``.

Needs ``pip install pysindy scikit-learn`` (for this alone). FOLDER holds campaigns of
``bench.unseen.make``. All peers get the product's own replay with a calibrated unit; what they
decide by is theirs:

* sparse regression: sequentially thresholded least squares (pysindy) of the errors that are left
  on what each effect of typical size does to the signals, the unit's factors beside them;
* forward selection: the same columns, one by one while BIC over all samples falls;
* classifier: gradient boosting (scikit-learn) on statistics of the errors, trained on drives
  simulated with one effect each under the commands of these campaigns.

The answers of the diagnosis are read from what ``bench.unseen.score`` wrote (``--scored``).
"""
from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
import sys
import time
from typing import Callable, Iterator, NamedTuple, Sequence

from bench.score import wilson
from hst_drive.bag import read_log
from hst_drive.cli.output import table
from hst_drive.identify.calibrate import calibrated
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import Fit
from hst_drive.identify.model import Model
from hst_drive.rig import load_rig
import numpy as np

THRESHOLD = 0.1         # of typical size: what sparse regression takes for zero
_RIDGE = 1e-3
_OTHERS = 10            # simulated drives per effect to train the classifier on; as many healthy
_SURE = 0.5             # probability below which the classifier's answer counts as unknown
_SEED = 5


class Case(NamedTuple):
    """A campaign with its calibrated baseline: errors left, and what effects do to them."""

    folder: str
    truth: dict
    campaign: Campaign
    base: Fit
    names: tuple[str, ...]
    columns: np.ndarray
    seconds: float


def case(folder: Path) -> Case:
    """Read and prepare a campaign."""
    begin = time.process_time()
    rig = load_rig(folder / 'rig.yaml')
    logs = sorted(path for path in folder.glob('*.csv') if path.name != 'holdout.csv')
    campaign = Campaign(rig, [read_log(path) for path in logs],
                        [read_log(folder / 'holdout.csv')])
    base = calibrated(campaign)
    names = tuple(name for name in campaign.candidates() if not campaign.out_of_reach(name))
    start = stacked(campaign, base.errors)
    moves = [stacked(campaign, campaign.errors(base.model.with_effect(
        name, campaign.typical(name)))) - start for name in names]
    return Case(folder.name, json.loads((folder / 'truth.json').read_text(encoding='utf-8')),
                campaign, base, names, np.column_stack(moves), time.process_time() - begin)


def stacked(campaign: Campaign, errors: Sequence[np.ndarray]) -> np.ndarray:
    """Return all errors that count, over their floors, as one vector."""
    return np.concatenate([error[np.union1d(column.fit, column.judge)]
                           for error, column in zip(errors, campaign.columns)])


def factors(entry: Case) -> np.ndarray:
    """Return what a tolerance of each of the unit's factors does to the errors."""
    campaign, model = entry.campaign, entry.base.model
    start = stacked(campaign, entry.base.errors)
    return np.column_stack([
        stacked(campaign, campaign.errors(Model(model.effects, {
            **model.factors, key: model.factors.get(key, 0.0) + size}))) - start
        for key, size in campaign.tolerances.items()])


def sparse_regression(entry: Case) -> list[str]:
    """Name what is left after thresholds."""
    from pysindy import STLSQ

    # What the unit's factors can do is projected out: they are not to be made sparse.
    free, _ = np.linalg.qr(factors(entry))
    left = -stacked(entry.campaign, entry.base.errors)
    left, moves = (values - free @ (free.T @ values) for values in (left, entry.columns))
    found = STLSQ(threshold=THRESHOLD, alpha=_RIDGE).fit(moves, left[:, None]).coef_[0]
    return [name for name, size in zip(entry.names, found) if abs(size) > THRESHOLD]


def forward_selection(entry: Case) -> list[str]:
    """Name what BIC over all samples asks for."""
    left = -stacked(entry.campaign, entry.base.errors)
    chosen: list[int] = []
    known = factors(entry)

    def bic(more: Sequence[int]) -> float:
        columns = np.column_stack([known, entry.columns[:, list(more)]])
        size = np.linalg.solve(columns.T @ columns + 1e-9 * np.eye(columns.shape[1]),
                               columns.T @ left)
        rest = left - columns @ size
        return len(left) * float(np.log(rest @ rest / len(left))) + columns.shape[1] * float(
            np.log(len(left)))

    best = bic(())
    while len(chosen) < len(entry.names):
        tried = {k: bic((*chosen, k)) for k in range(len(entry.names)) if k not in chosen}
        top = min(tried, key=lambda k: tried[k])
        if tried[top] >= best:
            break
        best = tried[top]
        chosen.append(top)
    return [entry.names[k] for k in chosen]


#: What the classifier sees of each signal's errors: correlations with these, and sizes.
_SEEN = ('pump_command', 'pprv_command', 'pump_outlet_pressure', 'motor_speed', 'oil_temperature')
_SIGNALS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')


def features(campaign: Campaign) -> np.ndarray:
    """Return statistics of the errors under the datasheet's model; NaN where not measured."""
    found: dict[str, list[np.ndarray]] = {name: [] for name in _SIGNALS}
    for error, column in zip(campaign.errors(Model()), campaign.columns):
        if column.signal in found:
            run = campaign.replays[column.log].run
            rows = np.union1d(column.fit, column.judge)
            error = np.clip(error[rows], -100.0, 100.0)
            seen = [np.nan_to_num(run[name][rows]) if name in run else np.zeros(len(rows))
                    for name in _SEEN]
            rates = [np.gradient(values) for values in seen[:4]]
            found[column.signal].append(np.array([
                np.mean(error), np.log(np.mean(error**2) + 1e-6), np.median(np.abs(error)),
                *(_correlation(error, values) for values in (*seen, *rates)),
                *(_correlation(np.abs(error), values) for values in seen)]))
    width = 3 + 2 * len(_SEEN) + 4
    return np.concatenate([np.mean(rows, axis=0) if rows else np.full(width, np.nan)
                           for rows in found.values()])


def _correlation(first: np.ndarray, second: np.ndarray) -> float:
    scale = float(np.std(first) * np.std(second))
    return float(np.mean((first - first.mean()) * (second - second.mean()))) / scale if (
        scale > 1e-12) else 0.0


def simulated(entry: Case, name: str | None, random: np.random.Generator) -> Campaign:
    """Return the campaign that another unit with one effect would have left."""
    campaign, runs = entry.campaign, []
    unit = {key: float(random.normal(0.0, size)) for key, size in campaign.tolerances.items()}
    effects = {}
    if name:
        size = campaign.parameter(name, next(iter(campaign.typical(name))))
        effects[name] = {**campaign.typical(name), size.name: size.neutral + (
            size.typical - size.neutral) * float(random.uniform(0.5, 1.5))}
    drive = campaign.driver(Model(effects, unit))
    for replay in campaign.replays:
        readings = replay.predict(drive)
        noisy = {signal: values + replay.noise[signal] * random.standard_normal(len(values))
                 for signal, values in readings.items() if signal in replay.signals}
        runs.append(dataclasses.replace(
            replay.run, channels={**replay.run.channels, **noisy}))
    return Campaign(campaign.rig, runs[:-1], runs[-1:])


def classifier(cases: Sequence[Case]) -> tuple[Callable[[Case], list[str]], float]:
    """Train on simulated drives; return what names one effect, and the seconds it took."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    begin, random = time.process_time(), np.random.default_rng(_SEED)
    rows, labels = [], []
    for name in (None, *cases[0].names):
        for _ in range(_OTHERS):
            entry = cases[int(random.integers(len(cases)))]
            if name is None or name in entry.names:
                rows.append(features(simulated(entry, name, random)))
                labels.append(name or 'none')
    learnt = HistGradientBoostingClassifier(max_iter=60, min_samples_leaf=5,
                                            random_state=_SEED).fit(np.array(rows), labels)

    def name_of(entry: Case) -> list[str]:
        shares = learnt.predict_proba(features(entry.campaign)[None])[0]
        best = str(learnt.classes_[int(np.argmax(shares))])
        return ['unknown'] if shares.max() < _SURE else [] if best == 'none' else [best]

    return name_of, time.process_time() - begin


def row_of(entry: Case, peer: str, found: list[str], seconds: float) -> dict:
    """Return one answer beside the truth."""
    return {'campaign': entry.folder, 'kind': entry.truth['kind'], 'peer': peer,
            'truth': sorted(entry.truth['effects']), 'found': found, 'seconds': seconds}


def answers(cases: Sequence[Case]) -> Iterator[dict]:
    """Yield the answers of all peers."""
    learnt, trained = classifier(cases)
    print(f'classifier trained in {trained:.0f} CPU s', file=sys.stderr)
    for entry in cases:
        for peer, decide in (('sparse regression', sparse_regression),
                             ('forward selection, BIC', forward_selection),
                             ('gradient boosting', learnt)):
            begin = time.process_time()
            found = decide(entry)
            yield row_of(entry, peer, found, entry.seconds + time.process_time() - begin)


def diagnosed(path: Path) -> Iterator[dict]:
    """Yield the answers of the diagnosis in the same form."""
    for line in map(json.loads, path.read_text(encoding='utf-8').splitlines()):
        found = ['unknown'] if line['verdict'] == 'unknown' else line['found']
        yield {'kind': line['kind'], 'peer': 'hst-drive diagnose', 'found': found,
               'truth': sorted(line['truth']['effects']), 'seconds': line['seconds'],
               'sure': line['verdict'] == 'missing_effect'}


def tally(rows: Sequence[dict]) -> str:
    """Return the table: a line for each peer."""
    lines = []
    for peer in dict.fromkeys(row['peer'] for row in rows):
        own = [row for row in rows if row['peer'] == peer]

        def share(kind: str, good: Callable[[dict], bool]) -> str:
            of_kind = [row for row in own if row['kind'] == kind]
            return wilson(sum(map(good, of_kind)), len(of_kind)) + f' of {len(of_kind)}'

        wrong = sum(bool(set(row['found']) - {*row['truth'], 'unknown'})
                    and row.get('sure', 'unknown' not in row['found']) for row in own)
        lines.append([peer, share('none', lambda row: not row['found']),
                      share('single', lambda row: row['found'] == row['truth']),
                      share('pair', lambda row: sorted(row['found']) == row['truth']),
                      share('unlisted', lambda row: 'unknown' in row['found']),
                      f'{wrong} of {len(own)}',
                      f"{np.median([row['seconds'] for row in own]):.1f}"])
    return table(['', 'healthy: nothing named', 'single: that alone', 'pair: exact',
                  'unlisted: unknown', 'named wrongly', 'seconds'], lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Let the peers answer and print the table."""
    parser = argparse.ArgumentParser(prog='python -m bench.peers', description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--json', type=Path, required=True, metavar='OUT.jsonl')
    parser.add_argument('--scored', type=Path, metavar='SCORED.jsonl')
    args = parser.parse_args(arguments)
    folders = sorted(path.parent for path in args.folder.glob('*/truth.json'))
    if not folders:
        parser.error(f'{args.folder}: no campaigns in it; python -m bench.unseen.make writes some')
    cases = []
    for folder in folders:
        try:
            cases.append(case(folder))
        except ValueError as error:
            print(f'{folder.name} left out: {error}', file=sys.stderr)
    rows = list(answers(cases))
    args.json.write_text(''.join(json.dumps(row) + '\n' for row in rows), encoding='utf-8')
    print(tally([*rows, *(diagnosed(args.scored) if args.scored else ())]))


if __name__ == '__main__':
    main()
