# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Timers of the steady clock that go on when the clock on the wall is set back."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import threading
import time

from rclpy.clock import Clock
from rclpy.node import Node

_BEAT = 0.05        # s; by so much a timer can be late after such a step
_NEVER = 3600.0     # s, of a timer that is there to be put off


@contextmanager
def steady_timers(node: Node, executor, clock: Clock) -> Iterator[None]:
    """
    See to it that the timers of a steady clock come in time.

    EventsExecutor waits for the next of them with C++'s condition variable. Built for glibc before
    2.30, as the wheels of PyPI are, that waits for a time on the wall: set back by an hour, all
    timers stand for an hour, and with them everything that notices a lost reading. A timer that
    is put off makes the executor look at all timers of the same clock anew.

    It is put off again only when that look is over. With many looks in its queue the executor
    calls each timer that is due as many times, and every call puts the next off by a period.
    """
    timer = node.create_timer(_NEVER, lambda: None, clock=clock)
    over, looking = threading.Event(), threading.Event()

    def beat() -> None:
        while not over.is_set():
            if not looking.is_set():
                looking.set()
                timer.reset()
                executor.create_task(looking.clear)
            time.sleep(_BEAT)   # by the steady clock; a wait for the event need not be

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
