# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Write campaigns: python -m bench.unseen.make --seed 1000 --count 20 -o FOLDER."""
import argparse
import json
from pathlib import Path

from bench.unseen import datasheet, recorder
from bench.unseen.campaign import find, Found
from bench.unseen.stepper import TICK
import numpy as np

# Channel -> effect -> what cannot be told from it where the channel is missing: the flow meter
# parts the leaks before it from those behind, the torque sensor the motor's friction from the
# gear's.
ALIKE_WITHOUT = {
    'motor_inlet_flow': {'pump_leakage': ('motor_leakage',)},
    'load_torque': {'bearing_friction': ('gearbox_loss',)},
}


def truth(found: Found) -> dict:
    """Return what was done to the drive, in SI."""
    where, drawn = found.setting, found.setting.asked.drawn
    asked = where.asked
    also = {name for one in drawn for name in one.also}
    for channel in asked.missing:
        for one in drawn:
            also.update(ALIKE_WITHOUT.get(channel, {}).get(one.fault.id, ()))
    return {
        'kind': asked.kind,
        'effects': {one.fault.id: {one.fault.parameter: value, 'unit': one.fault.unit,
                                   'form': one.form_name, 'enters': one.fault.enters}
                    for one, value in zip(drawn, found.values)},
        'enters': drawn[0].fault.enters if drawn else None,
        'signal': drawn[0].fault.signal if drawn else None,
        'note': ' '.join(one.fault.note for one in drawn) or 'A healthy drive.',
        'also': sorted(also - {one.fault.id for one in drawn}),
        'moves': found.moves,
        'moves_each': list(found.moves_each),
        'bands': [list(band) for band in asked.bands],
        'seed': where.seed,
        'unit_on_datasheet': asked.on_datasheet,
        'other_size': asked.other_size,
        'row_s': asked.row,
        'missing': list(asked.missing),
        'stamps': {'jitter': asked.jitter, 'lost': asked.lost},
    }


def write(found: Found, folder: Path) -> None:
    """Write logs, rig and truth of a campaign."""
    where, asked = found.setting, found.setting.asked
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([where.seed, 5])
    for log, run in zip(where.logs, found.runs):
        at = recorder.rows(len(run.out), log.given.before, round(asked.row / TICK), asked.jitter,
                           asked.lost, rng)
        columns = recorder.table(log.given, run.out, run.readings, run.celsius, where.sheet, at,
                                 rng)
        recorder.write(folder / f'{log.given.name}.csv', columns, asked.missing)
    size = 'a rig of another size' if asked.other_size else 'the test rig'
    (folder / 'rig.yaml').write_text(
        f'# Datasheet of {size}.\n{datasheet.as_yaml(where.sheet)}\n', encoding='utf-8')
    (folder / 'truth.json').write_text(json.dumps(truth(found), indent=1) + '\n',
                                       encoding='utf-8')


def main() -> None:
    """Write the campaigns that the command line asks for; those that are there stay."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seed', type=int, required=True)
    parser.add_argument('--count', type=int, default=20)
    parser.add_argument('-o', '--output', type=Path, required=True)
    arguments = parser.parse_args()
    for i in range(arguments.count):
        folder = arguments.output / f'{i:04d}'
        # truth.json is written last: a campaign without it is not whole.
        if (folder / 'truth.json').is_file():
            continue
        found = find(arguments.seed + i)
        write(found, folder)
        worst = max(found.moves.values(), default=0.0)
        names = ' + '.join(one.fault.id for one in found.setting.asked.drawn) or 'healthy'
        print(f'{folder.name}: {found.setting.asked.kind}, {names}, moves {worst:.1f}',
              flush=True)


if __name__ == '__main__':
    main()
