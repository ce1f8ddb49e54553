# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often the diagnosis is right on other circuits.

``python -m bench.circuits --circuit closed --seed 1000 --count 30 --json out.jsonl``. Campaigns
come from ``test.truth.closed``, an independent generator: of ten two are healthy, six hide one
listed effect, one hides two, one something that is not listed. Interrupted, the same command goes
on where it was.

All its machines leak as their oil's viscosity has it, hidden effect or not, but for those whose
oil warms up for another effect. So ``leakage_temperature`` is true in them: it counts neither as
a false alarm nor as found.
"""
import argparse
import json
from pathlib import Path
import tempfile
from test.truth.closed import catalogue, make

from bench.frozen.score import command

KINDS = ('none', *['single'] * 3, 'unlisted', 'none', *['single'] * 3, 'pair')


def judged(circuit: str, seed: int, kind: str) -> dict:
    """Make and diagnose one campaign; return what was said beside the truth."""
    with tempfile.TemporaryDirectory() as folder:
        make.main(['--circuit', circuit, '--seed', str(seed), '--count', '1', '--kind', kind,
                   '-o', folder])
        place = Path(folder) / '0000'
        truth = json.loads((place / 'truth.json').read_text(encoding='utf-8'))
        logs = sorted(path for path in place.glob('*.csv') if path.stem != 'holdout')
        _, said, found = command('diagnose', *logs, '--holdout', place / 'holdout.csv',
                                 '--rig', place / 'rig.yaml')
    found = found or {'verdict': 'error', 'effects': [], 'unknown': None}
    known = {**catalogue.LISTED[circuit], **catalogue.OUTSIDE[circuit]}
    always = set() if any(known[name].warm for name in truth['sizes']) else {
        'leakage_temperature'}
    named = [entry['id'] for entry in found['effects'] if entry['id'] not in always]
    wanted = sorted(truth['effects'])
    alike = [entry for entry in found['effects'] if set(entry['indistinguishable_from']) & set(
        wanted)]
    right = {'none': found['verdict'] not in ('unknown', 'error') and not named,
             'single': named[:1] == wanted, 'pair': sorted(named) == wanted,
             'unlisted': found['verdict'] == 'unknown'}[kind]
    return {'seed': seed, 'kind': kind, 'truth': wanted or sorted(truth['enters']),
            'verdict': found['verdict'], 'right': right,
            'named': [entry['id'] for entry in found['effects']],
            'look_alike': right or bool(named) and named[0] in sum(
                truth['look_alikes'].values(), []),
            'in_set': right or bool(alike) or set(wanted) & set(named) != set(),
            'enters': (found['unknown'] or {}).get('enters'), 'said': said}


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--circuit', choices=('closed', 'valve'), default='closed')
    parser.add_argument('--seed', type=int, default=1000)
    parser.add_argument('--count', type=int, default=30)
    parser.add_argument('--json', type=Path, required=True)
    args = parser.parse_args()
    done = [json.loads(line) for line in args.json.read_text(encoding='utf-8').splitlines()
            ] if args.json.exists() else []
    for number in range(len(done), args.count):
        done.append(judged(args.circuit, args.seed + number, KINDS[number % len(KINDS)]))
        with args.json.open('a', encoding='utf-8') as file:
            file.write(json.dumps(done[-1]) + '\n')
        print(*(f'{key}={value}' for key, value in done[-1].items() if key != 'said'), flush=True)
    for kind in dict.fromkeys(KINDS):
        rows = [row for row in done if row['kind'] == kind]
        if rows:
            print(f"{kind}: right {sum(row['right'] for row in rows)} of {len(rows)}, true name "
                  f"told {sum(row['in_set'] for row in rows)}, right or what looks the same "
                  f"there {sum(row['look_alike'] for row in rows)}")


if __name__ == '__main__':
    main()
