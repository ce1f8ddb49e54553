# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the topic verdict says; its way through a run is in test_estimator.py."""
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import TOPICS
from hst_drive.measure.balances import BALANCES
from hst_drive.watch.naming import Likely
from hst_drive.watch.watch import Verdict
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


def test_growth_comes_behind_the_effects():
    """Size, share and time stay where they were; the rate has its interval beside it."""
    grown = LIKELY[0]._replace(rate=(2e-16, 1e-16, 3e-16))
    failing = Verdict({}, {}, ('motor_flow',), began=20 * SECOND, effects=(grown, LIKELY[1]))
    said = verdict.named(50 * SECOND, failing)
    assert said['name'] == ['motor_leakage', 'elastic_leakage', 'motor_leakage.rate']
    assert [said[key][2] for key in ('position', 'velocity', 'effort')] == [2e-16, 1e-16, 3e-16]
    assert said['effort'][:2] == [30.0, 30.0]
    _, values = verdict.alarm(Verdict({}, {}, ('motor_flow',), effects=(grown,)), 0, '', (),
                              {entry.id: entry for entry in BALANCES.values()})
    # 2e-16 m^3/(s.Pa) a second: times 3600 s, 6e4 L/min over m^3/s and 1e5 Pa over a bar.
    assert values['trend'] == ('motor_leakage grows: +0.00432 L/min/bar an hour '
                               '(0.00216 to 0.00648)')


@pytest.mark.parametrize('bag, rig, mapping, command', [
    ('run', '', '', 'hst-drive diagnose run'),
    ('', 'unit 7.yaml', '', "hst-drive diagnose BAG --rig 'unit 7.yaml'"),
    ('run', 'unit.yaml', 'map.yaml',
     'hst-drive diagnose run --rig unit.yaml --channels map.yaml')])
def test_the_command_that_it_points_to_has_the_rig_and_the_map(bag, rig, mapping, command):
    assert verdict.to_diagnose({'bag': bag, 'rig': rig, 'channels': mapping}) == command


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
