# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A fleet runs to its end: each campaign once, whatever dies on the way."""
from contextlib import contextmanager
from functools import partial
import json
import os
import signal
import subprocess
import sys

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import find_campaigns
from hst_drive.fleet.run import run_fleet
from hst_drive.fleet.store import Store
import pytest

from . import stubs
from ..nodes.processes import alive, PATIENCE, wait_for


def marks(campaigns):
    """Return how often each campaign was worked on."""
    return [len(list((stubs.Path(entry.logs[0]).parent).glob('.mark*'))) for entry in campaigns]


def test_each_once_and_none_again(tmp_path):
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 4, 10))
    store, told = Store(tmp_path / 'results'), []
    rows = run_fleet(campaigns[:15], store, stubs.quick, workers=2, progress=told.append)
    assert [row['campaign'] for row in rows] == [entry.name for entry in campaigns[:15]]
    assert [entry.done for entry in told] == list(range(16))
    rows = run_fleet(campaigns, store, stubs.quick, workers=2)
    assert {row['status'] for row in rows} == {'done'}
    assert marks(campaigns) == [1] * 40
    # A file that was cut short is no result.
    path = store.path(rows[3]['key'])
    path.write_text(path.read_text()[:-20])
    run_fleet(campaigns, store, stubs.quick, workers=2)
    assert marks(campaigns) == [1, 1, 1, 2] + [1] * 36
    assert not list(store.folder.glob('.*'))


def test_what_changed_is_done_again(tmp_path):
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 2, 3))
    store = Store(tmp_path / 'results')
    run_fleet(campaigns, store, stubs.quick, workers=1)
    stubs.Path(campaigns[0].logs[0]).write_text('other')
    (tmp_path / 'fleet' / 'rig_01' / 'rig.yaml').write_text('name: other')
    campaigns = find_campaigns(tmp_path / 'fleet')
    run_fleet(campaigns, store, stubs.quick, workers=1)
    assert marks(campaigns) == [2, 1, 1, 2, 2, 2]
    # Elsewhere, the same files are the same campaign.
    (tmp_path / 'fleet').rename(tmp_path / 'moved')
    moved = find_campaigns(tmp_path / 'moved')
    assert run_fleet(moved, store, stubs.faulty, workers=1)[0]['campaign'] == moved[0].name
    assert marks(moved) == [2, 1, 1, 2, 2, 2]


def test_failures_are_rows(tmp_path):
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 2, 4))
    store = Store(tmp_path / 'results')
    rows = run_fleet(campaigns, store, stubs.faulty, workers=2)
    reasons = {row['campaign'][-2:]: row['reason'] for row in rows}
    assert reasons == {'01': None, '02': 'no data', '03': 'ValueError: a slip', '04': None}
    rows = run_fleet(campaigns, store, stubs.quick, workers=2)
    assert [row['status'] for row in rows].count('failed') == 4
    rows = run_fleet(campaigns, store, stubs.quick, workers=2, again=True)
    assert {row['status'] for row in rows} == {'done'}


def test_a_killed_worker_takes_nothing_with_it(tmp_path):
    """One campaign kills whoever works on it, another only the first time."""
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 3, 8))
    rows = run_fleet(campaigns, Store(tmp_path / 'results'), stubs.deadly, workers=2)
    bad = [row for row in rows if row['status'] != 'done']
    assert [row['campaign'] for row in bad] == ['rig_01/2026-01-03']
    assert 'its process died' in bad[0]['reason']


CODE = ('import signal\n'
        'import sys\n'
        'from pathlib import Path\n'
        'from hst_drive.fleet.campaigns import find_campaigns\n'
        'from hst_drive.fleet.run import run_fleet\n'
        'from hst_drive.fleet.store import Store\n'
        'from test.fleet import stubs\n'
        'if __name__ == "__main__":\n'
        # Who starts tests in the background lets them inherit that it is ignored.
        '    signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        '    run_fleet(find_campaigns(sys.argv[1]), Store(Path(sys.argv[2])),\n'
        '              getattr(stubs, sys.argv[3]), workers=2,\n'
        '              progress=lambda told: print(told.done, flush=True))\n')


@contextmanager
def running(tmp_path, root, results, stub):
    """Run a fleet as a program of its own."""
    script = tmp_path / 'script.py'
    script.write_text(CODE)
    place = stubs.Path(__file__).parents[2]
    with subprocess.Popen(
            [sys.executable, str(script), str(root), str(results), stub], cwd=place, text=True,
            stdout=subprocess.PIPE, start_new_session=True,
            env={**os.environ, 'PYTHONPATH': str(place)}) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGKILL])
def test_no_worker_is_left_behind(tmp_path, number):
    """Only the program itself gets the signal, in the midst of work that takes long."""
    root = stubs.make(tmp_path / 'fleet', 2, 2)
    with running(tmp_path, root, tmp_path / 'results', 'endless') as process:
        wait_for(lambda: len(list(root.rglob('.mark*'))) == 2)
        workers = [int(path.name.rpartition('_')[2]) for path in root.rglob('.mark*')]
        assert all(alive(worker) for worker in workers)
        os.kill(process.pid, number)
        wait_for(lambda: not any(alive(worker) for worker in workers))
        process.wait(timeout=PATIENCE)


def test_an_interrupted_fleet_goes_on(tmp_path):
    """SIGKILL for the whole program: what was written stays, nothing is half written."""
    root, results = stubs.make(tmp_path / 'fleet', 5, 40), tmp_path / 'results'
    with running(tmp_path, root, results, 'quick') as process:
        for line in process.stdout:
            if int(line) >= 20:
                break
        os.killpg(process.pid, signal.SIGKILL)
    there = list(results.glob('*.json'))
    assert 20 <= len(there) < 200
    assert all(json.loads(path.read_text())['status'] == 'done' for path in there)
    campaigns = find_campaigns(root)
    rows = run_fleet(campaigns, Store(results), stubs.quick, workers=2)
    assert {row['status'] for row in rows} == {'done'}
    # Only what was under way when it died was done twice.
    assert sum(marks(campaigns)) <= 200 + 8


def test_dask_does_the_same(tmp_path):
    distributed = pytest.importorskip('distributed')
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 3, 5))
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None,
                                  host='127.0.0.1') as cluster:
        rows = run_fleet(campaigns, Store(tmp_path / 'results'), stubs.faulty,
                         scheduler=cluster.scheduler_address)
    assert [row['status'] for row in rows].count('failed') == 6
    assert {row['reason'] for row in rows} == {None, 'no data', 'ValueError: a slip'}


def test_a_scheduler_that_is_not_there(tmp_path):
    campaigns = find_campaigns(stubs.make(tmp_path / 'fleet', 1, 1))
    with pytest.raises(InputError, match='--scheduler'):
        run_fleet(campaigns, Store(tmp_path / 'results'), partial(stubs.quick),
                  scheduler='tcp://127.0.0.1:9')
