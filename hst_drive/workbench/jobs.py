# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Long work beside the server: one job at a time, with progress, that can be stopped."""
from __future__ import annotations

from threading import Lock, Thread
import time
import traceback
from typing import Callable

from hst_drive.errors import InputError


class Stopped(Exception):
    """The user stopped the job."""


class Job:
    """
    A piece of work in a thread.

    Parameters
    ----------
    what : str
        'fit' or 'diagnose'.
    work : callable
        Called with a function that takes progress as text; returns what JSON knows.

    """

    def __init__(self, what: str, work: Callable[[Callable[[str], None]], dict]):
        self.what = what
        self._lock = Lock()
        self._stop = False
        self._state: dict = {'what': what, 'state': 'running', 'progress': 'starting'}
        self._begin = time.monotonic()
        self._thread = Thread(target=self._run, args=(work,), daemon=True, name=what)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it is not done yet."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Stop at the next progress."""
        self._stop = True

    def wait(self, timeout: float) -> None:
        """Wait until it is done, at most so long (s)."""
        self._thread.join(timeout)

    def status(self) -> dict:
        """Return state, progress, seconds, and the result once there is one."""
        with self._lock:
            return {**self._state, 'seconds': round(time.monotonic() - self._begin, 1)}

    def _tell(self, progress: str) -> None:
        if self._stop:
            raise Stopped
        with self._lock:
            self._state['progress'] = progress

    def _run(self, work: Callable[[Callable[[str], None]], dict]) -> None:
        try:
            end = {'state': 'done', 'result': work(self._tell)}
        except Stopped:
            end = {'state': 'stopped', 'error': f'{self.what} was stopped'}
        except InputError as problem:
            end = {'state': 'failed', 'error': str(problem)}
        except Exception as problem:
            traceback.print_exc()
            end = {'state': 'failed', 'error': f'{type(problem).__name__}: {problem}'}
        with self._lock:
            self._state.update(end)
