# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Have campaigns diagnosed and count: python -m bench.unseen.score FOLDER --json OUT.jsonl."""
import argparse
from collections.abc import Iterator
from concurrent.futures import as_completed, ThreadPoolExecutor
import json
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile
import time

KINDS = ('none', 'single', 'pair', 'unlisted')


def program() -> str:
    """Return the installed command: that of this Python, else the first on PATH."""
    beside = Path(sys.executable).with_name('hst-drive')
    found = str(beside) if beside.is_file() else shutil.which('hst-drive')
    if not found:
        sys.exit('hst-drive is neither beside this Python nor on PATH: install the package first')
    return found


def diagnosed(folder: Path, command: str) -> dict:
    """Return the line of one campaign: its truth, and what the diagnosis said."""
    truth = json.loads((folder / 'truth.json').read_text(encoding='utf-8'))
    logs = sorted(path.name for path in folder.glob('*.csv') if path.name != 'holdout.csv')
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as aside:
        answer = Path(aside) / 'diagnosis.json'
        done = subprocess.run([command, 'diagnose', *logs, '--holdout', 'holdout.csv', '--rig',
                               'rig.yaml', '--json', str(answer)], cwd=folder, text=True,
                              capture_output=True, check=False)
        text = answer.read_text(encoding='utf-8') if answer.is_file() else ''
    line = {'seed': truth['seed'], 'kind': truth['kind'], 'truth': truth, 'verdict': 'failed',
            'found': [], 'rivals': [], 'place': None, 'probability': {}, 'values': {},
            'seconds': round(time.monotonic() - begin, 2)}
    if done.returncode or not text:
        line['error'] = f'{done.returncode}: ' + ' '.join(done.stderr.split())[-400:]
        return line
    said = json.loads(text)
    effects = said['effects']
    line.update(
        verdict=said['verdict'], found=[effect['id'] for effect in effects],
        rivals=[effect.get('indistinguishable_from', []) for effect in effects],
        place=(said.get('unknown') or {}).get('enters'),
        probability=said.get('probability', {}),
        values={effect['id']: effect['parameters'] for effect in effects})
    return line


def marks(line: dict) -> dict[str, bool]:
    """Return how one answer counts, by the name of the count."""
    true, found = set(line['truth']['effects']), line['found']
    also = set(line['truth'].get('also', ()))
    named = line['verdict'] in ('missing_effect', 'ambiguous')
    offered = {name for rivals in line['rivals'] for name in rivals} | set(found)
    amiss = set(found) - true
    wrong = line['verdict'] == 'missing_effect' and bool(amiss) and not amiss & also
    listed = line['kind'] in ('single', 'pair')
    return {
        'first name right': listed and named and bool(found) and found[0] in true,
        'exact set': (listed and named and set(found) == true)
        or (line['kind'] == 'none' and line['verdict'] == 'none'),
        'in the set': listed and named and true <= offered,
        'false alarm': line['kind'] == 'none' and line['verdict'] not in ('none', 'failed'),
        'unlisted flagged': line['kind'] == 'unlisted' and line['verdict'] == 'unknown',
        'place right': line['verdict'] == 'unknown' and line['kind'] == 'unlisted'
        and line['place'] == line['truth']['enters'],
        'confident and wrong': wrong,
        '  and nothing right': wrong and not true & set(found),
        'failed': line['verdict'] == 'failed',
    }


def summary(lines: list[dict]) -> Iterator[str]:
    """Yield a table: what was counted, by kind."""
    groups = [[line for line in lines if line['kind'] == kind] for kind in KINDS]
    yield f'{"":22}' + ''.join(f'{kind:>10}' for kind in KINDS)
    yield f'{"campaigns":22}' + ''.join(f'{len(group):>10}' for group in groups)
    counted = [[marks(line) for line in group] for group in groups]
    for name in marks({'truth': {'effects': {}}, 'kind': '', 'found': [], 'rivals': [],
                       'verdict': '', 'place': None}):
        yield f'{name:22}' + ''.join(f'{sum(mark[name] for mark in group):>10}'
                                     for group in counted)


def main() -> None:
    """Diagnose what has no line yet; print the table of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--json', type=Path, required=True)
    parser.add_argument('--jobs', type=int, default=1)
    arguments = parser.parse_args()
    lines = []
    if arguments.json.is_file():
        lines = [json.loads(text) for text in
                 arguments.json.read_text(encoding='utf-8').splitlines() if text]
    there = {line['seed'] for line in lines}
    folders = sorted(path.parent for path in arguments.folder.glob('*/truth.json'))
    left = [folder for folder in folders if json.loads(
        (folder / 'truth.json').read_text(encoding='utf-8'))['seed'] not in there]
    command = program() if left else ''
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for future in as_completed([pool.submit(diagnosed, folder, command) for folder in left]):
            line = future.result()
            lines.append(line)
            with arguments.json.open('a', encoding='utf-8') as file:
                file.write(json.dumps(line) + '\n')
            print(f'{line["seed"]}: {line["kind"]}, {line["verdict"]}, {line["seconds"]} s',
                  file=sys.stderr, flush=True)
    print('\n'.join(summary(lines)))


if __name__ == '__main__':
    main()
