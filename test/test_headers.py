# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Licence headers, and the version that three files state."""
from pathlib import Path
import re
from xml.etree import ElementTree

import hst_drive
import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ('hst_drive', 'launch', 'test', 'config', 'scripts', '.ci')
# CSV files have no comments and are left out.
ENDINGS = ('.py', '.yaml', '.yml', '.xml', '')
FILES = [*(ROOT / name for name in ('dev', 'setup.py', 'package.xml')),
         *(path for folder in FOLDERS for path in sorted((ROOT / folder).rglob('*'))
           if path.is_file() and path.suffix in ENDINGS and '__pycache__' not in path.parts)]


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_states_the_licence(path):
    """Each file names its licence within the first lines."""
    head = path.read_text(encoding='utf-8').splitlines()[:6]
    assert any('SPDX-License-Identifier: Apache-2.0' in line for line in head)


def test_one_version():
    """The package, package.xml and the changelog agree."""
    stated = ElementTree.parse(ROOT / 'package.xml').findtext('version')
    assert stated == hst_drive.__version__
    changelog = (ROOT / 'CHANGELOG.rst').read_text(encoding='utf-8')
    heading = re.search(r'^(Forthcoming|\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\))$', changelog,
                        re.MULTILINE)[1]
    # What is not released has no number yet (REP 132).
    assert heading == 'Forthcoming' or heading.split()[0] == stated


def test_the_package_states_whose_it_is_and_what_a_stock_machine_needs():
    """As setup.py does; bags need rosbag2_py and the plugin for MCAP, as apt has no mcap."""
    package = ElementTree.parse(ROOT / 'package.xml')
    setup = (ROOT / 'setup.py').read_text(encoding='utf-8')
    for value in (package.findtext('url'), package.findtext('author'),
                  package.find('author').get('email'), package.find('maintainer').get('email')):
        assert f"'{value}'" in setup
    needs = {entry.text for entry in package.findall('exec_depend')}
    assert {'rosbag2_py', 'rosbag2_storage_mcap'} <= needs
    assert not any('mcap' in name for name in needs - {'rosbag2_storage_mcap'})


def test_what_tests_declare_is_used():
    """By an import of a test, or, of pytest, by running them."""
    imported = set(re.findall(r'^(?:import|from) (\w+)', '\n'.join(
        path.read_text(encoding='utf-8') for path in (ROOT / 'test').rglob('*.py')), re.MULTILINE))
    for entry in ElementTree.parse(ROOT / 'package.xml').findall('test_depend'):
        assert entry.text.removeprefix('python3-') in imported, entry.text
