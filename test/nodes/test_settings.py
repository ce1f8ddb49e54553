# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Effects as text, and the table of who reads what."""
from hst_drive.bag.topics import TOPICS
from hst_drive.effects import catalogue
from hst_drive.errors import InputError
from hst_drive.nodes import sync, wiring
from hst_drive.nodes.settings import effect_texts, parse_effects
import pytest


def test_units_and_bare_ids():
    assert parse_effects(['motor_leakage.conductance=0.06[L/min/bar]']) == {
        'motor_leakage': {'conductance': pytest.approx(0.06e-3 / 60 / 1e5)}}
    assert parse_effects(['', 'motor_leakage']) == {'motor_leakage': {}}


def test_every_effect_survives_the_way_through_text():
    effects = {name: {parameter.name: max(parameter.typical / 3, parameter.low)
                      for parameter in effect.parameters}
               for name, effect in catalogue().items()}
    assert parse_effects(effect_texts(effects)) == effects


@pytest.mark.parametrize('text', [
    'motor_leakge.conductance=1', 'motor_leakage.g=1', 'motor_leakage.conductance=much',
    'motor_leakage.conductance=nan', 'motor_leakage.conductance=1[bar]',
    'motor_leakage.conductance=1[furlong]', 'motor_leakage=3',
    'motor_leakage.conductance=-1e-12', 'bearing_friction.coulomb=1e9'])
def test_what_cannot_be_read_is_named(text):
    with pytest.raises(InputError, match='effect') as caught:
        parse_effects([text])
    assert text in str(caught.value) and '\n' not in str(caught.value)


def test_the_wiring_speaks_of_nodes_and_topics_that_exist():
    assert set(wiring.READS) == set(wiring.NODES)
    assert {name for names in wiring.READS.values() for name in names} <= set(TOPICS)
    # An emergency stop comes from whoever stands beside the machine; some sensors only a real rig
    # has.
    assert {topic.publisher for topic in TOPICS.values()} <= {
        *wiring.NODES, 'all nodes', 'operator', 'rig'}


def test_what_may_be_under_way_fits_into_the_queues():
    for name in wiring.recorded(wiring.NODES):
        assert sync.INTERVAL + sync.LOOKAHEAD <= TOPICS[name].qos.depth
        assert 2 * sync.INTERVAL <= TOPICS[name].qos.depth


def test_the_recorder_takes_what_the_nodes_publish():
    assert 'motor' not in wiring.recorded(['controller'])
    assert 'case_drain_flow' in wiring.recorded(['plant'], ['case_drain_flow'])
    assert 'truth/motor' in wiring.recorded(['plant'], truth=True)
    with pytest.raises(InputError, match='nothing'):
        wiring.readings(['nothing'])
