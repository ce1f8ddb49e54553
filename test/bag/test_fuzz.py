# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A small part of ``python -m bench.fuzz``: spoilt files are read or refused, in one line."""
from bench.fuzz import Cases, fuzz
import pytest

NAMES = ('csv', 'csv_with_map', 'csv_sections', 'bag_sections', 'mcap', 'sqlite', 'recover',
         'metadata', 'rig_text', 'scenario_text', 'channel_map_text', 'bench_table', 'rig',
         'scenario', 'channel_map', 'drilling_log', 'effects', 'messages')


@pytest.fixture(scope='module')
def cases(tmp_path_factory):
    """Return the readers with a folder to work in."""
    return Cases(tmp_path_factory.mktemp('fuzz'))


def test_every_reader_is_fuzzed(cases):
    assert set(cases.readers) == set(NAMES)


@pytest.mark.parametrize('name', NAMES)
def test_spoilt_input_is_read_or_refused(cases, name):
    seen, _ = fuzz(cases, name, 60, start=7)
    assert seen['read'] + seen['refused'] == seen['cases'] >= 50
    assert seen['refused'] > 0
