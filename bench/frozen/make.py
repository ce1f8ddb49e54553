# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Write frozen campaigns: ``python -m bench.frozen.make --seed N --count K -o FOLDER``."""
import argparse
from pathlib import Path
import sys

from bench.frozen import campaign, listed, unlisted
import numpy as np

#: Which of twenty campaigns are which: 20 % none, 35 % single, 15 % pair, 30 % unlisted.
MIX = ('single', 'unlisted', 'none', 'single', 'unlisted', 'pair', 'single', 'none', 'unlisted',
       'single', 'single', 'unlisted', 'none', 'pair', 'single', 'unlisted', 'single', 'none',
       'unlisted', 'pair')
#: A kind that moves no signal by so much of its noise, whatever its size, gives way to the next.
VISIBLE = 1.2


def deck(names: list[str], seed: int, number: int, salt: int) -> list[str]:
    """Return the names in a drawn order from the number-th on: each comes in its turn."""
    round_, place = divmod(number, len(names))
    order = [np.random.default_rng([seed, salt, r]).permutation(names)
             for r in (round_, round_ + 1)]
    return [str(name) for name in np.concatenate(order)[place:]]


def group_of(index: int, only: str | None) -> tuple[str, int]:
    """Return the group of a campaign, and its number within it."""
    if only:
        return only, index
    rounds, place = divmod(index, len(MIX))
    group = MIX[place]
    return group, rounds * MIX.count(group) + MIX[:place].count(group)


def make(seed: int, index: int, folder: Path, only: str | None = None, **fixed: object) -> dict:
    """
    Write one campaign and return its truth.

    Seed and index decide all. ``fixed`` overrules what is drawn, see ``campaign.setting``.
    """
    group, number = group_of(index, only)
    rng = np.random.default_rng([seed, index, 0])
    catalogue = unlisted.KINDS if group == 'unlisted' else listed.KINDS
    wanted = {'none': 0, 'pair': 2}.get(group, 1)
    names = deck(list(catalogue), seed, number if group != 'pair' else 2 * number,
                 len(group))
    strength = str(rng.choice(list(campaign.CLASSES), p=[c[2] for c in campaign.CLASSES.values()]))
    if wanted == 2 and strength == 'small':
        strength = 'typical'
    low, high, _ = campaign.CLASSES[strength]
    goals = np.exp(rng.uniform(np.log(low), np.log(high), 2))
    while True:
        # Two that change the same number of the machine would hide each other.
        kinds, sizes, moves = [], [], []
        bases = campaign.setting([], [seed, index], **fixed).base
        while len(kinds) < wanted:
            kind = catalogue[names.pop(0)](rng, bases)
            taken = {key for k in kinds for key in k.plant(k.low)}
            if not taken & set(kind.plant(kind.low)):
                kinds.append(kind)
        here = campaign.setting(kinds, [seed, index], **fixed)
        if kinds:
            gauge = campaign.Gauge(here)
            for kind, goal in zip(kinds, goals):
                size, moved = gauge.size(kind, goal, rng)
                sizes.append(size)
                moves.append(moved)
        if not moves or min(moves) >= VISIBLE:
            break
    own = list(kinds[0].effects) if group == 'unlisted' else [k.id for k in kinds]
    truth = {
        'kind': group, 'name': ' + '.join(k.id for k in kinds), 'effects': own,
        'parameters': campaign.parameters(here.base, kinds, sizes),
        'enters': [k.enters for k in kinds],
        'note': '; '.join(k.note for k in kinds if k.note),
        'strength': class_of(min(moves)) if kinds else '', 'moves': [round(m, 2) for m in moves],
        'rig': here.sheet['name'], 'unit_on_datasheet': exact(here),
        'row_rate_Hz': 1000 / here.each_ms, 'missing': list(here.missing),
        'seed': seed, 'index': index}
    campaign.write(folder, here, kinds, sizes, truth)
    return truth


def class_of(moved: float) -> str:
    """Return the class of campaign.CLASSES of what moves the worst signal so far."""
    return next((name for name, (_, high, _) in campaign.CLASSES.items() if moved < high),
                'strong')


def exact(here: campaign.Setting) -> bool:
    """Tell whether a unit is exactly on its datasheet."""
    sheet = campaign.build(here.sheet, campaign.datasheet.unit(here.sheet, None))
    return sheet.inertia == here.base.inertia


def main(arguments: list[str] | None = None) -> None:
    """Write the campaigns that are not there yet."""
    parser = argparse.ArgumentParser(prog='python -m bench.frozen.make', description=__doc__)
    parser.add_argument('--seed', type=int, required=True)
    parser.add_argument('--count', type=int, required=True)
    parser.add_argument('-o', '--output', type=Path, required=True, metavar='FOLDER')
    parser.add_argument('--kind', choices=sorted(set(MIX)), help='only these (default: the mix)')
    args = parser.parse_args(arguments)
    for index in range(args.count):
        folder = args.output / f'{args.seed}_{index:04d}'
        if (folder / 'truth.json').exists():
            continue
        make(args.seed, index, folder, args.kind)
        print(f'{index + 1} of {args.count}', file=sys.stderr)


if __name__ == '__main__':
    main()
