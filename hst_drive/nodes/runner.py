# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Carrying out a plan: the nodes from start to end, and the figures of the run."""
from __future__ import annotations

from collections.abc import Callable
import shutil
import signal
import time

from hst_drive import bag
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hst_drive.nodes.plan import Plan
from hst_drive.nodes.session import NodeDied, Session
import numpy as np


class RunFailed(RuntimeError):
    """A node has died; the text says which, why, and what is left."""


def execute(plan: Plan, on_progress: Callable[[float, float, bool], None],
            on_error: Callable[[str, str], None]) -> dict:
    """
    Run the nodes until the end, Ctrl-C or a failure; return the figures of the run.

    Parameters
    ----------
    plan : Plan
        What to run.
    on_progress : callable
        ``on_progress(simulated s, real s, last call)``, several times a second.
    on_error : callable
        ``on_error(node, line)`` for what the nodes say on standard error.

    Raises
    ------
    InputError
        If a node refuses its parameters, or bags cannot be written here.
    RunFailed
        If a node dies; the bag is closed.

    """
    bag.find_storage()   # says what to install where bags cannot be written
    signals: list[int] = []
    progress = {'time': 0.0, 'wall': 0.0, 'messages': 0, 'end': False}
    before = {number: signal.signal(number, lambda got, _: signals.append(got))
              for number in (signal.SIGINT, signal.SIGTERM)}
    died = None
    try:
        with Session(plan.parameters, lambda name, line: _hear(progress, name, line),
                     on_error) as session:
            try:
                while not signals and not session.check():
                    on_progress(progress['time'], progress['wall'], False)
                    time.sleep(0.05)
                on_progress(progress['time'], progress['wall'], True)
                if not (signals or progress['end']):
                    raise NodeDied('plant', 0, session.nodes['plant'].heard())
            except NodeDied as problem:
                died = problem
            session.stop()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if died:
        _fail(plan, died, progress)
    return _figures(plan, progress, bool(signals))


def _hear(progress: dict, name: str, line: str) -> None:
    word, *numbers = line.split() or ['']
    if name == 'plant' and word == 'progress':
        progress['time'], progress['wall'] = map(float, numbers[:2])
        progress['end'] = numbers[2:] == ['end']
    elif name == 'recorder' and word == 'recorded':
        progress['messages'] = int(numbers[0])


def _fail(plan: Plan, died: NodeDied, progress: dict) -> None:
    folder, kept = plan.output, ''
    if folder.is_dir() and not (folder / 'metadata.yaml').is_file():
        kept = ('; the bag was cut off, save what it holds with: '
                f'{bag.recover_command(folder)}')
    elif folder.is_dir() and not progress['messages']:
        shutil.rmtree(folder)   # made by this very run, and nothing in it
    elif folder.is_dir():
        kept = (f"; {folder} holds the first {progress['time']:.1f} s, "
                f"{progress['messages']} messages")
    if died.code == 2 and died.lines:
        raise InputError(died.lines[-1])
    why = f': {died.reason}' if died.reason else ''
    raise RunFailed(f'{died}{why}{kept}')


def _figures(plan: Plan, progress: dict, interrupted: bool) -> dict:
    result = {'schema': 'hst_drive/run/1', 'bag': str(plan.output), 'interrupted': interrupted,
              'seconds': progress['time'], 'messages': progress['messages'],
              'real_time_factor': progress['time'] / progress['wall'] if progress['wall'] else 0.0,
              'speed': None}
    if not progress['messages']:
        if plan.output.is_dir():
            shutil.rmtree(plan.output)   # made by this very run, and nothing in it
        return {**result, 'bag': None}
    if plan.closed_loop:
        try:
            result['speed'] = speed_held(bag.read_bag(
                plan.output, bag.ChannelMap(), ('motor_speed', 'speed_setpoint')))
        except InputError:
            pass   # ended so early that there are not two samples
    return result


def speed_held(record: Run) -> dict | None:
    """
    Return how well the speed was held, rad/s and s.

    It counts from when the speed first came within 2 % of the set point, and after each jump of
    the set point from when it came there again.
    """
    if 'motor_speed' not in record or 'speed_setpoint' not in record:
        return None
    speed, wanted = record['motor_speed'], record['speed_setpoint']
    near = np.abs(speed - wanted) <= 0.02 * np.abs(wanted)
    if not near.any():
        return None
    jumps = np.flatnonzero(np.abs(np.diff(wanted)) > 0.02 * np.abs(wanted[1:])) + 1
    held = np.concatenate([np.maximum.accumulate(part) for part in np.split(near, jumps)])
    time_held, speed = (record.time - record.time[0])[held], speed[held]
    error = speed - wanted[held]
    worst = int(np.nanargmax(np.abs(error)))
    return {'unit': 'rad/s', 'from': float(time_held[0]), 'mean': float(np.nanmean(speed)),
            'mean_error': float(np.nanmean(error)),
            'rms_error': float(np.sqrt(np.nanmean(error**2))),
            'worst_error': float(error[worst]), 'worst_at': float(time_held[worst])}
