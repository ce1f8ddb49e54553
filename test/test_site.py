# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The documentation as a site: it builds without a warning, nothing is missing, it fits."""
from html.parser import HTMLParser
from pathlib import Path
import subprocess
import sys
from urllib.parse import unquote

from hst_drive.cli import verbs
from hst_drive.effects import catalogue
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .browser import chromium, Watched

for needed in ('sphinx', 'myst_parser', 'sphinx_rtd_theme'):
    pytest.importorskip(needed)
DOCS = Path(__file__).resolve().parents[1] / 'docs'
PAGES = sorted(path.stem for path in (*DOCS.glob('*.md'), *DOCS.glob('*.rst')))
WIDTHS = (1280, 390)


class Page(HTMLParser):
    """What a page links to, loads, and has as places to link to."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.places = set(), set(), set()
        self.feed(path.read_text(encoding='utf-8'))

    def handle_starttag(self, tag, attrs):
        """Note one element."""
        attrs = dict(attrs)
        self.places.add(attrs.get('id'))
        if tag == 'a' and attrs.get('href'):
            self.links.add(attrs['href'])
        elif tag in ('img', 'script') and attrs.get('src'):
            self.loads.add(attrs['src'])
        elif tag == 'link' and attrs.get('rel') == 'stylesheet':
            self.loads.add(attrs['href'])


@pytest.fixture(scope='module')
def site(tmp_path_factory):
    """Return the folder of the built pages, a warning being an error; without the tell-tales."""
    target = tmp_path_factory.mktemp('site') / 'html'
    done = subprocess.run(
        [sys.executable, '-m', 'sphinx', '-q', '-W', '--keep-going', '-b', 'html',
         '-D', 'telltale_pictures=0', str(DOCS), str(target)],
        capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return target


@pytest.fixture(scope='module')
def pages(site):
    return {path.name: Page(path) for path in site.glob('*.html')}


def test_every_page_is_built(pages):
    assert {f'{name}.html' for name in PAGES} <= set(pages)


def test_every_link_leads_somewhere(site, pages):
    """Also those into the middle of a page."""
    for name, page in pages.items():
        for link in page.links:
            target, _, place = unquote(link).partition('#')
            if '://' in target:
                continue
            assert not target or (site / target).exists(), f'{name}: {link}'
            if place and (target or name) in pages:
                assert place in pages[target or name].places, f'{name}: {link}'


def test_nothing_is_loaded_from_elsewhere(site, pages):
    for name, page in pages.items():
        for load in page.loads:
            assert '://' not in load and not load.startswith('//'), f'{name}: {load}'
            path = site / load.partition('?')[0]
            assert path.exists() or 'telltales' in path.parts, f'{name}: {load}'


def test_what_is_declared_has_its_place(pages):
    assert set(verbs()) <= pages['verbs.html'].places
    assert {f'effect-{name.replace("_", "-")}' for name in catalogue()} <= pages[
        'effects.html'].places


def test_no_page_is_wider_than_its_window(site, pages):
    with chromium() as browser:
        seen = Watched(browser)
        for name in sorted(pages):
            seen.page.goto((site / name).as_uri())
            for width in WIDTHS:
                seen.page.set_viewport_size({'width': width, 'height': 900})
                assert seen.overflow() <= 0, f'{name} at {width}'


@pytest.fixture
def telltale(monkeypatch):
    monkeypatch.syspath_prepend(DOCS / '_ext')
    import telltale
    return telltale


@pytest.mark.needs_numba
def test_a_telltale_shows_what_the_equation_says(telltale):
    """What leaks, Q = conductance * P, is speed that is lost: dw = -conductance * P / D."""
    time, signal, within, without, over, variable = telltale.shown('motor_leakage')
    assert (signal, over) == ('motor_speed', 'pump_outlet_pressure')
    judged = time > 8.0
    slope = np.polyfit(variable[judged], (within - without)[judged], 1)[0]
    lost = catalogue()['motor_leakage'].typical['conductance'] / default_rig().motor.displacement
    assert slope == pytest.approx(-lost, rel=0.1)


@pytest.mark.needs_numba
def test_a_telltale_is_drawn(telltale, tmp_path):
    pytest.importorskip('matplotlib')
    telltale.draw('viscous_drag', tmp_path / 'drag.png')
    assert (tmp_path / 'drag.png').read_bytes().startswith(b'\x89PNG')
