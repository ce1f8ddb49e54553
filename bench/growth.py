# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often remaining time lies in its interval: histories of sizes drawn by chance, no logs.

    python -m bench.growth --count 400

Wear that is linear, sets in some day, accelerates, or begins anew after a repair; 5 to 18 dates;
standard errors of 1 to 6 % of the limit, in half of the cases with as much scatter again that
nobody told; in half of them a leak in oil that is warm in summer. And steady sizes: how often are
they told as growing?
"""
from __future__ import annotations

import argparse
import time

from hst_drive.fleet.growth import Growth, History
import numpy as np

LAWS = ('linear', 'onset', 'accelerating', 'repaired')
_FAR = 8.0      # histories: later than that no limit is reached


def life(seed: int) -> tuple[str, History, float]:
    """Return a law, a history of it, and the day on which it reaches 1."""
    random = np.random.default_rng(seed)
    count = int(random.integers(5, 19))
    days = np.sort(np.arange(count) * random.choice([30.0, 61.0]) + random.uniform(-5, 5, count))
    kind = LAWS[seed % len(LAWS)]
    end, size, begin = days[-1], random.uniform(0.3, 0.9), random.uniform(0.2, 0.7) * days[-1]
    rate = random.uniform(1.0, 4.0)

    def law(day):
        if kind == 'linear':
            return size * day / end
        if kind == 'accelerating':
            return size * np.expm1(rate * day / end) / np.expm1(rate)
        late = size * np.maximum(day - begin, 0.0) / (end - begin)
        return late if kind == 'onset' else np.where(
            day < begin, 1.3 * size * day / (end - begin), late)

    sigma = random.uniform(0.01, 0.06)
    noise = np.hypot(sigma, random.choice([0.0, 1.0]) * sigma) * random.standard_normal(count)
    after = np.linspace(end, _FAR * end, 100_001)
    # What the oil does, one standard deviation: the power of its viscosity is any from 0 to 1.
    oil = random.choice([0.0, 0.1]) * (0.3 + law(days)) * np.sin(
        2.0 * np.pi * (days / 365.25 + random.uniform()))
    return kind, History(days, law(days) + noise + random.uniform(-1.0, 1.0) * 3.0**0.5 * oil,
                         np.full(count, sigma), thinner=oil), float(
        after[np.argmax(law(after) >= 1.0)])


def main() -> None:
    """Draw lives and print how many intervals hold the truth."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--count', type=int, default=400)
    parser.add_argument('--seed', type=int, default=1_000, help='the first of them')
    args = parser.parse_args()
    count = args.count
    began = time.process_time()
    rows = []
    for seed in range(count):
        kind, made, true = life(args.seed + seed)
        found = Growth(made)
        left = found.remaining(1.0)
        rows.append((kind, left.low <= true <= left.high, np.isinf(left.high),
                     (left.high - left.low) / (true - found.now), found.kind, len(found.jumps)))
    print('| law | lives | inside | no upper end | width over the truth, median | told as growing '
          '| a jump told |\n|---|---|---|---|---|---|---|')
    for law in (*LAWS, 'all'):
        own = [row for row in rows if law in (row[0], 'all')]
        print(f'| {law} | {len(own)} | {np.mean([row[1] for row in own]):.1%} | '
              f'{np.mean([row[2] for row in own]):.0%} | {np.median([row[3] for row in own]):.2g} '
              f'| {np.mean([row[4] in ("grows", "accelerates") for row in own]):.0%} '
              f'| {np.mean([row[5] > 0 for row in own]):.0%} |')
    random = np.random.default_rng(args.seed)
    wrong = jumped = 0
    for _ in range(count // 2):
        dates, sigma = int(random.integers(4, 19)), random.uniform(0.01, 0.06)
        found = Growth(History(61.0 * np.arange(dates), random.choice([0.0, 0.5]) + random.choice(
            [1.0, 1.4]) * sigma * random.standard_normal(dates), np.full(dates, sigma)))
        wrong += found.kind in ('grows', 'accelerates', 'falls')
        jumped += bool(found.jumps)
    print(f'\nsteady: {wrong} of {count // 2} told as growing or falling, {jumped} with a jump; '
          f'{(time.process_time() - began) / (1.5 * count):.2f} CPU seconds a history')


if __name__ == '__main__':
    main()
