# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often the diagnosis is right on other circuits.

``python -m bench.circuits --circuit closed --seed 1000 --count 30 --json out.jsonl``. Campaigns
come from ``test.truth.closed``, an independent generator: of ten two are healthy, six hide one
listed effect, one hides two, one something that is not listed. Interrupted, the same command goes
on where it was. Of what came out wrong ``visible_circuits`` says whether it could be seen.

All its machines leak as their oil's viscosity has it, hidden effect or not, but for those whose
oil warms up for another effect. So ``leakage_temperature`` is true in them: it counts neither as
a false alarm nor as found.
"""
import argparse
import json
from pathlib import Path
import tempfile
from test.truth.closed import catalogue, make
import time

from bench.visible import detectable
from bench.visible_circuits import visible
from hst_drive.bag import read_log
from hst_drive.diagnose.decide import diagnose
from hst_drive.diagnose.result import as_json
from hst_drive.errors import InputError
from hst_drive.rig import load_rig

KINDS = ('none', *['single'] * 3, 'unlisted', 'none', *['single'] * 3, 'pair')


def judged(circuit: str, seed: int, kind: str) -> dict:
    """Make and diagnose one campaign; return what was said beside the truth."""
    made = make.make_campaign(circuit, seed, kind=kind)
    with tempfile.TemporaryDirectory() as folder:
        place = make.write_campaign(made, Path(folder))
        begun = time.process_time()
        logs = {path.stem: read_log(str(path)) for path in sorted(place.glob('*.csv'))}
        held_out = logs.pop('holdout')
        try:
            found = diagnose(load_rig(place / 'rig.yaml'), [*logs.values()], [held_out])
        except InputError as error:
            return {'seed': seed, 'kind': kind, 'verdict': 'error', 'right': False,
                    'said': str(error)}
    truth = made.truth
    known = {**catalogue.LISTED[circuit], **catalogue.OUTSIDE[circuit]}
    always = set() if any(known[name].warm for name in truth['sizes']) else {
        'leakage_temperature'}
    sets = {entry.id: {entry.id, *entry.indistinguishable_from} for entry in found.effects
            if entry.id not in always}
    named, wanted = [*sets], sorted(truth['effects'])
    right = {'none': found.verdict != 'unknown' and not named,
             'single': named[:1] == wanted, 'pair': sorted(named) == wanted,
             'unlisted': found.verdict == 'unknown'}[kind]
    return {'seed': seed, 'kind': kind, 'effects': wanted, 'hidden': sorted(truth['enters']),
            'always': sorted(always), 'probability': as_json(found)['probability'],
            'verdict': found.verdict, 'right': right,
            'named': [entry.id for entry in found.effects],
            'alone': right and found.verdict != 'unknown' and sorted(named) == wanted,
            'look_alike': right or bool(named) and named[0] in sum(
                truth['look_alikes'].values(), []),
            'in_set': right or bool(wanted) and set(wanted) <= set().union(*sets.values()),
            'enters': found.unknown.enters if found.unknown else None,
            'seconds': round(time.process_time() - begun, 1),
            'detectable': right or detectable(visible(made)), 'said': found.sentence}


def tally(done: list[dict], kind: str) -> str:
    """Say how often campaigns of one kind came out right."""
    rows = [row for row in done if row['kind'] == kind]
    seen = [row for row in rows if row.get('detectable')]

    def count(key: str) -> int:
        return sum(bool(row.get(key)) for row in seen)

    return (f'{kind}: {len(rows)}, could be seen {len(seen)}; of these right {count("right")} '
            f'(and nothing beside {count("alone")}), in the set {count("in_set")}, right or what '
            f'looks the same there {count("look_alike")}')


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
        print(*(f'{key}={value}' for key, value in done[-1].items()
                if key not in ('said', 'probability')), flush=True)
    for kind in dict.fromkeys(KINDS):
        if any(row['kind'] == kind for row in done):
            print(tally(done, kind))


if __name__ == '__main__':
    main()
