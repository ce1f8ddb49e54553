# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Many campaigns on a dask cluster of this machine, a worker killed on the way.

    python -m bench.fleet --campaigns 1000

Each is a drive of the truth generator with one hidden effect (or none) that grows from date to
date, two logs of 20 s at 50 Hz. The last quarter of them is left for one worker alone: its pace
against that of two is the scaling. (A diagnosis alone uses more than one core, too.) Needs
``pip install distributed``.
"""
from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from tempfile import TemporaryDirectory
from test.truth import make_campaign, write_campaign
import time

from bench.speed import machine
from distributed import LocalCluster

EFFECTS = (None, 'motor_leakage', 'pump_leakage', 'viscous_drag', 'bearing_friction',
           'flow_sensor_scale')
DATES = 5


def make(folder: Path, first: int, last: int) -> None:
    """Write some campaigns: machine by machine, date by date."""
    for number in range(first, last):
        rig, date = divmod(number, DATES)
        hidden = EFFECTS[rig % len(EFFECTS)]
        made = make_campaign(50_000 + number, {hidden: 0.6 + 0.3 * date} if hidden else {},
                             duration=20.0, rate_hz=50.0, logs=('drilling', 'speed_sweep'),
                             keep_exact=False)
        write_campaign(made, folder / f'rig_{rig:04}' / f'2026-{date + 1:02}-01')


def fleet(folder: Path, workers: int, kill: bool) -> tuple[float, list[dict]]:
    """Run the verb on a cluster; return the seconds and the rows."""
    results = folder / 'results'
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        began = time.monotonic()
        process = subprocess.Popen(
            [sys.executable, '-m', 'hst_drive', 'fleet', str(folder / 'campaigns'), '--results',
             str(results), '--healthy', '0', '--scheduler', cluster.scheduler_address,
             '--json', str(folder / 'fleet.json')], stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        total = sum(1 for _ in (folder / 'campaigns').glob('*/*'))
        while process.poll() is None:
            time.sleep(0.5)
            if kill and len(list(results.glob('*.json'))) > total // 3:
                os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
                kill = False
        seconds = time.monotonic() - began
    if process.returncode or kill:
        raise RuntimeError(f'ended with {process.returncode}, {"none" if kill else "one"} killed')
    return seconds, json.loads((folder / 'fleet.json').read_text())['rows']


def main() -> None:
    """Make campaigns, diagnose them, print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--campaigns', type=int, default=1000)
    count = parser.parse_args().campaigns
    alone = count // 4
    print(machine())
    with TemporaryDirectory(prefix='fleet_') as folder:
        paces = []
        for name, first, last, workers in (('two', 0, count - alone, 2),
                                           ('one', count - alone, count, 1)):
            place = Path(folder) / name
            make(place / 'campaigns', first, last)
            seconds, rows = fleet(place, workers, kill=workers > 1)
            paces.append(len(rows) / seconds)
            failed = sum(row['status'] == 'failed' for row in rows)
            right = sum(_right(row) for row in rows)
            print(f'{len(rows)} of {last - first} campaigns, {workers} '
                  f'worker{"s, one killed on the way" if workers > 1 else ""}: {seconds:.0f} s, '
                  f'{failed} failed, {right} right', flush=True)
        print(f'{paces[0]:.2f} and {paces[1]:.2f} campaigns a second: {paces[0] / paces[1]:.2f} '
              'times one worker')


def _right(row: dict) -> bool:
    """Tell whether the first name is that of the hidden effect."""
    hidden = EFFECTS[int(row['machine'].rpartition('_')[2]) % len(EFFECTS)]
    named = [entry['id'] for entry in (row['diagnosis'] or {}).get('effects', [])]
    return named[:1] == ([hidden] if hidden else [])


if __name__ == '__main__':
    main()
