# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often is the diagnosis right? A seeded benchmark on campaigns of an independent rig.

``python -m bench.diagnosis --part dev`` while developing; the score part is for one run at the
end. Results go to a file line by line, so that an interrupted run goes on where it stopped.
"""
from __future__ import annotations

import argparse
from concurrent.futures import as_completed, ProcessPoolExecutor
from importlib.metadata import PackageNotFoundError, version
import json
import os
from pathlib import Path
import platform
import sys
import time
import traceback

from bench.campaigns import as_runs, campaign, ROUNDS, Task, tasks
from bench.score import report, right
from bench.sizes import sizes
from bench.visible import detectable, visible
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
import numpy as np


def judge(task: Task) -> dict:
    """Diagnose one campaign and return what is needed to score it."""
    made = campaign(task)
    seen = visible(task, made)
    rig, runs, held = as_runs(made)
    made.exact.clear()
    start, spent = time.perf_counter(), time.process_time()
    found = diagnose(rig, runs, held)
    seconds, spent = time.perf_counter() - start, time.process_time() - spent
    after = found.ladder[-1].holdout
    return {'kind': task.kind, 'seed': task.seed, 'effects': task.effects,
            'options': task.options, 'forms': made.truth['forms'],
            'enters': made.truth['enters'], 'depends_on': made.truth['depends_on'],
            'seen': seen, 'verdict': found.verdict,
            'found': [entry.id for entry in found.effects],
            'rivals': [list(entry.indistinguishable_from) for entry in found.effects],
            'place': found.unknown.enters if found.unknown else None,
            'formula': found.unknown.expression if found.unknown else None,
            'not_observable': sorted(found.not_observable),
            'after': float(np.sqrt(np.mean(np.square(list(after.values()))))),
            'ladder': [[step.added, _short(step.training), _short(step.holdout)]
                       for step in found.ladder],
            'ranking': [[entry.id, round(entry.holdout_noise_ratio, 3), round(entry.evidence)]
                        for entry in found.ranking[:6]],
            'calibration': [[entry.quantity, round(entry.sigmas, 2)]
                            for entry in found.calibration[:4]],
            'values': sizes(found, made, rig),
            'probability': as_json(found)['probability'], 'seconds': seconds, 'cpu_seconds': spent}


def _short(ratios: dict[str, float]) -> dict[str, float]:
    return {name: round(value, 3) for name, value in ratios.items()}


def machine(jobs: int) -> str:
    """Return what the times depend on."""
    model = platform.processor() or platform.machine()
    info = Path('/proc/cpuinfo')
    if info.exists():
        model = next((line.split(':')[1].strip() for line in info.read_text().splitlines()
                      if line.startswith('model name')), model)
    parts = [model, f'{os.cpu_count()} cores', f'{jobs} jobs at once',
             f'Python {platform.python_version()}']
    for name in ('numpy', 'scipy', 'numba'):
        try:
            parts.append(f'{name} {version(name)}')
        except PackageNotFoundError:
            parts.append(f'no {name}')
    return ', '.join(parts)


def told(row: dict) -> str:
    """Return one line on a campaign."""
    hidden = ' + '.join(f'{name} {size:g} {row["forms"][name]} ({row["seen"][name]["moves"]:.1f} '
                        f'sigma, {row["seen"][name]["beyond"]:.1f} beyond)'
                        for name, size in row['effects'].items())
    sets = [entry + (f' or {"/".join(rivals)}' if rivals else '')
            for entry, rivals in zip(row['found'], row['rivals'])]
    mark = 'ok   ' if right({**row, 'detectable': detectable(row['seen'])}) else 'WRONG'
    return (f"{mark} {row['kind']} {row['seed']}: {hidden or 'nothing'} -> {row['verdict']} "
            f"{' + '.join(sets)}{' at ' + row['place'] if row['place'] else ''}, "
            f"{row['after']:.2f}, {row['seconds']:.0f} s")


def main() -> None:
    """Run the benchmark, or what is left of it, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--part', choices=('dev', 'score'), default='dev')
    parser.add_argument('--rounds', type=int, default=ROUNDS,
                        help='a round has each effect once (54 campaigns)')
    parser.add_argument('--kind', nargs='+', help='none, single, pair, outside')
    parser.add_argument('--effect', nargs='+', help='campaigns with one of these effects')
    parser.add_argument('--jobs', type=int, default=os.cpu_count())
    parser.add_argument('--json', '--output', help='JSON lines (default: diagnosis_PART.jsonl)')
    args = parser.parse_args()
    output = Path(args.json or f'diagnosis_{args.part}.jsonl')
    rows = [json.loads(line) for line in output.read_text().splitlines()] \
        if output.exists() else []
    done = {row['seed'] for row in rows}
    left = [task for task in tasks(args.part, args.rounds) if task.seed not in done
            and (not args.kind or task.kind in args.kind)
            and (not args.effect or set(args.effect) & set(task.effects))]
    with ProcessPoolExecutor(args.jobs) as pool, output.open('a', encoding='utf-8') as file:
        futures = {pool.submit(judge, task): task for task in left}
        for number, future in enumerate(as_completed(futures), 1):
            try:
                row = future.result()
            except Exception:
                print(f'{futures[future]}:\n{traceback.format_exc()}', file=sys.stderr)
                continue
            rows.append(row)
            file.write(json.dumps(row) + '\n')
            file.flush()
            print(f'{number} of {len(left)} {told(row)}', file=sys.stderr, flush=True)
    print(f'{machine(args.jobs)}; part {args.part}, {len(rows)} campaigns of 4 x 60 s\n')
    print(report(rows))


if __name__ == '__main__':
    main()
