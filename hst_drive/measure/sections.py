# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Comparing a log that is too long for the memory: section by section, sums instead of samples.

Each section is replayed with some seconds before and after it, that the drive has settled and the
smoothing of the load does not end where the section does. Noise and floor are estimated for each
and pooled as those of several logs are. Regions of the error are found in a part of the samples.
"""
from __future__ import annotations

from collections import Counter
from typing import Iterable, NamedTuple

from hst_drive.channels import CHANNELS, COMMANDS
from hst_drive.errors import InputError
from hst_drive.measure.compare import compare_log, Comparison, LogComparison, Sections
from hst_drive.measure.errors import Moments
from hst_drive.measure.judged import Judged, Span
from hst_drive.measure.run import Run
from hst_drive.measure.useful import missing_rows, refuse_starved
from hst_drive.measure.where import operating_variables, where
from hst_drive.model import Drive
from hst_drive.model.part import PartModel
import numpy as np

SECONDS, BEFORE, AFTER = 600.0, 30.0, 10.0
_KEPT = 4000            # samples of a section
_MOST = 200_000         # samples of a log: beyond it every second one goes


class _Part(NamedTuple):
    """Some samples of the log: time, recorded channels, model, variables, and what counts."""

    time: np.ndarray
    channels: dict[str, np.ndarray]
    model: dict[str, np.ndarray]
    variables: dict[str, np.ndarray]
    judged: np.ndarray

    def thin(self, rows: np.ndarray | slice) -> _Part:
        """Return some of the samples."""
        return _Part(self.time[rows], *({name: values[rows] for name, values in entry.items()}
                                        for entry in self[1:4]), self.judged[rows])


def compare_sections(drive: Drive | PartModel, name: str, source: str,
                     sections: Iterable[tuple[Run, float, float]], seconds: float = SECONDS, *,
                     all_seconds: bool = False, progress=lambda done: None) -> Comparison:
    """
    Compare one long log with a model; sections without a command of the drive are left out.

    Parameters
    ----------
    drive : Drive or PartModel
        The model.
    name, source : str
        Of the log.
    sections : iterable of (Run, start, end)
        Recordings in the log's own time, of which ``start <= time < end`` (s) is judged.
    seconds : float
        The length that the sections have, s.
    all_seconds : bool
        As for ``compare``.
    progress : callable
        Told the time (s) up to which the log is done.

    """
    sums: dict[str, Moments] = {}
    parts: list[_Part] = []
    delays: dict[str, list[float]] = {}
    spans: list[Span] = []
    kept: Counter[str] = Counter()      # of the samples
    whole = isinstance(drive, Drive)
    there = Counter(dict.fromkeys(COMMANDS if whole else (), 0))    # rows of each command
    shifts, notes = [], []
    count = samples = 0
    stride = 1
    sample_time = seconds
    for run, start, end in sections:
        own = (run.time >= start) & (run.time < end)
        rows, last = int(own.sum()), min(end, float(run.time[-1]))
        samples += rows
        there.update({entry: rows - lost for entry, lost in missing_rows(run, own).items()})
        if off := [entry for entry in COMMANDS if whole and entry not in run]:
            _join(spans, [Span(start, last, f'{off[0]} missing')], start, last)
            continue
        log = compare_log(drive, run, all_seconds=all_seconds)
        for signal, entry in log.signals.items():
            sums.setdefault(signal, Moments()).add(
                log.model[signal][own], log.measured(signal)[own], entry.noise_std, entry.floor)
            delays.setdefault(signal, []).append(log.delays[signal])
        for why, share in log.judged.kept.items():
            kept[why] += share * rows
        _join(spans, log.judged.left_out, start, last)
        shifts.append(log.shift)
        notes += [note for note in run.notes if note not in notes]
        sample_time = run.sample_time if not count else sample_time
        every = max(rows // _KEPT, 1) * stride
        parts.append(_Part(run.time, log.run.channels, log.model, operating_variables(log.run),
                           log.judged.samples).thin(np.flatnonzero(own)[::every]))
        if sum(len(part.time) for part in parts) > _MOST:
            stride *= 2
            parts = [part.thin(slice(None, None, 2)) for part in parts]
        count += 1
        progress(last)
    refuse_starved(source, {entry: samples - rows for entry, rows in there.items()}, samples)
    if not count:
        raise InputError(f'{source}: holds no section with enough rows to compare')
    return _result(drive, name, source, sums, parts, Sections(
        count, seconds, BEFORE, AFTER, samples, sample_time), {
            signal: float(np.median(values)) for signal, values in delays.items()},
        float(np.median(shifts)), Judged(
            np.zeros(0, dtype=bool), tuple(spans),
            {why: part / samples for why, part in kept.items()}), notes)


def _result(drive, name, source, sums, parts, cut, delays, shift, judged, notes) -> Comparison:
    """Put together what ``compare`` would return, with a part of the samples."""
    signals = {signal: entry.summary(CHANNELS[signal].unit) for signal, entry in sums.items()
               if entry.count}
    run = Run(name, np.concatenate([part.time for part in parts]),
              _joined([part.channels for part in parts], parts), source, tuple(notes))
    model = {key: values for key, values in _joined([part.model for part in parts], parts).items()
             if key in signals}
    judged = judged._replace(samples=np.concatenate([part.judged for part in parts]))
    log = LogComparison(run, model, signals, {key: delays[key] for key in signals}, shift, judged,
                        cut)
    variables = _joined([part.variables for part in parts], parts)
    finite = {key: [values] for key, values in variables.items() if np.isfinite(values).all()}
    regions = where({key: [model[key] - log.measured(key)] for key in signals}, finite,
                    {key: entry.floor for key, entry in signals.items()})
    return Comparison(drive.rig.name, False, signals, regions, [log])


def _joined(entries: list[dict[str, np.ndarray]], parts: list[_Part]) -> dict[str, np.ndarray]:
    """Join what the parts hold; NaN where a part lacks a channel."""
    names = list(dict.fromkeys(name for entry in entries for name in entry))
    return {name: np.concatenate([entry.get(name, np.full(len(part.time), np.nan))
                                  for entry, part in zip(entries, parts)]) for name in names}


def _join(spans: list[Span], more: Iterable[Span], start: float, end: float) -> None:
    """Add a section's own spans to those of the log."""
    for span in more:
        first, last = max(span.start, start), min(span.end, end)
        if first < last:
            if spans and first <= spans[-1].end and spans[-1].why == span.why:
                first = spans.pop().start
            spans.append(Span(first, last, span.why))
