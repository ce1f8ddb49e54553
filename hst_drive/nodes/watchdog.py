# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What wakes a spin loop that stands still, and ends the process if that is in vain."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import faulthandler
import os
from pathlib import Path
import sys
import threading
import time

BEAT = 0.5          # s between two looks
WOKEN = 8           # looks without a turn of the loop after which it is woken, each time
ENDED = 120         # and after which the process ends
_OURS = str(Path(__file__).resolve().parents[1])


class Watchdog:
    """
    Counts its looks since the loop has last turned.

    Looks are counted, not seconds: a machine that was suspended as a whole loses none.

    Parameters
    ----------
    wake : callable
        Makes the loop look anew; may be called from another thread.
    is_idle : callable
        Whether the loop waits, with no callback of ours at work: that may take its time.
    end : callable
        Ends the process.

    """

    def __init__(self, wake: Callable[[], None], is_idle: Callable[[], bool],
                 end: Callable[[], None]):
        self._wake, self._is_idle, self._end = wake, is_idle, end
        self._looks = 0

    def turned(self) -> None:
        """Take note that the loop turns."""
        self._looks = 0

    def look(self) -> None:
        """Wake or end a loop that waits and turns no more."""
        self._looks = self._looks + 1 if self._is_idle() else 0
        if self._looks >= ENDED:
            self._end()
        elif self._looks and self._looks % WOKEN == 0:
            self._wake()


def waits_in(function: Callable, thread: int) -> bool:
    """Return whether a thread is in this function, in no other code of this package below it."""
    frame = sys._current_frames().get(thread)
    while frame is not None and not frame.f_code.co_filename.startswith(_OURS):
        frame = frame.f_back
    return frame is not None and frame.f_code is function.__code__


@contextmanager
def watched(node, executor, loop: Callable) -> Iterator[Watchdog]:
    """
    Watch a loop of the calling thread that lets an executor work.

    Once in dozens to a thousand runs, on machines with much else to do, rclpy's EventsExecutor
    stood still: neither messages nor timers came through, and no signal. Timers that were silent
    after a pause, and with them the look at signals, are one cause (``steady_timers`` avoids it).
    Against any other a word of another thread, which goes through the same queue, may help.
    """
    thread = threading.get_ident()

    def wake() -> None:
        node.get_logger().warning('the executor stands still; it is woken')
        executor.create_task(lambda: None)

    def end() -> None:
        print(f'{node.role}: the executor stood still for {ENDED * BEAT:g} s; the node ends',
              file=sys.stderr, flush=True)
        faulthandler.dump_traceback(all_threads=True)
        os._exit(1)

    over = threading.Event()
    watchdog = Watchdog(wake, lambda: waits_in(loop, thread), end)

    def watch() -> None:
        while not over.is_set():
            time.sleep(BEAT)
            watchdog.look()

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield watchdog
    finally:
        over.set()
