# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Do intervals of sizes hold the truth? ``python -m bench.coverage --seeds 20 --json sizes.jsonl``.

Each effect whose formula in ``test/truth`` is ours is hidden in machines of other seeds, at 0.5 to
1.5 of its typical size, and fitted alone: what a diagnosis tells of its size once it has its name.
Interrupted, the same command goes on where it was.
"""
import argparse
import json
from pathlib import Path
import random
from test.truth import make_campaign

from bench.campaigns import as_runs
from bench.score import wilson
from bench.sizes import SAME, true_size
from hst_drive.cli.output import table
from hst_drive.identify.campaign import Campaign
from hst_drive.identify.fit import for_sizes
from hst_drive.identify.intervals import intervals
from hst_drive.identify.search import Search
from hst_drive.identify.standing import forms
import numpy as np

_FIRST = 950_000    # seed
_SECONDS = 40.0
EFFECTS = ('motor_leakage', 'pump_leakage', 'elastic_leakage', 'compressibility_flow',
           'entrained_air', 'leakage_temperature', 'pump_speed_droop', 'pump_command_offset',
           'pump_hysteresis', 'viscous_drag', 'gearbox_loss', 'flow_sensor_scale')


def sized(effect: str, seed: int) -> dict:
    """Hide an effect, fit it alone; return its size and interval over the truth."""
    form, key, _ = SAME[effect]
    share = random.Random(f'{effect} {seed}').uniform(0.5, 1.5)
    made = make_campaign(seed, {effect: {'size': share, 'form': form}}, duration=_SECONDS)
    rig, runs, held_out = as_runs(made)
    search = Search(Campaign(rig, runs, held_out), (effect,))
    best = search.refine(search.single(effect))
    campaign, fitted = for_sizes(search.campaign, best.fit)
    low, high = intervals(campaign, fitted, forms(search, best))[effect, key]
    true = true_size(effect, made, rig)
    low, high = sorted((low / true, high / true))
    return {'effect': effect, 'seed': seed, 'true': true, 'low': low, 'high': high,
            'value': fitted.model.effects[effect][key] / true}


def line(name: str, rows: list[dict]) -> list[str]:
    """Return what a table says of some sizes; widths over the scatter of the estimates."""
    held = sum(row['low'] <= 1.0 <= row['high'] for row in rows)
    off = np.array([row['value'] - 1.0 for row in rows])
    width = np.median([(row['high'] - row['low']) / (2 * 1.96) for row in rows])
    scatter = off.std(ddof=1) if len(off) > 1 else np.nan
    return [name, str(len(rows)), wilson(held, len(rows)), f'{100 * off.mean():+.1f} %',
            f'{100 * np.median(np.abs(off)):.1f} %', f'{width / scatter:.1f}']


def main() -> None:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seeds', type=int, default=20)
    parser.add_argument('--first', type=int, default=_FIRST, help='first seed')
    parser.add_argument('--json', type=Path, required=True)
    args = parser.parse_args()
    done = [json.loads(text) for text in args.json.read_text(encoding='utf-8').splitlines()
            ] if args.json.is_file() else []
    known = {(row['effect'], row['seed']) for row in done}
    for seed in range(args.first, args.first + args.seeds):
        for effect in EFFECTS:
            if (effect, seed) not in known:
                done.append(sized(effect, seed))
                with args.json.open('a', encoding='utf-8') as file:
                    file.write(json.dumps(done[-1]) + '\n')
    rows = [line(name, [row for row in done if row['effect'] == name]) for name in EFFECTS]
    print(table(['effect', 'sizes', 'inside its 95 % interval', 'off, mean', 'off, median',
                 'width over scatter'], [*rows, line('all', done)]))


if __name__ == '__main__':
    main()
