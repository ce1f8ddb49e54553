# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The watch: says when a balance fails, since when, and what most likely is missing.

For each balance two cumulative sums run over the blocks (E. S. Page, Continuous inspection
schemes, Biometrika 41, 1954), of what the calibration leaves over its standard deviation, one up
and one down.
Errors of a model are alike from block to block, so evidence must not add up from errors that
the model may have: the deviation holds a quarter of the scatter between units, and only what
is beyond ``DRIFT`` deviations counts. A calibrated model that is off by less never alarms,
however long it drills. With independent Gaussian blocks a sum reaches ``THRESHOLD`` less than
once in 1e9 blocks (``exp(-2*DRIFT*THRESHOLD)``, D. Siegmund, Sequential Analysis, Springer 1985).
"""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from hst_drive.watch.calibration import Calibration, Innovation
from hst_drive.watch.naming import Likely, likely, Signatures
from hst_drive.watch.residuals import Block

DRIFT = 1.0
THRESHOLD = 12.0
_LIMIT = 6.0        # one block alone, a jolt, must not alarm
_TOP = 2.0          # of the threshold: how much evidence must pass before the alarm does
_FIRST = 15         # blocks from which a chart learns how rough its balance is, before it counts
_SCATTER = 60       # blocks over which the scatter is learnt
_CAUTION = 2.0      # on its variance, for blocks that follow each other are alike
_MEMORY = 120       # blocks that are kept from before an alarm
_NAMED_BY = 60      # blocks from which an alarm is named at most


@dataclass
class Chart:
    """The two sums of one balance, and since when (ns) each has grown."""

    up: float = 0.0
    down: float = 0.0
    since_up: int = 0
    since_down: int = 0
    failing: bool = False
    scatter: float = 0.0
    last: float | None = None
    seen: int = 0

    def rough(self, innovation: Innovation) -> Innovation:
        """
        Widen the deviation by what the blocks scatter: a load is rough, sensors are not alone.

        The scatter is that from block to block, so a lasting deviation does not hide itself.
        """
        found = Innovation(innovation.value, (
            innovation.deviation**2 + _CAUTION * self.scatter)**0.5)
        if self.last is not None:
            step = 0.5 * (innovation.value - self.last)**2
            if self.seen > _FIRST:
                step = min(step, (3.0 * found.deviation)**2)
            self.scatter += (step - self.scatter) / min(self.seen, _SCATTER)
        self.seen += 1
        self.last = innovation.value
        return found

    def add(self, score: float, stamp: int) -> None:
        """Take the score of a block that begins at ``stamp``."""
        score = min(max(score, -_LIMIT), _LIMIT)
        if self.up <= 0.0:
            self.since_up = stamp
        if self.down <= 0.0:
            self.since_down = stamp
        self.up = min(max(0.0, self.up + score - DRIFT), _TOP * THRESHOLD)
        self.down = min(max(0.0, self.down - score - DRIFT), _TOP * THRESHOLD)
        if self.level >= 1.0:
            self.failing = True
        elif self.level == 0.0:
            self.failing = False

    @property
    def level(self) -> float:
        """Evidence over what an alarm takes."""
        return max(self.up, self.down) / THRESHOLD

    @property
    def since(self) -> int:
        """Start of the block with which the evidence began, ns."""
        return self.since_up if self.up >= self.down else self.since_down


@dataclass
class Verdict:
    """
    What the watch says after a block.

    Attributes
    ----------
    innovations : dict of str to Innovation
        By balance.
    levels : dict of str to float
        Evidence by balance; 1 is an alarm.
    failing : tuple of str
        Balances that fail, the worst first.
    since, until : int
        The section to diagnose: from before it failed to the last block, ns.
    began : int
        When it began to fail, ns.
    effects : tuple of Likely
        Effects that could be missing, the likeliest first; the blocks do not tell them apart.
        Empty: nothing in the catalogue that shows in blocks moves the balances like this.

    """

    innovations: dict[str, Innovation]
    levels: dict[str, float]
    failing: tuple[str, ...] = ()
    began: int = 0
    since: int = 0
    until: int = 0
    effects: tuple[Likely, ...] = ()


class Watch:
    """
    Watches the balances of a drive.

    Parameters
    ----------
    calibration : Calibration
        Of the unit; learns until something fails.
    signatures : Signatures
        How effects would move the balances.

    """

    def __init__(self, calibration: Calibration, signatures: Signatures):
        self.calibration = calibration
        self._signatures = signatures
        self.charts: dict[str, Chart] = {}
        self._before: deque[tuple[Block, Calibration]] = deque(maxlen=_MEMORY)
        self._frozen: Calibration | None = None
        self._known = calibration
        self._since = 0
        self._blocks: list[Block] = []
        self._named: tuple[Likely, ...] = ()
        self._passed = self._name_at = 0
        self.blocks = 0

    def add(self, block: Block) -> Verdict:
        """Take a block of valid balances; return the verdict."""
        self.blocks += 1
        innovations = {}
        snapshot = None if self._frozen else self.calibration.copy()
        for name, residual in block.residuals.items():
            chart = self.charts.setdefault(name, Chart())
            found = (self._frozen.innovation(residual) if self._frozen
                     else self.calibration.learn(residual, chart.scatter))
            innovations[name] = chart.rough(found)
            if chart.seen > _FIRST:
                chart.add(innovations[name].score, block.start)
        if snapshot:
            self._before.append((block, snapshot))
        failing = sorted((name for name, chart in self.charts.items() if chart.failing),
                         key=lambda name: -self.charts[name].level)
        verdict = Verdict(innovations, {name: chart.level for name, chart in self.charts.items()})
        if not failing:
            self._frozen = None
            return verdict
        if self._frozen:
            self._passed += 1
            self._blocks.append(block)
        else:
            self._freeze(min(self.charts[name].since for name in failing))
        # The longer it lasts the less each block adds: fewer are kept, and it is named seldomer.
        while len(self._blocks) > _NAMED_BY:
            del self._blocks[1::2]
        if self._passed >= self._name_at:
            self._name_at = self._passed + 1 + self._passed // 20
            self._named = likely(self._signatures, self._blocks, self._known, {
                name: _CAUTION * chart.scatter for name, chart in self.charts.items()})
        verdict.failing = tuple(failing)
        verdict.began, verdict.until = self._since, block.end
        verdict.since = min(self._since, self._before[0][0].start) if self._before else self._since
        verdict.effects = self._named
        return verdict

    def _freeze(self, since: int) -> None:
        """Go back to the calibration from before the failure."""
        self._since = since
        kept = [(block, known) for block, known in self._before if block.start >= since]
        self._frozen = kept[0][1] if kept else self.calibration.copy()
        self.calibration = self._frozen.copy()
        self._passed = self._name_at = 0
        self._blocks, self._known = [block for block, _ in kept], self._frozen
        if self._frozen.beyond:
            # It was there from the start: what was learnt has taken it in.
            self._blocks, self._known = [block for block, _ in self._before], self._frozen.fresh()
        for _ in kept:
            self._before.pop()
