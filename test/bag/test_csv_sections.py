# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Sections of a CSV log: every row is in exactly one, and what is wrong is told by its row."""
from hst_drive.bag import ChannelMap, read_csv
from hst_drive.bag.csv_sections import csv_sections
from hst_drive.errors import InputError
import numpy as np
import pytest

HEAD = '# made by hand\ntime[s],pump_command[V],motor_speed[rpm]\n'


def write(path, seconds, text=''):
    """Write a log with a row each 10 ms that counts."""
    rows = [f'{k / 100:.2f},{k % 7},{k}' for k in range(round(100 * seconds))]
    path.write_text(HEAD + '\n'.join(rows) + '\n' + text, encoding='utf-8')
    return path


@pytest.mark.parametrize('seconds', [1.0, 59.0, 100.0, 260.0, 301.0, 449.0, 451.0])
def test_every_row_is_in_one_section(tmp_path, seconds):
    path = write(tmp_path / 'log.csv', seconds)
    whole = read_csv(path)
    found = list(csv_sections(path, ChannelMap(), 100.0, 5.0, 2.0))
    assert len(found) == max(round(seconds / 100.0), 1)
    own, values = [], []
    for number, (run, start, end) in enumerate(found):
        keep = (run.time >= start) & (run.time < end)
        own.append(run.time[keep])
        values.append(run['motor_speed'][keep])
        assert run.time[0] == pytest.approx(start - 5.0 if number else 0.0)
        if number + 1 < len(found):
            assert run.time[-1] == pytest.approx(end + 2.0 - 0.01)
    assert np.array_equal(np.concatenate(own), whole.time)
    assert np.array_equal(np.concatenate(values), whole['motor_speed'])


@pytest.mark.parametrize(('line', 'told'), [
    ('300.00,1\n', 'row 30003 has 2 cells'), ('300.00,1,fast\n', "row 30003, column 'motor_speed"),
    ('299.99,1,2\n', 'row 30003: the time stands still'),
    ('250,1,2\n', 'row 30003: the time runs')])
def test_a_wrong_row_is_named(tmp_path, line, told):
    path = write(tmp_path / 'log.csv', 300.0, line)
    with pytest.raises(InputError, match=told):
        list(csv_sections(path, ChannelMap(), 100.0, 5.0, 2.0))


def test_a_last_row_that_was_not_written_to_its_end_is_left_out(tmp_path):
    whole = write(tmp_path / 'whole.csv', 300.0)
    path = write(tmp_path / 'log.csv', 300.0, '300.00,1')
    for (run, *_), (other, *_) in zip(csv_sections(path, ChannelMap(), 100.0, 5.0, 2.0),
                                      csv_sections(whole, ChannelMap(), 100.0, 5.0, 2.0)):
        assert np.array_equal(run.time, other.time)
    assert 'the last row (30003) is cut off; left out' in run.notes


@pytest.mark.parametrize('content', ['', '# nothing\n', HEAD])
def test_an_empty_log_is_told(tmp_path, content):
    path = tmp_path / 'log.csv'
    path.write_text(content, encoding='utf-8')
    with pytest.raises(InputError, match='log.csv'):
        list(csv_sections(path, ChannelMap(), 100.0, 5.0, 2.0))
    with pytest.raises(InputError, match='cannot be read'):
        list(csv_sections(tmp_path / 'other.csv', ChannelMap(), 100.0, 5.0, 2.0))
