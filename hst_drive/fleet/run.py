# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
All campaigns on all cores, or on a cluster; what is done is not done again.

A process that dies takes those campaigns with it that were handed out: they are started again, and
those to which that happened twice run alone, so that the one to blame is told from the others.
"""
from __future__ import annotations

from collections import deque
from concurrent.futures import (
    BrokenExecutor, Executor, FIRST_COMPLETED, ProcessPoolExecutor, wait)
from contextlib import contextmanager
import multiprocessing
import os
import threading
import time
from typing import Callable, Iterator, NamedTuple, Sequence

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import Campaign, key_of
from hst_drive.fleet.store import Store
from hst_drive.fleet.task import failed

Task = Callable[[Campaign], dict]
_DIED = 'its process died three times, the last time alone (killed, or out of memory)'
_TOGETHER = 2   # times that a campaign may be at work when a process dies before it runs alone
_AHEAD = 4      # campaigns per worker that wait in the executor


class Progress(NamedTuple):
    """How far what is: a row that came in (None: one that was there), and how many of all."""

    row: dict | None
    done: int
    total: int
    what: str = 'campaigns'


def run_fleet(campaigns: Sequence[Campaign], store: Store, task: Task, *, workers: int = 0,
              scheduler: str = '', again: bool = False, what: str = 'campaigns',
              asked: Callable[[Campaign], str] = lambda campaign: '',
              progress: Callable[[Progress], None] = lambda progress: None) -> list[dict]:
    """
    Run a task over campaigns and return their rows, in order.

    Parameters
    ----------
    campaigns : sequence of Campaign
        What is to be done.
    store : Store
        Rows that are in it are taken as they are; each new one is written at once.
    task : callable
        Campaign to row; must be found by its name in a module, since it runs in other processes.
    workers : int
        Processes on this machine; 0: as many as there are cores.
    scheduler : str
        Address of a dask scheduler; its workers are used instead.
    again : bool
        Also repeat those that failed.
    what : str
        What is counted, for people.
    asked : callable
        What of a campaign is asked, beside its files: another question has another answer.
    progress : callable
        Told of each row.

    Raises
    ------
    InputError
        If the scheduler cannot be reached.

    """
    keys = [key_of(campaign, asked(campaign)) for campaign in campaigns]
    rows: dict[str, dict] = {}
    for key in keys:
        row = store.get(key)
        if row and not (again and row['status'] == 'failed'):
            rows[key] = row
    waiting = {key: campaign for key, campaign in zip(keys, campaigns) if key not in rows}
    total = len(set(keys))
    progress(Progress(None, len(rows), total, what))
    finished = _on_cluster if scheduler else _here
    for key, row in finished(
            waiting, task, scheduler or workers or os.cpu_count() or 1) if waiting else ():
        row = rows[key] = {**row, 'key': key}
        store.put(key, row)
        progress(Progress(row, len(rows), total, what))
    # The names are those of now, also where a folder was moved since.
    return [{**rows[key], 'campaign': campaign.name, 'machine': campaign.machine,
             'date': campaign.date or None} for key, campaign in zip(keys, campaigns)]


def _here(waiting: dict[str, Campaign], task: Task, workers: int) -> Iterator[tuple[str, dict]]:
    """Yield rows as they come, from processes of this machine."""
    deaths: dict[str, int] = {}
    todo, alone = dict(waiting), {}
    while todo or alone:
        batch = todo or dict([alone.popitem()])
        with _pool(workers if todo else 1) as pool, _none_left_behind():
            for key, row in _collected(pool, dict(batch), task, lambda: workers):
                if row is not None:
                    todo.pop(key, None)
                    yield key, row
                    continue
                deaths[key] = deaths.get(key, 0) + 1
                if deaths[key] > _TOGETHER:
                    yield key, failed(waiting[key], _DIED)
                elif deaths[key] == _TOGETHER:
                    alone[key] = todo.pop(key)


def _pool(workers: int) -> ProcessPoolExecutor:
    # A fork would copy threads' locks; a fresh process starts clean on every platform.
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context('spawn'),
                               initializer=_leave_with, initargs=(os.getpid(),))


def _leave_with(parent: int) -> None:
    """End this process soon after its parent, which may have been killed."""
    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _none_left_behind() -> Iterator[None]:
    """End the processes at once where the work is given up: nobody wants what they are at."""
    try:
        yield
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise


def _collected(pool: Executor, batch: dict[str, Campaign], task: Task,
               workers: Callable[[], int]) -> Iterator[tuple[str, dict | None]]:
    """Yield rows; None for those that were handed out when a process died. Then it ends."""
    queue = deque(batch.items())
    running = {}
    broken = False
    try:
        while queue and not broken or running:
            while queue and not broken and len(running) < _AHEAD * workers():
                key, campaign = queue.popleft()
                try:
                    running[pool.submit(task, campaign)] = key
                except BrokenExecutor:
                    queue.appendleft((key, campaign))
                    broken = True
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                key = running.pop(future)
                try:
                    yield key, future.result()
                except BrokenExecutor:
                    broken = True
                    yield key, None
                except Exception as problem:
                    yield key, failed(batch[key], f'{type(problem).__name__}: {problem}')
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise


def _on_cluster(waiting: dict[str, Campaign], task: Task,
                scheduler: str) -> Iterator[tuple[str, dict]]:
    """Yield rows as they come, from the workers of a dask cluster; dask repeats what was lost."""
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise InputError("--scheduler: the Python package 'distributed' is missing; install it "
                         "here and on the workers: pip install 'hst_drive[cluster]'") from None
    try:
        client = Client(scheduler, timeout=10)
    except (OSError, ValueError, TimeoutError) as problem:
        raise InputError(f'--scheduler {scheduler}: cannot be reached ({problem}); start one with '
                         "'dask scheduler' and workers with 'dask worker ADDRESS'") from None
    with client, client.get_executor(pure=False) as pool:
        # What a dying worker has not handed over is computed again: keep little of it waiting.
        yield from _collected(pool, waiting, task,
                              lambda: max(sum(client.ncores().values()), 1))
