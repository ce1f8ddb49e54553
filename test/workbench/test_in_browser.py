# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The workbench in a real browser: every switch says what the library says."""
import json
import os
import re
import signal
import subprocess
import sys
import time

from hst_drive.bag import read_log, write_csv
from hst_drive.effects import catalogue
from hst_drive.measure.compare import compare
from hst_drive.model import Drive
from hst_drive.model.circuit_model import part_model
from hst_drive.rig import default_rig, load_rig
import numpy as np
import pytest

from ..browser import chromium, Watched
from ..measure.synthetic import record

pytestmark = pytest.mark.needs_numba
LEAK = {'motor_leakage': {'conductance': 1.2e-12}}
START = {'effects': {}, 'factors': {}}
SHOWN = 'JSON.parse(document.body.dataset.shown)'


class Served:
    """A workbench in a process of its own."""

    def __init__(self, folder, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'hst_drive', 'workbench', '--port', '0', *map(str, arguments)],
            cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            # Who starts tests in the background lets them inherit that it is ignored.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))})
        self.address = re.search('http://[^ ]+', self.process.stdout.readline())[0]

    def end(self):
        """End it with Ctrl-C."""
        self.process.send_signal(signal.SIGINT)
        self.process.stdout.close()
        return self.process.wait(20)


