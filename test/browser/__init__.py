# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A real headless Chromium for tests of pages; where there is none, they are skipped."""
from contextlib import contextmanager
import os
from pathlib import Path
import shutil
import time

import pytest

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
# What ./dev test fetches where the machine has none (install.sh).
FETCHED = Path(__file__).parents[2] / '.venv' / 'browser'
OPTIONS = ('--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync', '--no-zygote',
           # Whatever a page asks for beyond this machine is not found.
           '--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1 , EXCLUDE localhost')


def program() -> tuple[str | None, dict[str, str]]:
    """Return the browser's path, None if there is none, and its environment."""
    named = os.environ.get('HST_DRIVE_CHROMIUM')
    found = named or next(filter(None, map(shutil.which, NAMES)), None)
    if found or not (FETCHED / 'installed').exists():
        return found, {}
    return str(FETCHED / 'chromium'), {
        'LD_LIBRARY_PATH': f'{FETCHED}/lib:{FETCHED}', 'FONTCONFIG_FILE': f'{FETCHED}/fonts.conf'}


@contextmanager
def chromium():
    """Give a running browser; skip the test where it or playwright is missing."""
    playwright = pytest.importorskip('playwright.sync_api', reason='playwright is not installed')
    path, environment = program()
    if path is None:
        pytest.skip('no Chromium: neither on the PATH nor fetched by ./dev test (needs npm)')
    with playwright.sync_playwright() as tool:
        browser = tool.chromium.launch(executable_path=path, args=list(OPTIONS),
                                       env={**os.environ, **environment})
        yield browser
        browser.close()


class Watched:
    """
    A page that remembers what it asked for and what went wrong.

    Parameters
    ----------
    browser : Browser
        Of playwright.
    width, height : int
        Of the window.

    """

    def __init__(self, browser, width=1280, height=900):
        self.page = browser.new_page(viewport={'width': width, 'height': height})
        self.requests, self.problems = [], []
        self.page.on('request', lambda request: self.requests.append(request.url))
        self.page.on('pageerror', lambda error: self.problems.append(str(error)))
        self.page.on('console', lambda message: message.type == 'error'
                     and self.problems.append(message.text))

    def until(self, script, wanted=True, timeout=60.0):
        """Wait until a script of the page gives a value; its policy forbids waiting inside."""
        end = time.monotonic() + timeout
        while (found := self.page.evaluate(script)) != wanted:
            assert time.monotonic() < end, f'{script}: {found!r}, expected {wanted!r}'
            self.page.wait_for_timeout(20)

    def overflow(self) -> int:
        """Return by how many pixels the page is wider than its window."""
        return self.page.evaluate('document.documentElement.scrollWidth - innerWidth')
