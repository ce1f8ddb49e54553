# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Inputs take the quality of service of sensors; the grouping file knows what the nodes say."""
import time

from hst_drive.resources import share
import pytest
import yaml

rclpy = pytest.importorskip('rclpy')


@pytest.fixture
def node():
    """Return a node with what an input asks of its owner."""
    context = rclpy.Context()
    rclpy.init(context=context)
    made = rclpy.create_node('inputs', namespace='/inputs', context=context)
    made.settings = {'joint': ''}
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)


@pytest.mark.parametrize('topic, lockstep, offered, heard', [
    ('motor', False, 'BEST_EFFORT', True), ('motor', False, 'RELIABLE', True),
    ('motor', True, 'BEST_EFFORT', False), ('motor', True, 'RELIABLE', True),
    ('speed_setpoint', False, 'BEST_EFFORT', False)])
def test_readings_of_any_driver_are_taken_where_none_must_arrive(
        node, topic, lockstep, offered, heard):
    from hst_drive.nodes.endpoints import Input, message_class, topic_named
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    row = topic_named(topic)
    node.lockstep = lockstep
    found = []
    entry = Input(node, row, lambda stamp, values: found.append(values))
    publisher = node.create_publisher(message_class(row.type), topic, QoSProfile(
        depth=10, reliability=ReliabilityPolicy[offered]))
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    end = time.monotonic() + (20.0 if heard else 1.0)
    while not found and time.monotonic() < end:
        publisher.publish(message_class(row.type)())
        executor.spin_once(timeout_sec=0.05)
    assert bool(found) == heard == bool(entry.received)


@pytest.mark.parametrize('status, group', [
    ('/drive/controller: safety', 'Safety'), ('/east/controller: safety', 'Safety'),
    ('/drive/manager: nodes', 'Safety'),
    ('/drive/estimator: watch', 'Condition'), ('/drive/estimator: valid', 'Condition'),
    ('/arms/controller', None)])
def test_the_aggregator_puts_each_status_into_one_group(status, group):
    """As GenericAnalyzer matches: a status belongs to it if its name contains one of the texts."""
    analyzers = yaml.safe_load(share('config', 'diagnostic_aggregator.yaml').read_text())[
        'analyzers']['ros__parameters']
    del analyzers['path']
    assert {entry['type'] for entry in analyzers.values()} == {
        'diagnostic_aggregator/GenericAnalyzer'}
    found = [entry['path'] for entry in analyzers.values()
             if any(text in status for text in entry['contains'])]
    assert found == ([group] if group else [])
