# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The guide for integrators and the security policy say what the code does."""
from pathlib import Path
import re
from xml.etree import ElementTree

from hst_drive.bag.topics import TOPICS
from hst_drive.control.safety import FAULTS, SafetySettings
from hst_drive.nodes.wiring import READS
from hst_drive.resources import share
import pytest
import yaml

GUIDE = (Path(__file__).resolve().parents[1] / 'docs' / 'integration.md').read_text()
POLICY = ElementTree.parse(share('config', 'sros2_policy.xml')).getroot()
OURS = ('~/transition_event', '/rosout', '/parameter_events', '*')


def test_every_fault_has_its_row_and_its_time_is_the_default():
    assert set(re.findall(r'^\| `(\w+)` \|', GUIDE, re.MULTILINE)) == set(FAULTS)
    for name, value in vars(SafetySettings()).items():
        said = f'`{name}` {str(value).lower() if isinstance(value, bool) else format(value, "g")}'
        assert said in GUIDE, said


def test_the_defaults_of_the_library_are_those_of_the_shipped_parameters():
    shipped = yaml.safe_load(share('config', 'drive.yaml').read_text())
    shipped = shipped['/**/controller']['ros__parameters']
    assert {name: shipped[name] for name in vars(SafetySettings())} == vars(SafetySettings())


def granted(node, kind, way):
    """Return the names that the policy grants a node."""
    return {entry.text for profile in POLICY.iter('profile') if profile.get('node') == node
            for group in profile.iter(f'{kind}s') if group.get(way) == 'ALLOW'
            for entry in group}


def test_the_policy_names_topics_that_exist_and_all_that_the_nodes_need():
    for topic in POLICY.iter('topic'):
        assert topic.text in TOPICS or topic.text in OURS, topic.text
    for node in ('controller', 'estimator'):
        assert set(READS[node]) <= granted(node, 'topic', 'subscribe')
        published = {name for name, topic in TOPICS.items() if topic.publisher == node}
        assert published <= granted(node, 'topic', 'publish')


@pytest.mark.parametrize('topic, allowed', [('pump_command', {'controller'}),
                                            ('emergency_stop', {'operator'})])
def test_the_policy_lets_one_node_alone_command_and_stop(topic, allowed):
    nodes = {profile.get('node') for profile in POLICY.iter('profile')}
    assert {node for node in nodes if topic in granted(node, 'topic', 'publish')} == allowed
    assert {node for node in nodes
            if 'controller/reset' in granted(node, 'service', 'request')} == {'operator'}
