# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a fleet in a real browser: read on a telephone and at a desk, without scrolling."""
from hst_drive.fleet.page import fleet_page
from hst_drive.fleet.summary import summarise
import pytest

from .lives import fleet, TYPICAL
from ..browser import chromium, Watched

_WIDE = """Array.from(document.querySelectorAll('.overview .scroll')).filter(
    box => box.scrollWidth > box.clientWidth + 1).length"""


@pytest.fixture(scope='module')
def browser():
    """Return a browser."""
    with chromium() as found:
        yield found


@pytest.mark.parametrize('width', [380, 1280])
def test_what_is_urgent_is_read_without_scrolling_sideways(browser, tmp_path, width):
    lives, target = fleet(), tmp_path / 'fleet.html'
    summary = summarise(lives, {('motor_leakage', 'conductance'): 1.6 * TYPICAL})
    target.write_text(fleet_page('north', lives.rows, summary), encoding='utf-8')
    watched = Watched(browser, width)
    watched.page.goto(target.as_uri())
    assert watched.overflow() <= 0 and watched.page.evaluate(_WIDE) == 0
    first = watched.page.inner_text('.overview tbody tr:first-child')
    assert 'far <off>' in first and 'limit reached' in first and 'reached already' in first
    second = watched.page.inner_text('.overview tbody tr:nth-child(2)')
    assert all(told in second for told in ('grows by', 'the first log', 'about 20'))
    assert watched.page.locator('.machine svg').count() == len(summary.machines)
    assert watched.problems == [] and len(watched.requests) == 1
