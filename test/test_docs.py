# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Documents name what is there: files behind links, verbs, options of verbs."""
import argparse
from importlib import import_module
from pathlib import Path
import re

from hst_drive.cli import verbs
import pytest

TOP = Path(__file__).resolve().parents[1]
PAGES = sorted([*TOP.glob('*.md'), *TOP.glob('docs/*.md'), *TOP.glob('bench/*.md')])
NOT_VERBS = {'test', 'exec'}      # of ./dev itself
CALL = re.compile(r'^ +(?:\./dev|hst-drive|ros2 hst) +([a-z][a-z-]*)(.*)$', re.MULTILINE)


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r'\]\(([^)#]+)\)', page.read_text(encoding='utf-8')):
        if '://' not in link:
            assert (page.parent / link).exists(), link


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_calls_are_of_verbs_and_their_options(page):
    for verb, rest in CALL.findall(page.read_text(encoding='utf-8')):
        if verb in NOT_VERBS:
            continue
        assert verb in verbs(), verb
        parser = argparse.ArgumentParser()
        import_module(f'hst_drive.cli.{verb.replace("-", "_")}').add_arguments(parser)
        known = {name for action in parser._actions for name in action.option_strings}
        words = rest.partition('  #')[0]
        assert set(re.findall(r'(?<![\w-])(--?[a-z][a-z-]*)', words)) <= known, words
