# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Layouts of PlotJuggler and Foxglove name only topics and fields that the nodes publish."""
import json
from xml.etree import ElementTree

from hst_drive.bag.topics import JOINT_STATE, TOPICS
from hst_drive.resources import share

BY_NAME = {topic.full_name(): topic for topic in TOPICS.values()}


def series_of_plotjuggler():
    """Return the names that PlotJuggler gives to what is published by default."""
    names = set()
    for name, topic in BY_NAME.items():
        for field in topic.fields if topic.on else ():
            # PlotJuggler sorts a JointState by the joint, whose name is the topic's frame.
            path = f'{topic.frame}/{field.path.removesuffix("[0]")}' \
                if topic.type == JOINT_STATE else field.path.replace('.', '/')
            names.add(f'{name}/{path}')
    return names


def test_plotjuggler():
    root = ElementTree.parse(share('config/plotjuggler_drive.xml')).getroot()
    curves = [curve.get('name') for curve in root.iter('curve')]
    assert len(curves) > 20 and set(curves) <= series_of_plotjuggler()
    chosen = root.find('.//selected_topics').get('value').split(';')
    assert set(chosen) <= set(BY_NAME)
    assert {'/'.join(curve.split('/')[:3]) for curve in curves} <= set(chosen)
    assert [tab.get('tab_name') for tab in root.iter('Tab')] == [
        'drive', 'efficiencies', 'residuals', 'verdict']
    for splitter in root.iter('DockSplitter'):
        shares = [float(size) for size in splitter.get('sizes').split(';')]
        assert len(list(splitter)) == int(splitter.get('count')) == len(shares)
        assert abs(sum(shares) - 1) < 1e-3


def leaves(layout):
    """Return the panels of a layout."""
    if isinstance(layout, str):
        return [layout]
    assert layout['direction'] in ('row', 'column') and 0 < layout['splitPercentage'] < 100
    return leaves(layout['first']) + leaves(layout['second'])


def test_foxglove():
    content = json.loads(share('config/foxglove_drive.json').read_text())
    panels = content['configById']
    shown = leaves(content['layout'])
    for tab in panels[content['layout']]['tabs']:
        shown += leaves(tab['layout'])
    assert sorted(shown) == sorted(panels)
    paths = [entry['value'] for panel in panels.values() for entry in panel.get('paths', ())]
    assert len(paths) > 20
    for path in paths:
        name, _, field = path.partition('.')
        assert BY_NAME[name].on and field in [entry.path for entry in BY_NAME[name].fields], path
    assert {panel['topicToRender'] for panel in panels.values()
            if 'topicToRender' in panel} == {'/diagnostics'} <= set(BY_NAME)


def test_both_show_the_same():
    root = ElementTree.parse(share('config/plotjuggler_drive.xml')).getroot()
    content = json.loads(share('config/foxglove_drive.json').read_text())
    topics = {entry['value'].partition('.')[0] for panel in content['configById'].values()
              for entry in panel.get('paths', ())}
    assert topics == {'/'.join(curve.get('name').split('/')[:3]) for curve in root.iter('curve')}
