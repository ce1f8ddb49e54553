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
import json
import os
from pathlib import Path
import platform
import sys
import time

from bench.campaigns import campaign, Task, tasks, VISIBLE
from hst_drive.cli.output import table
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import default_rig
import numpy as np
from scipy.stats import norm

# Where the truth's first form is our equation: our parameter and the truth's.
_SAME = {'motor_leakage': ('laminar', 'conductance', 'g_motor'),
         'pump_leakage': ('laminar', 'conductance', 'g_pump'),
         'leakage_temperature': ('walther', 'exponent', 'k_visc'),
         'bearing_friction': ('tanh', 'coulomb', 't_coul'),
         'pump_hysteresis': ('play', 'width', 'play')}


def judge(task: Task) -> dict:
    """Diagnose one campaign and return what is needed to score it."""
    runs, held, truth, visible = campaign(task)
    start = time.perf_counter()
    found = diagnose(default_rig(), runs, held)
    seconds = time.perf_counter() - start
    after = found.ladder[-1].holdout
    values = {}
    for entry in found.effects:
        form, ours, theirs = _SAME.get(entry.id, ('', '', ''))
        if truth['forms'].get(entry.id) == form and form:
            value = entry.parameters[ours]
            values[entry.id] = [value.value, value.low, value.high,
                                truth['si_parameters'][theirs]]
    return {'kind': task.kind, 'seed': task.seed, 'effects': task.effects,
            'forms': truth['forms'], 'enters': truth['enters'], 'visible': visible,
            'verdict': found.verdict, 'found': [entry.id for entry in found.effects],
            'rivals': [list(entry.indistinguishable_from) for entry in found.effects],
            'not_observable': sorted(found.not_observable),
            'place': found.unknown.enters if found.unknown else None,
            'after': float(np.sqrt(np.mean(np.square(list(after.values()))))),
            'values': values, 'seconds': seconds}


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


def report(rows: list[dict]) -> str:
    """Return the table."""
    none = [row for row in rows if row['kind'] == 'none']
    single = [row for row in rows if row['kind'] == 'single' and row['visible'] >= VISIBLE]
    pair = [row for row in rows if row['kind'] == 'pair' and row['visible'] >= VISIBLE]
    outside = [row for row in rows if row['kind'] == 'outside' and row['visible'] >= VISIBLE]

    def named(row: dict) -> set[str]:
        return set(row['found']).union(*row['rivals'])

    def truth(row: dict) -> str:
        return next(iter(row['effects']))

    lines = []

    def add(what: str, hits: int, among: list[dict], goal: str) -> None:
        lines.append([what, wilson(hits, len(among)), str(len(among)), goal])

    add('first name right (single)', sum(row['found'][:1] == [truth(row)] for row in single),
        single, '97 %')
    add('truth in the reported set', sum(truth(row) in named(row) for row in single), single,
        '99 %')
    add('false alarm (none)', sum(bool(row['found']) for row in none), none, 'at most 1 %')
    add('none called unknown', sum(row['verdict'] == 'unknown' for row in none), none, '')
    add('confident and wrong (single)', sum(
        row['verdict'] == 'missing_effect' and set(row['found']) != {truth(row)}
        for row in single), single, 'at most 2 %')
    add('single called unknown', sum(row['verdict'] == 'unknown' for row in single), single, '')
    add('exact pairs', sum(set(row['found']) == set(row['effects']) for row in pair), pair,
        '90 %')
    add('outside the catalogue flagged', sum(row['verdict'] == 'unknown' for row in outside),
        outside, '97 %')
    flagged = [row for row in outside if row['verdict'] == 'unknown']
    add('right balance', sum(row['place'] == next(iter(row['enters'].values()))
                             for row in flagged), flagged, '95 %')
    values = [value for row in rows for value in row['values'].values()]
    add('95 % interval covers', sum(low <= true <= high for _, low, high, true in values), values,
        '90 to 98 %')
    sizes = [len(named(row)) for row in single if row['found']]
    errors = [abs(value / true - 1) for value, _, _, true in values]
    after = [row['after'] for row in single if truth(row) in row['found']]
    times = [row['seconds'] for row in rows]
    for what, number, goal in (
            ('mean set size', f'{np.mean(sizes):.2f}' if sizes else '-', 'at most 1.5'),
            ('held-out noise ratio after (median)', f'{np.median(after):.2f}' if after else '-',
             'at most 1.1'),
            ('size error (median)', f'{100 * np.median(errors):.1f} %' if errors else '-',
             '5 %'),
            ('seconds per diagnosis, median and greatest',
             f'{np.median(times):.1f}, {max(times):.1f}', '15')):
        lines.append([what, number, '', goal])
    return table(['measure', 'result', 'cases', 'goal'], lines)


def main() -> None:
    """Run the benchmark, or what is left of it, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--part', choices=('dev', 'score'), default='dev')
    parser.add_argument('--every', type=int, default=1, help='only every n-th campaign')
    parser.add_argument('--jobs', type=int, default=os.cpu_count())
    parser.add_argument('--output', help='JSON lines (default: diagnosis_PART.jsonl)')
    args = parser.parse_args()
    output = Path(args.output or f'diagnosis_{args.part}.jsonl')
    rows = [json.loads(line) for line in output.read_text().splitlines()] \
        if output.exists() else []
    done = {row['seed'] for row in rows}
    left = [task for task in tasks(args.part)[::args.every] if task.seed not in done]
    with ProcessPoolExecutor(args.jobs) as pool, output.open('a') as file:
        futures = [pool.submit(judge, task) for task in left]
        for number, future in enumerate(as_completed(futures), 1):
            row = future.result()
            rows.append(row)
            file.write(json.dumps(row) + '\n')
            file.flush()
            print(f"{number} of {len(left)}: {row['kind']} {row['effects']} -> {row['verdict']} "
                  f"{row['found']}", file=sys.stderr)
    print(f'{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python '
          f'{platform.python_version()}, {args.jobs} jobs, {len(rows)} campaigns of 4 x 60 s; '
          f'detectable: moves a signal by {VISIBLE:g} noise deviations rms\n')
    print(report(rows))


if __name__ == '__main__':
    main()
