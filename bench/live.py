# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How fast the nodes run, and what each costs: whole runs, real processes, real DDS."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from statistics import median
import tempfile
import time
from typing import NamedTuple

from hst_drive.nodes import wiring
from hst_drive.nodes.plan import make_plan, Options
from hst_drive.nodes.session import Session

_BEGIN = 2.0    # s; by then the nodes have settled


class Found(NamedTuple):
    """
    Of one run.

    Attributes
    ----------
    seconds, wall : float
        Simulated and wall time between the first and the last look at the processes.
    cpu : dict of str to float
        CPU seconds of each node in between, all its threads.
    late : tuple of float
        How late the plant took its samples, s: median, 99th percentile, most; in real time.

    """

    seconds: float
    wall: float
    cpu: dict[str, float]
    late: tuple[float, ...]

    @property
    def factor(self) -> float:
        """How many times real time."""
        return self.seconds / self.wall

    def per_second(self, node: str) -> float:
        """CPU seconds of a node per simulated second."""
        return self.cpu[node] / self.seconds


def _used(pids: Mapping[str, int]) -> dict[str, float]:
    """Return the CPU seconds of each process until now, by the scheduler's own clock."""
    used = {}
    for name, pid in pids.items():
        tasks = Path(f'/proc/{pid}/task').glob('*/schedstat')
        used[name] = sum(int(task.read_text().split()[0]) for task in tasks) / 1e9
    return used


def run(seconds: float, *, realtime: bool = False, rate: float = 100.0, first: bool = False,
        scenario: str = 'paper_step') -> Found:
    """Run all nodes, as ``hst-drive run`` does; ``first``: with ``--priority``."""
    looks: list[tuple[float, float, dict[str, float]]] = []
    late: list[float] = []

    def hear(node: str, line: str) -> None:
        words = line.split()
        if words[0] == 'late':
            late.extend(map(float, words[1:]))
        if node == 'plant' and words[0] == 'progress' and words[-1] != 'end' and (
                len(session.nodes) == len(wiring.NODES)):
            pids = {name: entry.process.pid for name, entry in session.nodes.items()}
            try:
                looks.append((float(words[1]), time.monotonic(), _used(pids)))
            except (FileNotFoundError, ProcessLookupError):
                pass    # a thread, or the run, has just ended

    with tempfile.TemporaryDirectory() as folder:
        plan = make_plan(Options(scenario, f'{folder}/bag', realtime, None,
                                 duration=seconds, rate=rate, priority=10 * first))
        with Session(plan.parameters, hear) as session:
            while not session.check():
                time.sleep(0.05)
    settled = [look for look in looks if look[0] >= _BEGIN]
    first, last = settled[0], settled[-1]
    return Found(last[0] - first[0], last[1] - first[1],
                 {name: last[2][name] - first[2][name] for name in last[2]}, tuple(late))


def middle(runs: list[Found], node: str) -> float:
    """Return the median CPU seconds of a node per simulated second."""
    return median(entry.per_second(node) for entry in runs)


def cpu_text(runs: list[Found], scale: float, unit: str) -> str:
    """Return the median CPU time of each node as text."""
    return ', '.join(f'{name} {scale * middle(runs, name):.1f}' for name in runs[0].cpu) + (
        f' {unit}')
