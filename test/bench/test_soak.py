# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the soak makes of its looks at the processes and of the bag."""
from argparse import Namespace

from bench.respawn import judge
from bench.soak import judge_data, judge_drive, judge_memory, Memory, memory_of
from hst_drive.bag import BagWriter, write_run
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import TOPICS
from hst_drive.measure.run import Run
import numpy as np
import pytest

LIMITS = Namespace(jitter=10.0, late=0.1, rate=100.0)
PERIOD = 10_000_000     # ns
START = 1_000_000_000


def looks(growth, step=0.0):
    """Return looks at a process that fills up for 5 min, then grows (MB/h), with a step."""
    at = np.arange(0.0, 1200.0, 5.0)
    size = 80.0 + 20.0 * np.minimum(at / 300.0, 1.0) + growth * at / 3600.0 + step * (at > 700.0)
    return np.stack([at, size, 0.07 * at], axis=1)


def write(folder, late=(), missing=()):
    """Write a bag of 600 steps; ``late``: ns by which a message is recorded after its stamp."""
    with BagWriter(folder) as bag:
        for name in ('motor', 'pump_command'):
            bag.add_topic(f'/drive/{name}', TOPICS[name].type)
        for step in range(600):
            for name in ('motor', 'pump_command'):
                if step not in missing:
                    stamp = START + step * PERIOD
                    bag.write(f'/drive/{name}', bytes(8), stamp + dict(late).get(step, 0), stamp)
    return folder


@pytest.mark.parametrize('step', [0.0, 3.0])
def test_the_slope_is_that_of_the_time_after_the_filling(step):
    found = memory_of(looks(7.0, step))
    assert found.slope == pytest.approx(7.0, abs=0.1 + 1.5 * step)
    assert found.cpu == pytest.approx(7.0) and found.start == 80.0


def test_growth_is_told_and_filling_is_not(capsys):
    said = judge_memory({'a': Memory(80.0, 90.0, 11.9, 5.0), 'b': Memory(80.0, 90.0, 1.0, 5.0),
                         'c': Memory(80.0, 81.0, 11.9, 5.0)}, 5.0)
    assert said == ['a grows by 11.9 MB/h']
    assert '+11.90' in capsys.readouterr().out
    assert judge_memory({}, 5.0) != []


def test_steps_are_counted_at_the_rate_that_was_asked_for(tmp_path):
    folder = write(tmp_path / 'b')
    assert judge_data(folder, 6.0, False, Namespace(rate=100.0)) == []
    assert len(judge_data(folder, 6.0, False, Namespace(rate=200.0))) == 2


@pytest.mark.parametrize('late, missing, words', [
    ((), (), []), (((300, 10**8),), (), ['come later']), ((), (300,), ['steps are missing']),
    ([(step, 2_000_000) for step in range(540, 600)], (), ['clock and data part by 2.00 ms'])])
def test_late_missing_and_drifting_messages_are_told(tmp_path, late, missing, words):
    said = judge_data(write(tmp_path / 'b', late, missing), 6.0, True, LIMITS)
    assert len(said) == 2 * len(words)
    assert all(word in line for word in words for line in said)


def test_a_drive_that_was_stopped_is_told(tmp_path):
    command = np.full(1000, 5.0)
    write_run(tmp_path / 'a', Run('a', np.arange(1000) * 0.01, {'pump_command': command}))
    assert judge_drive(tmp_path / 'a') == []
    command[400:] = 0.0
    write_run(tmp_path / 'b', Run('b', np.arange(1000) * 0.01, {'pump_command': command}))
    assert '6 s, first at 4 s' in judge_drive(tmp_path / 'b')[0]


@pytest.mark.parametrize('change, kills, words', [
    ({}, 1, []), ({}, 2, ['1 gaps, the controller was killed 2 times']),
    ({'lost': 450}, 1, ['1 readings are missing']), ({'first': 3.0}, 1, ['3 V right after']),
    ({'after': 0.0}, 1, ['was not started again']), ({'back': 1900}, 1, ['a gap of 17.0 s'])])
def test_after_a_kill_only_the_commands_until_the_return_may_be_lost(
        tmp_path, change, kills, words):
    """Killed at 2 s, back 4 s later, started a second after that."""
    change = {'lost': None, 'first': 0.0, 'after': 5.0, 'back': 600, **change}
    back = change['back']
    with BagWriter(tmp_path / 'bag') as bag:
        codecs = {}
        for name in ('motor', 'pump_command'):
            kind = TOPICS[name].type
            bag.add_topic(f'/drive/{name}', kind)
            codecs[name] = Codec(kind, find_definition(kind))
        for step in range(2400):
            stamp = START + step * PERIOD
            if step != change['lost']:
                bag.write('/drive/motor', codecs['motor'].encode({
                    'name': ['motor'], 'velocity': [10.0]}), stamp, stamp)
            if not 200 <= step < back:
                value = (5.0 if step < 200 else change['first'] if step == back
                         else 0.0 if step < back + 100 else change['after'])
                bag.write('/drive/pump_command', codecs['pump_command'].encode({
                    'vector': {'x': value}}), stamp, stamp)
    said = judge(tmp_path / 'bag', kills)
    assert len(said) == len(words) and all(word in line for word, line in zip(words, said)), said
