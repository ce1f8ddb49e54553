# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The static page in a real browser: opens from disk, asks for nothing, and can be used."""
import json

from hst_drive import cli
from hst_drive.bag import write_csv
import pytest

from .test_page import made_up_diagnosis
from ..browser import chromium, Watched
from ..measure.synthetic import record


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    """Return the page of two logs, a channel with a gap in one of them, and its JSON."""
    place = tmp_path_factory.mktemp('page')
    first, second = record(3, duration=5.0, effects={'motor_leakage': {'conductance': 1e-12}}), \
        record(4, duration=4.0, effects={'motor_leakage': {'conductance': 1e-12}})
    first['motor_speed'][100:150] = float('nan')
    write_csv(place / 'one.csv', first)
    write_csv(place / 'two.csv', second)
    (place / 'd.json').write_text(json.dumps(made_up_diagnosis()))
    assert cli.main(['report', str(place / 'one.csv'), '--holdout', str(place / 'two.csv'),
                     '--diagnosis', str(place / 'd.json'), '-o', str(place / 'p.html'),
                     '--json', str(place / 'r.json')]) == 0
    return place / 'p.html', json.loads((place / 'r.json').read_text())


@pytest.fixture(scope='module')
def browser():
    """Return a browser."""
    with chromium() as found:
        yield found


@pytest.fixture
def seen(browser, made):
    """Return the page, opened from disk."""
    watched = Watched(browser)
    watched.page.goto(made[0].as_uri())
    watched.until('document.querySelectorAll("#curve-plots svg").length > 0')
    yield watched
    assert watched.problems == []
    assert watched.requests == [made[0].as_uri()]
    watched.page.close()


def ratio(page, place):
    """Return the error over the floor that a plot shows."""
    return page.evaluate(
        f'document.querySelectorAll("#curve-plots svg")[{place}].textContent').split(
            'error ')[1].split(' ×')[0]


def test_all_plots_are_drawn(seen):
    page = seen.page
    # Four signals and three inputs; each signal has measured, model and error.
    assert page.locator('#curve-plots svg').count() == 7
    assert page.locator('#curve-plots path.model').count() == 4
    assert page.locator('#map svg rect').count() > 20
    assert page.locator('#strips svg').count() >= 3
    # Four signals times three steps, held out and training, beside the legend.
    assert page.locator('#ladder-plot svg[role=img] title').count() == 1 + 4 * 3 * 2
    # The gap stays a gap: the curve has two parts.
    speed = page.locator('#curve-plots svg').nth(2).locator('path.measured')
    assert speed.get_attribute('d').count('M') == 2
    assert seen.page.locator('nav a').count() >= 6


def test_the_model_can_be_chosen(seen, made):
    adopted = made[1]['with_found'][0]['comparison']['by_log']
    before = made[1]['comparison']['by_log']
    for log in (0, 1):
        seen.page.select_option('#log', str(log))
        for variant, numbers in ((0, before), (1, adopted)):
            seen.page.select_option('#variant', str(variant))
            wanted = numbers[log]['signals']['motor_speed']['noise_ratio']
            seen.page.wait_for_timeout(100)
            assert abs(float(ratio(seen.page, 2)) / wanted - 1) < 0.01
    assert wanted < before[1]['signals']['motor_speed']['noise_ratio']


def test_mouse_and_keyboard_zoom_all_plots_together(seen):
    page = seen.page
    axes = '[...document.querySelectorAll("#curve-plots svg")].map((svg) => ' \
           '[...svg.querySelectorAll(".tick")].map((node) => node.textContent).join())'
    whole = page.evaluate(axes)
    page.locator('#curve-plots .surface').nth(1).scroll_into_view_if_needed()
    box = page.locator('#curve-plots .surface').nth(1).bounding_box()
    page.mouse.move(box['x'] + 0.4 * box['width'], box['y'] + 20)
    page.mouse.down()
    page.mouse.move(box['x'] + 0.6 * box['width'], box['y'] + 20, steps=4)
    page.mouse.up()
    page.wait_for_timeout(150)
    zoomed = page.evaluate(axes)
    assert all(one != other for one, other in zip(whole, zoomed))
    page.focus('#curve-plots')
    page.keyboard.press('0')
    page.wait_for_timeout(150)
    page.keyboard.press('Escape')
    assert page.evaluate(axes) == whole
    page.keyboard.press('ArrowRight')
    lines = page.evaluate('[...document.querySelectorAll("#curve-plots .cursor")].map((node) => '
                          '[node.getAttribute("visibility"), node.getAttribute("d").split(" ")[0]'
                          '])')
    assert len(lines) == 7 and len(set(map(tuple, lines))) == 1 and lines[0][0] == 'visible'
    page.keyboard.press('+')
    page.wait_for_timeout(150)
    assert page.evaluate(axes) != whole


@pytest.mark.parametrize('width', [320, 375, 768, 1280])
def test_no_window_is_too_narrow(browser, made, width):
    watched = Watched(browser, width, 700)
    watched.page.goto(made[0].as_uri())
    watched.until('document.querySelectorAll("#curve-plots svg").length > 0')
    assert watched.overflow() <= 0
    # Titles and numbers above a plot do not run into each other.
    assert watched.page.evaluate("""[...document.querySelectorAll('#curve-plots svg')].every(
        (svg) => { const [a, b] = [...svg.querySelectorAll('text.label')].map(
            (node) => node.getBoundingClientRect()); return !b || a.right < b.left; })""")
    assert watched.problems == []
    watched.page.close()


def test_it_prints(seen):
    seen.page.emulate_media(media='print')
    assert seen.page.locator('nav').is_hidden()
    assert seen.page.locator('.controls').first.is_hidden()
    assert seen.page.pdf(format='A4')[:5] == b'%PDF-'
    assert seen.page.locator('details').first.get_attribute('open') is not None