@pytest.fixture(scope='module')
def browser():
    """Return a browser."""
    with chromium() as found:
        yield found


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with two logs of a drive that leaks."""
    place = tmp_path_factory.mktemp('workbench')
    for name, seed in (('fit.csv', 3), ('held.csv', 4)):
        write_csv(place / name, record(seed, duration=8.0, effects=LEAK))
    return place


@pytest.fixture(scope='module')
def served(browser, folder):
    """Return a workbench on those logs."""
    made = Served(folder, 'fit.csv', '--holdout', 'held.csv')
    yield made
    assert made.end() == 0


@pytest.fixture
def seen(browser, served):
    """Return its page; no request may leave the machine, nor anything go wrong in it."""
    watched = Watched(browser, 1360, 900)
    watched.page.goto(served.address)
    watched.until('document.body.dataset.ready', 'yes')
    yield watched
    assert all(url.startswith((served.address, 'data:')) for url in watched.requests)
    assert [text for text in watched.problems if '400 (Bad Request)' not in text] == []
    watched.page.close()


def shown(seen, model):
    """Wait for a model, and return the errors that the page shows for it, by signal."""
    end = time.monotonic() + 60
    while now(seen) != model:
        assert time.monotonic() < end, f'{now(seen)}, expected {model}'
        seen.page.wait_for_timeout(20)
    return {name: float(ratio) for name, ratio in seen.page.evaluate(
        '[...document.querySelectorAll("#error-table tbody tr")].map((row) => '
        '[row.dataset.signal, row.dataset.ratio])')}


def now(seen):
    """Return the model that the page shows."""
    return json.loads(seen.page.evaluate('document.body.dataset.shown'))


def test_every_switch_changes_the_errors_as_the_library_says(seen, folder):
    runs = [read_log(folder / name) for name in ('fit.csv', 'held.csv')]
    assert shown(seen, START)['motor_speed'] > 3
    enters = part_model(default_rig()).enters
    for name, effect in catalogue().items():
        if not enters(name):
            assert seen.page.locator(f'#switch-{name}').count() == 0, name
            continue
        values = effect.typical
        seen.page.check(f'#switch-{name}')
        seen.until(f'Object.keys({SHOWN}.effects).join()', name)
        assert now(seen)['effects'][name] == pytest.approx(values, rel=1e-12)
        found = shown(seen, now(seen))
        expected = compare(Drive(default_rig(), {name: values}), runs).signals
        for signal_name, entry in expected.items():
            assert np.isclose(found[signal_name], entry.noise_ratio, rtol=1e-9), name
        seen.page.uncheck(f'#switch-{name}')
        seen.until(f'JSON.stringify({SHOWN}.effects)', '{}')


def test_fit_undo_and_save(seen, folder):
    page = seen.page
    before = shown(seen, START)
    page.check('#switch-motor_leakage')
    seen.until(f'"motor_leakage" in {SHOWN}.effects')
    page.click('#fit')
    seen.until('!document.getElementById("fit").disabled && '
               'document.getElementById("error-table").textContent.includes("↓")')
    hidden = LEAK['motor_leakage']['conductance']
    seen.until(f'Math.abs({SHOWN}.effects.motor_leakage.conductance / {hidden} - 1) < 0.08')
    after = shown(seen, now(seen))
    assert after['motor_speed'] < 1.3 < 3 < before['motor_speed']
    # The ladder has a rung for each step: start, + motor_leakage, fit.
    for text in ('start', '+ motor_', 'leakage', 'fit'):
        assert text in page.text_content('#ladder-plot')
    page.fill('#name', 'rig_page.yaml')
    page.click('#save')
    seen.until('document.getElementById("kept").textContent.startsWith("Saved")')
    assert load_rig(folder / 'rig_page.yaml').effects == now(seen)['effects']
    page.click('#copy')
    page.wait_for_selector('#kept textarea')
    line = page.input_value('#kept textarea')
    assert line.startswith('hst-drive report ') and 'motor_leakage.conductance=' in line
    page.focus('#fit')
    page.keyboard.press('u')
    seen.until(f'{SHOWN}.effects.motor_leakage.conductance',
               1.3e-12)
    page.click('#undo')
    assert shown(seen, START) == before


def test_what_is_missing_is_found_and_taken_over(seen):
    seen.page.click('#diagnose')
    seen.until('document.getElementById("found").hidden', False, timeout=120)
    assert 'The model lacks motor_leakage' in seen.page.inner_text('#found')
    assert 'W. E. Wilson' in seen.page.inner_text('#found')
    seen.page.click('#found button.offer')
    seen.until(f'"motor_leakage" in {SHOWN}.effects')
    assert shown(seen, now(seen))['motor_speed'] < 1.3
    assert seen.page.is_visible('#factors-box')


def test_mistakes_are_told_on_the_page(seen, folder):
    page = seen.page
    page.check('#switch-motor_leakage')
    seen.until(f'"motor_leakage" in {SHOWN}.effects')
    number = page.locator('[data-id=motor_leakage] input[type=number]').first
    number.fill('1000')
    number.press('Enter')
    seen.until('document.getElementById("alerts").textContent.includes("outside the plausible")')
    number.fill('0.006')
    number.press('Enter')
    seen.until('document.getElementById("alerts").textContent', '')
    assert now(seen)['effects']['motor_leakage']['conductance'] == pytest.approx(1e-12)
    for name in ('../rig.yaml', 'rig.txt'):
        page.fill('#name', name)
        page.click('#save')
        seen.until('document.getElementById("alerts").textContent.includes("is no name")')
    # The log goes: what is shown is what was read, and the page says so.
    (folder / 'fit.csv').rename(folder / 'gone.csv')
    page.uncheck('#switch-motor_leakage')
    seen.until('document.getElementById("alerts").textContent.includes("has gone")')
    (folder / 'gone.csv').rename(folder / 'fit.csv')


def test_the_keyboard_suffices(seen):
    page = seen.page
    page.focus('#switch-pump_lag')
    page.keyboard.press('Space')
    seen.until(f'"pump_lag" in {SHOWN}.effects')
    before = now(seen)['effects']['pump_lag']['time_constant']
    page.focus('[data-id=pump_lag] input[type=range]')
    page.keyboard.press('ArrowRight')
    seen.until(f'{SHOWN}.effects.pump_lag.time_constant > {before}')
    # One step of the slider and one of the switch are two to take back.
    page.focus('#undo')
    page.keyboard.press('Enter')
    page.keyboard.press('Enter')
    shown(seen, START)
    assert page.is_disabled('#undo')


@pytest.mark.parametrize('width', [340, 375, 768])
def test_a_narrow_window_is_usable(browser, served, width):
    watched = Watched(browser, width, 720)
    watched.page.goto(served.address)
    watched.until('document.body.dataset.ready', 'yes')
    assert watched.overflow() <= 0
    watched.page.check('#switch-motor_leakage')
    watched.until(f'"motor_leakage" in {SHOWN}.effects')
    assert watched.overflow() <= 0 and watched.problems == []
    # Held-out errors stand beside training errors without a scroll.
    assert watched.page.evaluate('[...document.querySelectorAll("#error-table .held")].every('
                                 '(cell) => cell.getBoundingClientRect().right <= innerWidth)')
    # The errors stay in sight while a switch is turned.
    assert watched.page.evaluate('document.getElementById("error-table").getBoundingClientRect()'
                                 '.bottom > 0')
    watched.page.close()


def test_the_first_visit_is_led(browser, tmp_path):
    served = Served(tmp_path)
    watched = Watched(browser)
    watched.page.goto(served.address)
    watched.until('document.body.dataset.ready', 'yes')
    guide = watched.page.locator('#guide')
    assert 'Here it fails' in guide.inner_text()
    assert float(watched.page.get_attribute('tr[data-signal=motor_speed]', 'data-ratio')) > 5
    guide.get_by_text('Next').click()
    assert 'This is where' in guide.inner_text()
    guide.get_by_text('Next').click()
    guide.get_by_text('switch motor leakage').click()
    watched.until(f'"motor_leakage" in {SHOWN}.effects')
    guide.get_by_text('Next').click()
    guide.get_by_role('button', name='Fit').click()
    watched.until('[...document.querySelectorAll("#error-table tr[data-ratio]")].every('
                  '(row) => row.dataset.ratio < 1.25)')
    guide.get_by_text('Close the guide').click()
    assert guide.is_hidden() and watched.problems == []
    watched.page.close()
    assert served.end() == 0
