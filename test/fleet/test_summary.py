# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What many answers say together, on fleets whose truth is known."""
from html.parser import HTMLParser

from hst_drive.fleet.page import fleet_page
from hst_drive.fleet.summary import summarise
import numpy as np
import pytest

from . import stubs

YEAR = 365.25


def row(machine, day, size=None, status='done', reason=None):
    """Return a row; without a size nothing was missing."""
    found = stubs.answer(size) if size is not None else {
        'verdict': 'none', 'sentence': 'Nothing is missing.', 'effects': []}
    date = str(np.datetime64('2026-01-01') + day)
    return {'campaign': f'{machine}/{date}', 'machine': machine, 'date': date, 'status': status,
            'reason': reason, 'diagnosis': found if status == 'done' else None}


@pytest.fixture(scope='module')
def rows():
    """Return a fleet: one wears, one does not, one is far off, one is sound, one log failed."""
    random = np.random.default_rng(5)
    found = [row('wears', day, 1e-12 * (1 + day / YEAR) * (1 + 0.01 * random.standard_normal()))
             for day in range(0, 200, 20)]
    found += [row('steady', day, 1e-12 * (1 + 0.02 * random.standard_normal()))
              for day in range(0, 200, 20)]
    found += [row(f'other_{k}', 5, 1e-12 * (1 + 0.05 * random.standard_normal()))
              for k in range(6)]
    found += [row('far <off>', 5, 9e-12), row('sound', 5),
              row('sound', 6, status='failed', reason='no <rows>')]
    return found


def test_wear_is_told_from_scatter(rows):
    found = {trend.machine: trend for trend in summarise(rows).trends}
    assert set(found) == {'wears', 'steady'}
    assert found['wears'].direction == 'grows'
    assert found['wears'].low < 1e-12 < found['wears'].high
    assert found['wears'].slope == pytest.approx(1e-12, rel=0.15)
    assert found['steady'].direction == 'steady'


def test_who_is_unlike_the_others(rows):
    found = summarise(rows).outliers
    assert found[0].point.machine == 'far <off>'
    # What wears far enough leaves the others, too: late, not early.
    worn = [entry.point for entry in found if entry.point.machine == 'wears']
    assert len(found) == 1 + len(worn) and min(point.date for point in worn) > '2026-02-20'


def test_who_lacks_what(rows):
    summary = summarise(rows)
    machines = {machine.name: machine for machine in summary.machines}
    assert machines['wears'].effects == {'motor_leakage': 10}
    assert machines['sound'].verdicts == {'none': 1}
    assert (machines['sound'].campaigns, machines['sound'].failed) == (2, 1)
    assert summary.failures == [('sound/2026-01-07', 'no <rows>')]


def test_steady_fleets_show_no_trend():
    """By chance a 95 % interval misses zero in one of twenty: not in far more."""
    random = np.random.default_rng(11)
    found = summarise([row(f'rig {k}', day, 1e-12 * (1 + 0.1 * random.standard_normal()))
                       for k in range(200) for day in range(0, 240, 30)]).trends
    assert len(found) == 200
    assert sum(trend.direction != 'steady' for trend in found) <= 20


class _Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.seen = [], []

    def handle_starttag(self, tag, attrs):
        self.seen.append(tag)
        if tag != 'meta':
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_whole_and_alone(rows):
    page = fleet_page('Fleet', 'All of it.', rows, summarise(rows), ['29 campaigns'])
    reader = _Tags()
    reader.feed(page)
    assert not reader.open
    assert 'script' not in reader.seen and 'link' not in reader.seen and 'img' not in reader.seen
    assert reader.seen.count('svg') == 2
    assert 'http' not in page.replace('http-equiv', '')
    assert 'far &lt;off&gt;' in page and '<off>' not in page and 'no &lt;rows&gt;' in page
    assert 'L/min/bar' in page
