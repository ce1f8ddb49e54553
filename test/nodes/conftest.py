# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What tests of nodes share."""
from test.nodes.controller_bench import Bench

import pytest


@pytest.fixture(scope='module')
def context():
    """Let rclpy run."""
    rclpy = pytest.importorskip('rclpy')
    rclpy.init()
    yield
    rclpy.shutdown()


@pytest.fixture
def bench(context, monkeypatch):
    """Return what makes a controller between the endpoints of a test."""
    made = []

    def make(**parameters):
        made.append(Bench(monkeypatch, **parameters))
        return made[-1]

    yield make
    for entry in made:
        entry.close()
