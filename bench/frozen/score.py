# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Diagnose frozen campaigns and print how often the answer is right.

``python -m bench.frozen.score FOLDER --json out.jsonl --jobs 1``. Each campaign is a process of
its own; interrupted, the same command goes on where it was.
"""
import argparse
from concurrent.futures import ThreadPoolExecutor
import json
from pathlib import Path
import subprocess
import sys
import tempfile
import time

from bench.frozen import profiles, tally

#: s, after which a diagnosis is given up.
PATIENCE = 1800


def command(*words: object) -> tuple[int, str, dict | None]:
    """Run a verb of hst-drive; return exit code, last line of the errors, and its JSON."""
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / 'answer.json'
        try:
            done = subprocess.run(
                [sys.executable, '-m', 'hst_drive', *map(str, words), '--json', str(answer)],
                capture_output=True, text=True, timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return -1, f'no answer within {PATIENCE} s', None
        found = json.loads(answer.read_text(encoding='utf-8')) if answer.exists() else None
    said = done.stderr.strip().splitlines()
    return done.returncode, said[-1] if said else '', found


def known_effects() -> list[str]:
    """Return the ids that the diagnosis can name at all."""
    code, said, found = command('effects')
    if found is None:
        raise SystemExit(f'hst-drive effects ended with {code}: {said}')
    return sorted(effect['id'] for effect in found['effects'])


def worst(ratios: dict) -> float | None:
    """Return the largest noise ratio of a set of logs."""
    numbers = [v for v in ratios.values() if isinstance(v, (int, float))]
    return max(numbers) if numbers else None


def judge(folder: Path) -> dict:
    """Diagnose one campaign; return what was said beside the truth."""
    rig = folder / 'rig.yaml'
    logs = [folder / f'{log}.csv' for log in profiles.LOGS if 'holdout' not in log]
    begun = time.monotonic()
    code, said, found = command(
        'diagnose', *logs, '--holdout', folder / 'drilling_holdout.csv',
        *(['--rig', rig] if rig.exists() else []))
    row = {'campaign': folder.name, 'truth': json.loads((folder / 'truth.json').read_text()),
           'seconds': round(time.monotonic() - begun, 1), 'exit': code}
    if code or found is None:
        return row | {'verdict': 'failed', 'error': said}
    named = [e['id'] for e in found['effects']]
    rivals = sorted({r for e in found['effects'] for r in e.get('indistinguishable_from') or ()})
    holdout = found.get('holdout') or {}
    return row | {
        'verdict': found['verdict'], 'named': named, 'rivals': rivals,
        'unknown_enters': (found.get('unknown') or {}).get('enters'),
        'before': worst(holdout.get('before') or {}), 'after': worst(holdout.get('after') or {}),
        'probability': found.get('probability')}


def read(path: Path) -> list[dict]:
    """Return the rows of a file that earlier calls wrote; a torn last row counts as not there."""
    rows = []
    for line in path.read_text(encoding='utf-8').splitlines() if path.exists() else ():
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Score what is not scored yet and print the table of all."""
    parser = argparse.ArgumentParser(prog='python -m bench.frozen.score', description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--json', type=Path, required=True, metavar='FILE.jsonl')
    parser.add_argument('--jobs', type=int, default=1)
    args = parser.parse_args(arguments)
    folders = sorted(p.parent for p in args.folder.glob('*/truth.json'))
    if not folders:
        parser.error(f'{args.folder}: no campaigns (folders with truth.json) in it; '
                     'write some with python -m bench.frozen.make')
    known = known_effects()
    rows = read(args.json)
    done = {row['campaign'] for row in rows}
    # All rows are written once more: a torn one would stay in the middle.
    with args.json.open('w', encoding='utf-8') as out:
        out.writelines(json.dumps(row) + '\n' for row in rows)
        out.flush()
        with ThreadPoolExecutor(args.jobs) as pool:
            for row in pool.map(judge, [f for f in folders if f.name not in done]):
                rows.append(row)
                out.write(json.dumps(row) + '\n')
                out.flush()
                print(f'{len(rows)} of {len(folders)}', file=sys.stderr)
    here = {f.name for f in folders}
    print(tally.table([row for row in rows if row['campaign'] in here], known))


if __name__ == '__main__':
    main()
