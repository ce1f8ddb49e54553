# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A long simulation on several cores: cut in time, each piece started from a guess that is checked.

A drive forgets where it started: its slowest part settles in a second. So a piece may start
``LEAD`` before its turn from what the signals show. Once the piece before has arrived, its last
state tells whether that was so; if not (play that no command crossed), the piece is run again.
"""
from __future__ import annotations

from typing import Callable, Mapping

from hst_drive.measure.threads import each
from hst_drive.model import Drive
from hst_drive.model.compose import STATES
import numpy as np

PIECES = 4              # always the same, so that the result does not hang on the machine
LEAD = 20.0             # s
_SAME = 1e-9            # of the state, or of its size in use
_SIZE = np.array([{'displacement': 1e-6, 'pilot_aim': 1e-6, 'pump_pressure': 1e5,
                   'pprv_pressure': 1e5, 'twist': 1e-3}.get(name, 1.0) for name in STATES])


def simulate_in_pieces(drive: Drive, time: np.ndarray, inputs: Mapping[str, np.ndarray],
                       state: np.ndarray, guess: Callable[[int], np.ndarray]
                       ) -> dict[str, np.ndarray]:
    """
    Return what ``drive.simulate`` returns, within a billionth, by as many threads as there are.

    Parameters
    ----------
    drive, time, inputs, state
        As for ``Drive.simulate``.
    guess : callable
        Row to the state that the signals show there.

    """
    edges = np.linspace(0, len(time) - 1, PIECES + 1).astype(int)
    # What the motion does not read, and so leaves where it was, may differ.
    idle = [] if drive.has_flexible_shaft else ['load_speed', 'twist']
    idle += ['motor_angle'] if 'motor_angle' in inputs else []
    read = np.array([name not in idle for name in STATES])

    def move(first: int, last: int, start: np.ndarray) -> tuple[dict, np.ndarray]:
        rows, end = slice(first, last + 1), start.copy()
        return drive.simulate(time[rows], {name: values[rows] for name, values in inputs.items()},
                              end), end

    def piece(number: int) -> tuple[np.ndarray, dict, np.ndarray]:
        first = edges[number]
        start = state
        if number:
            lead = int(np.searchsorted(time, time[first] - LEAD))
            start = move(lead, first, guess(lead))[1]
        return (start, *move(first, edges[number + 1], start))

    found = list(each(piece, range(PIECES)))
    whole: dict[str, np.ndarray] = {}
    at = found[0][0]
    for number, (start, signals, end) in enumerate(found):
        if not _same(start[read], at[read], _SIZE[read]):
            signals, end = move(edges[number], edges[number + 1], at)
        for name, values in signals.items():
            if name not in whole:
                whole[name] = np.empty(len(time))
            whole[name][edges[number]:edges[number + 1] + 1] = values
        at = end
    state[:] = at
    return whole


def _same(one: np.ndarray, other: np.ndarray, size: np.ndarray) -> bool:
    near = np.abs(one - other) <= _SAME * np.maximum(np.abs(other), size)
    return bool(np.all(near | np.isnan(one) & np.isnan(other)))
