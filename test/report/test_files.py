# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that people read and edit."""
from hst_drive.report.files import read_json, write_yaml
import yaml


def test_what_stands_twice_is_written_twice(tmp_path):
    size = {'conductance': 2e-13}
    content = {'effects': {'pump_leakage': size}, 'changed': {'to': size}}
    write_yaml(content, tmp_path / 'rig.yaml')
    text = (tmp_path / 'rig.yaml').read_text(encoding='utf-8')
    assert '&' not in text and '*' not in text and yaml.safe_load(text) == content


def test_a_file_that_holds_nothing_gives_a_mapping(tmp_path):
    """'null' is JSON: who reads it says that its schema is missing."""
    (tmp_path / 'd.json').write_text('null')
    assert read_json(str(tmp_path / 'd.json')) == {}
