# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What many answers say together, on fleets whose truth is known."""
from html.parser import HTMLParser
import json

from hst_drive.fleet.document import as_json
from hst_drive.fleet.page import fleet_page
from hst_drive.fleet.summary import AHEAD, GROWS, summarise
from hst_drive.fleet.track import POWERS
from hst_drive.fleet.words import sentence
from hst_drive.plain import plain
import numpy as np
import pytest

from .lives import fleet, rows, SIGMA, START, together, TYPICAL

LIMIT = 1.6 * TYPICAL
LIMITS = {('motor_leakage', 'conductance'): LIMIT}


@pytest.fixture(scope='module')
def lives():
    """Return a fleet."""
    return fleet()


@pytest.fixture(scope='module')
def summary(lives):
    """Return what it says."""
    return summarise(lives, LIMITS)


@pytest.fixture(scope='module')
def machines(summary):
    """Return its machines by name."""
    return {machine.name: machine for machine in summary.machines}


def test_the_most_urgent_comes_first(summary):
    """What has passed its limit before what will, that before what stays, sound ones last."""
    names = [machine.name for machine in summary.machines]
    assert names[:2] == ['far <off>', 'wears'] and names[-1] == 'new'
    assert names.index('steady') < names.index('sound')
    assert sentence(summary).startswith(
        '13 machines: 1 limit reached, 1 limit ahead, 7 fault, 3 nothing found, '
        '1 not judged. First to see to: far <off> (motor_leakage, limit of 0.0096 L/min/bar: ')


def test_wear_is_told_with_its_end(machines):
    """It grows by TYPICAL in the 671 days of the logs; the limit is 1.6 of that."""
    machine, = [machines['wears']]
    entry, = machine.followed
    assert machine.state == AHEAD and entry.growth.kind == 'grows'
    assert entry.growth.rate[0] < TYPICAL / 671 < entry.growth.rate[2]
    true = START.toordinal() + 1.6 * 671
    assert entry.remaining.low < true < entry.remaining.high


@pytest.mark.parametrize('told', ['', 'logs', 'file'])
@pytest.mark.parametrize('power', [0.0, 0.5, 1.0])
def test_a_leak_is_told_in_oil_as_it_usually_is(power, told):
    """
    A machine leaks TYPICAL by its table and as much again after 671 days; its summers are warm.

    All goes with a power of the viscosity. What is left of it if the table goes with another one
    is what logs of each date tell. Where oil warms up in them they tell the power; or it is in
    the machine's file.
    """
    days = 61.0 * np.arange(12)
    thin = np.exp(0.3 * np.sin(2.0 * np.pi * days / 365.25))
    law = TYPICAL * days / days[-1]

    def left(other):
        return (law + TYPICAL) * thin**power - TYPICAL * thin**other

    found, followed = rows('warm', days, left(0.5), sigma=0.5 * SIGMA)
    for row, *sizes, viscosity in zip(followed, *map(left, POWERS), 3e-5 / thin):
        row |= {'viscosity': viscosity, 'law': (power, 0.1) if told == 'file' else None,
                'misfits': (told == 'logs') * 100.0 * (np.array(POWERS) - power)**2}
        own = row['sizes']['motor_leakage']
        own['by_power'] = sizes + own['value'] - sizes[1]
    machine, = summarise(together((found, followed)), LIMITS).machines
    entry, = machine.followed
    assert entry.grows and not machine.events
    assert entry.growth.level[0] < TYPICAL < entry.growth.level[2]
    assert entry.growth.rate[0] < TYPICAL / 671 < entry.growth.rate[2]
    assert entry.growth.usual.values == pytest.approx(law, abs=(0.02 if told else 0.06) * TYPICAL)
    assert entry.remaining.low < START.toordinal() + 1.6 * 671 < entry.remaining.high


def test_a_repair_is_one_below_none_as_well():
    """Against a machine's first days, which need not have been its best."""
    days = 61.0 * np.arange(12)
    machine, = summarise(together(rows('low', days, np.where(
        days < 400, 0.5 * TYPICAL * days / 366, -0.6 * TYPICAL)))).machines
    event, = machine.events
    assert event.what.startswith('motor_leakage fell back: repaired')
    assert not machine.followed[0].there


def test_no_limit_is_ahead_where_it_is_not_clear_whether_it_grows():
    """Some laws that fit reach the limit, others do not."""
    days = 61.0 * np.arange(5)
    machine, = summarise(together(rows('odd', days, TYPICAL * np.array(
        [0.5, 0.55, 0.52, 0.6, 0.66]))), LIMITS).machines
    entry, = machine.followed
    assert entry.growth.kind == 'not clear' and np.isfinite(entry.remaining.middle)
    assert machine.state == 'fault'


def test_without_a_limit_it_only_grows(lives):
    states = {machine.name: machine.state for machine in summarise(lives).machines}
    assert states['wears'] == GROWS and states['far <off>'] == 'fault'


def test_events_are_told_in_the_words_of_who_maintains_it(machines):
    repair, = machines['repaired'].events
    assert 'fell back: repaired' in repair.what
    oil, = machines['oil'].events
    assert oil.what.startswith('oil changed: softer')
    assert not machines['wears'].events and not machines['steady'].events


def test_two_dates_tell_no_growth(lives, machines):
    told = as_json(lives, summarise(lives, LIMITS))['machines'][-1]['told']
    assert 'too few dates to say whether it grows' in told[0]
    assert machines['new'].followed[0].remaining is None


def test_who_is_unlike_the_others(summary):
    """By what they show now: what was repaired counts no more."""
    assert {entry.point.machine for entry in summary.outliers} == {'far <off>', 'wears'}


def test_who_lacks_what(summary, machines):
    assert machines['wears'].effects['motor_leakage'] == 10
    assert (machines['sound'].campaigns, machines['sound'].failed) == (12, 1)
    assert summary.failures == [('sound/2025-11-11', 'no <rows>')]


def test_a_campaign_without_a_date_is_named(lives):
    assert 'without a date' not in sentence(summarise(lives))
    undated = [*lives.rows[:-1], {**lives.rows[-1], 'date': None}]
    said = sentence(summarise(lives._replace(rows=undated)))
    assert '1 campaign in no trend, without a date (YYYY-MM-DD) in the name' in said
    assert f'of a log: {undated[-1]["campaign"]}.' in said


def test_what_is_written_is_json(lives, summary):
    """Days that are too far away are none, and nothing is infinite."""
    found = json.loads(json.dumps(plain(as_json(lives, summary)), allow_nan=False))
    assert found['schema'] == 'hst_drive/fleet/2'
    assert found['machines'][1]['followed'][0]['remaining']['low'] > '2026-06'


def test_an_empty_life(lives):
    """Machines of which no size is known have a row as well."""
    rows = [{**row, 'date': None} for row in lives.rows[:3]]
    found = summarise(together((rows, [])))
    assert [machine.name for machine in found.machines] == ['wears']


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


def test_the_page_is_whole_and_alone(lives, summary):
    page = fleet_page('north', lives.rows, summary)
    reader = _Tags()
    reader.feed(page)
    assert not reader.open
    assert 'script' not in reader.seen and 'link' not in reader.seen and 'img' not in reader.seen
    assert reader.seen.count('svg') == len(summary.machines)
    assert 'http' not in page.replace('http-equiv', '')
    assert 'far &lt;off&gt;' in page and '<off>' not in page and 'no &lt;rows&gt;' in page
    assert '<title>Fleet north</title>' in page and 'L/min/bar' in page
