# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Write one campaign: `python -m test.truth --seed 3 --effects line_loss --out DIR`."""

import argparse

from . import make_campaign, write_campaign


def main() -> None:
    """Read the arguments and write the campaign."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--effects', default='', help='id or id=size or id=size:form, by comma')
    parser.add_argument('--on-datasheet', action='store_true')
    parser.add_argument('--rate', type=float, default=100.0)
    parser.add_argument('--temperature', default='auto')
    parser.add_argument('--gentle', action='store_true')
    parser.add_argument('--rig-seed', type=int)
    parser.add_argument('--out', required=True)
    a = parser.parse_args()
    effects = {}
    for item in filter(None, a.effects.split(',')):
        name, _, rest = item.partition('=')
        size, _, form = rest.partition(':')
        effects[name] = {'size': float(size or 1.0), 'form': form or None}
    campaign = make_campaign(a.seed, effects, a.on_datasheet, a.rate, temperature=a.temperature,
                             gentle=a.gentle, rig_seed=a.rig_seed)
    print(write_campaign(campaign, a.out))


if __name__ == '__main__':
    main()
