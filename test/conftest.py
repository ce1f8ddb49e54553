# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What all tests share: their own corner of ROS 2, and the markers."""
from contextlib import ExitStack
from importlib.util import find_spec
import os
import sys

from hst_drive.nodes.session import free_domain
from hst_drive.resources import share
import pytest

# Before any rclpy: the nodes that tests start see each other and nothing else. The lock is held
# until the tests end.
LOCKS = ExitStack()
os.environ['ROS_DOMAIN_ID'] = str(free_domain(LOCKS))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(share('config/fastdds_local.xml')))
os.environ.setdefault('AMENT_PREFIX_PATH', sys.prefix)

HAS_NUMBA = find_spec('numba') is not None
# What tests need beyond the package itself; a sourced ROS 2 of Ubuntu has none of it. The made-up
# measurements of test/truth come from a compiled generator.
BAGS = ('mcap', 'mcap_ros2', 'rosbags')
NEEDS = {
    **dict.fromkeys(('bag/test_bags.py', 'bag/test_blocks.py', 'bag/test_cdr.py',
                     'bag/test_channels.py', 'bag/test_csv_log.py', 'bag/test_foreign.py',
                     'bag/test_fuzz.py', 'bag/test_long_bag.py', 'bag/test_recovery.py',
                     'bag/test_rosbag2_py.py'), BAGS),
    **dict.fromkeys(('nodes/test_failures.py', 'nodes/test_nodes.py', 'nodes/test_recorder.py',
                     'nodes/test_clock.py', 'nodes/test_lifecycle.py', 'nodes/test_safety.py',
                     'nodes/test_joints.py', 'nodes/test_rates.py',
                     'nodes/test_run.py'), (*BAGS, 'rclpy')),
    'bench/test_soak.py': ('mcap',), 'nodes/test_start.py': ('mcap', 'rclpy'),
    'effects/test_battery.py': ('pint',), 'diagnose/test_design.py': ('numba',),
    **dict.fromkeys(('diagnose/test_alternatives.py', 'diagnose/test_causes.py',
                     'diagnose/test_hopes.py', 'diagnose/test_limits.py',
                     'diagnose/test_orders.py', 'diagnose/test_pairs.py',
                     'diagnose/test_phases.py', 'measure/test_unjudged.py',
                     'diagnose/test_return_line.py', 'diagnose/test_rough_rock.py',
                     'diagnose/test_shapes.py', 'diagnose/test_slow_rows.py',
                     'diagnose/test_standing.py',
                     'diagnose/test_strangers.py'), ('numba',)),
    'truth': ('numba',), 'bench': ('numba',)}
LACKING = {path: lacking for path, modules in NEEDS.items()
           if (lacking := [name for name in modules if find_spec(name) is None])}
collect_ignore = list(LACKING)
MARKERS = {
    'slow': 'takes long without numba; left out with the oldest versions',
    'needs_numba': 'tests the compiled path; skipped where numba is not installed',
}


def pytest_configure(config):
    """Declare the markers."""
    for name, meaning in MARKERS.items():
        config.addinivalue_line('markers', f'{name}: {meaning}')


def pytest_report_header():
    """Say what is left out."""
    return [f'left out: test/{path} (not installed: {", ".join(lacking)})'
            for path, lacking in LACKING.items()]


def pytest_collection_modifyitems(items):
    """Skip what this environment lacks."""
    if not HAS_NUMBA:
        for item in items:
            if item.get_closest_marker('needs_numba'):
                item.add_marker(pytest.mark.skip(reason='numba is not installed'))
