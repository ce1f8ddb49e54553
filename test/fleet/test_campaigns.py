# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is a campaign, whose it is, and when it was."""
from datetime import datetime

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import find_campaigns, history_dates
import pytest


def put(path, text='time[s]\n'):
    """Write a file and the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding='utf-8')


@pytest.fixture
def fleet(tmp_path):
    """Return a folder with campaigns of several forms."""
    root = tmp_path / 'fleet'
    put(root / 'rig_a' / '2026-03-14' / 'drilling.csv')
    put(root / 'rig_a' / '2026-03-14' / 'drilling_holdout.csv')
    put(root / 'rig_a' / '2026-03-14' / 'notes.txt')
    put(root / 'rig_a' / 'rig.yaml')
    put(root / 'channels.yaml')
    put(root / 'rig_b' / 'hole_7' / 'log_20260401_0830.mcap')
    put(root / 'rig_b' / 'hole_7' / 'channels.yaml')
    put(root / 'rig_c_20260105' / 'bag' / 'metadata.yaml', 'rosbag2_bagfile_information:\n'
        '  starting_time: {nanoseconds_since_epoch: 1767225600000000000}\n')
    put(root / 'rig_c_20260105' / 'bag' / 'bag_0.mcap')
    put(root / 'rig_d' / 'bag' / 'metadata.yaml', 'rosbag2_bagfile_information:\n'
        '  starting_time: {nanoseconds_since_epoch: 1767225600000000000}\n')
    put(root / '.hidden' / 'log.csv')
    return root


def test_what_is_found(fleet):
    found = {entry.name: entry for entry in find_campaigns(fleet)}
    assert {name: (entry.machine, entry.date, len(entry.logs), len(entry.holdout))
            for name, entry in found.items()} == {
        'rig_a/2026-03-14': ('rig_a', '2026-03-14', 1, 1),
        'rig_b/hole_7': ('rig_b', '2026-04-01', 1, 0),
        'rig_c_20260105': ('rig_c', '2026-01-05', 1, 0),
        'rig_d': ('rig_d', '2026-01-01', 1, 0)}
    assert found['rig_a/2026-03-14'].rig == str(fleet / 'rig_a' / 'rig.yaml')
    assert found['rig_b/hole_7'].rig == ''
    assert found['rig_a/2026-03-14'].channels == str(fleet / 'channels.yaml')
    assert found['rig_b/hole_7'].channels == str(fleet / 'rig_b' / 'hole_7' / 'channels.yaml')


def test_a_list(fleet, tmp_path):
    names = tmp_path / 'list.txt'
    names.write_text('# ours\nfleet/rig_a   # the old one\n\nfleet/rig_d\n')
    assert [entry.name for entry in find_campaigns(names)] == [
        'fleet/rig_a/2026-03-14', 'fleet/rig_d']
    names.write_text('fleet/rig_z\n')
    with pytest.raises(InputError, match='rig_z, which is no folder'):
        find_campaigns(names)
    log = next(fleet.rglob('*.csv'))
    with pytest.raises(InputError, match='is a log; give the folder'):
        find_campaigns(log)


def test_a_list_of_folders_elsewhere(fleet, tmp_path):
    """Two machines of one name stay two, and what lies above their logs counts."""
    put(tmp_path / 'other' / 'rig_a' / '2026-03-14' / 'drilling.csv')
    names = tmp_path / 'lists' / 'list.txt'
    put(names, '../fleet/rig_a\n../other/rig_a\n')
    found = find_campaigns(names)
    assert [entry.machine for entry in found] == ['fleet/rig_a', 'other/rig_a']
    assert [bool(entry.rig) for entry in found] == [True, False]


def test_the_folder_of_one_machine(fleet):
    found, = find_campaigns(fleet / 'rig_a')
    assert (found.machine, found.date) == ('rig_a', '2026-03-14')


def test_a_serial_number_that_reads_like_a_day(tmp_path):
    put(tmp_path / 'rig_20240115' / 'run' / 'drilling_2026-03-14.csv')
    found, = find_campaigns(tmp_path)
    assert found.date == '2026-03-14'


def test_the_dates_of_a_history(fleet):
    """From the folder, the log's name or nowhere; a diagnosis that tells no logs is no reason."""
    for path, told in (('rig_a/2026-03-14/drilling.csv', '2026-03-14'),
                       ('rig_a/hole_20251224.csv', '2025-12-24'), ('rig_a/hole.csv', None),
                       ('rig_a/2026-02-30/hole.csv', None),
                       ('2026-03-14/2026-02-30/hole.csv', '2026-03-14')):
        dates = history_dates({'logs': [str(fleet / path)]})
        assert dates.get('recorded') == told
        assert abs(datetime.fromisoformat(dates['adopted']) - datetime.now()).days <= 2
    assert [*history_dates([])] == [*history_dates({'logs': 5})] == ['adopted']


def test_nothing_there(tmp_path):
    for place, told in ((tmp_path, 'no logs'), (tmp_path / 'none', 'not found')):
        with pytest.raises(InputError, match=told):
            find_campaigns(place)
