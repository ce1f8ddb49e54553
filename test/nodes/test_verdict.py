# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the topic verdict says; its way through a run is in test_estimator.py."""
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import TOPICS
from hst_drive.measure.online.naming import Likely
from hst_drive.measure.online.watch import Verdict
import pytest

verdict = pytest.importorskip('hst_drive.nodes.verdict')
SECOND = 1_000_000_000
LIKELY = (Likely('motor_leakage', 0.97, 'conductance', 1.3e-12),
          Likely('elastic_leakage', 0.94, 'factor', 2e-19))


def test_nothing_fails_and_nothing_is_named():
    said = verdict.named(50 * SECOND, Verdict({}, {}))
    assert said == {'name': [], 'position': [], 'velocity': [], 'effort': []}


def test_effects_come_with_size_share_and_time():
    said = verdict.named(50 * SECOND, Verdict({}, {}, ('motor_flow',), began=20 * SECOND,
                                              effects=LIKELY))
    assert said == {'name': ['motor_leakage', 'elastic_leakage'], 'position': [1.3e-12, 2e-19],
                    'velocity': [0.97, 0.94], 'effort': [30.0, 30.0]}


def test_a_failure_that_no_effect_explains_is_told_all_the_same():
    said = verdict.named(5 * SECOND, Verdict({}, {}, ('motor_flow',), began=2 * SECOND))
    assert said == {'name': ['unknown'], 'position': [0.0], 'velocity': [0.0], 'effort': [3.0]}


def test_another_reader_decodes_the_message():
    rosbags = pytest.importorskip('rosbags.typesys')
    said = verdict.named(50 * SECOND, Verdict({}, {}, ('motor_flow',), began=20 * SECOND,
                                              effects=LIKELY))
    kind = TOPICS['verdict'].type
    data = Codec(kind, find_definition(kind)).encode({'header': {'frame_id': 'motor'}, **said})
    message = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY).deserialize_cdr(bytes(data), kind)
    for name, values in said.items():
        assert list(getattr(message, name)) == values
