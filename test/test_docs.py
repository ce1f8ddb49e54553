# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Documents name what is there: files behind links, verbs, keys."""
import argparse
from importlib import import_module
from pathlib import Path
import re
import shlex

from hst_drive.bag.channels import parse_channel_map
from hst_drive.cli import verbs
from hst_drive.load import LoadingUnit, parse_scenario
from hst_drive.load.load_sections import LOAD_KINDS
from hst_drive.load.scenario import MODES, STARTS
from hst_drive.rig import default_rig_file
from hst_drive.rig.load import parse_rig
import pytest
import yaml

TOP = Path(__file__).resolve().parents[1]
PAGES = sorted([*TOP.glob('*.md'), *TOP.glob('docs/*.md'), *TOP.glob('bench/*.md')])
NOT_VERBS = {'docs', 'exec', 'lint', 'test'}      # of ./dev itself
# The brackets of what may be left out, which stand alone; those of a unit follow a number.
OPTIONAL = re.compile(r'(?<![\w.])\[([^\[\]]*)\]')
YAML = re.compile(r'```yaml\n(.*?)```', re.DOTALL)
CALL = re.compile(r'^ +(?:\./dev|hst-drive|ros2 hst) +([a-z][a-z-]*)(.*)$', re.MULTILINE)


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r'\]\(([^)#]+)\)', page.read_text(encoding='utf-8')):
        if '://' not in link:
            assert (page.parent / link).exists(), link


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_calls_are_of_verbs_and_would_be_understood(page):
    """What stands in brackets may be left out; here it is not."""
    text = page.read_text(encoding='utf-8').replace('\\\n', '')
    for verb, rest in CALL.findall(text):
        if verb in NOT_VERBS:
            continue
        assert verb in verbs(), verb
        parser = argparse.ArgumentParser(exit_on_error=False)
        import_module(f'hst_drive.cli.{verb.replace("-", "_")}').add_arguments(parser)
        words = [word for word in shlex.split(OPTIONAL.sub(r'\1', rest), comments=True)
                 if word != '...' and not word.startswith(('>', '|'))]
        try:
            parser.parse_args(words)
        except (argparse.ArgumentError, SystemExit) as problem:
            raise AssertionError(f'{verb} {rest}: {problem}') from problem


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_yaml_is_understood(page):
    """A channel map or scenario as such; others as a rig, some sections in place of its own."""
    shipped = yaml.safe_load(default_rig_file().read_text(encoding='utf-8'))
    for block in YAML.findall(page.read_text(encoding='utf-8')):
        content = yaml.safe_load(block)
        if 'channels' in content:
            parse_channel_map(content, page.name)
        elif 'title' in content:
            parse_scenario(content, LoadingUnit.of(parse_rig(shipped).loading), page.name)
        else:
            parse_rig(content if 'name' in content else shipped | content, page.name)


def test_the_page_of_scenarios_has_all_kinds():
    text = (TOP / 'docs' / 'scenarios.md').read_text(encoding='utf-8')
    for word in (*LOAD_KINDS, *MODES, *STARTS):
        assert f'`{word}`' in text, word
