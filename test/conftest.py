# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What all tests share: their own corner of ROS 2, and the markers."""
from contextlib import ExitStack
from importlib.util import find_spec
import os
from pathlib import Path
import re
import sys

from hst_drive.nodes.session import free_domain
from hst_drive.resources import share
from hypothesis import settings
import pytest

# Before any rclpy: the nodes that tests start see each other and nothing else. The lock is held
# until the tests end.
LOCKS = ExitStack()
os.environ['ROS_DOMAIN_ID'] = str(free_domain(LOCKS))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(share('config/fastdds_local.xml')))
os.environ.setdefault('AMENT_PREFIX_PATH', sys.prefix)

# Beside other tests an example may take any time.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')

HAS_NUMBA = find_spec('numba') is not None
# What tests need beyond the package itself; a sourced ROS 2 of Ubuntu has none of it.
BAGS = ('mcap', 'mcap_ros2', 'rosbags')
NEEDS = {
    **dict.fromkeys(('bag/test_bags.py', 'bag/test_blocks.py', 'bag/test_cdr.py',
                     'bag/test_channels.py', 'bag/test_csv_log.py', 'bag/test_foreign.py',
                     'bag/test_fuzz.py', 'bag/test_long_bag.py', 'bag/test_recovery.py',
                     'bag/test_rosbag2_py.py'), BAGS),
    **dict.fromkeys(('nodes/test_failures.py', 'nodes/test_nodes.py', 'nodes/test_recorder.py',
                     'nodes/test_clock.py', 'nodes/test_lifecycle.py', 'nodes/test_safety.py',
                     'nodes/test_joints.py', 'nodes/test_rates.py',
                     'nodes/test_run.py', 'test_ros2_lines.py'), (*BAGS, 'rclpy')),
    'bench/test_soak.py': ('mcap',), 'nodes/test_start.py': ('mcap', 'rclpy'),
    'nodes/test_steady_timers.py': ('rclpy',),
    'effects/test_battery.py': ('pint',), 'truth': ('numba',), 'bench': ('numba',)}
# The made-up measurements of test/truth come from a compiled generator.
MADE_UP = re.compile(r'^from (test\.truth|bench\.campaigns|\S*\.ambiguous)\b', re.MULTILINE)
HERE = Path(__file__).parent
NEEDS |= {str(path.relative_to(HERE)): ('numba',) for path in HERE.rglob('test_*.py')
          if path.parent != HERE / 'truth' and MADE_UP.search(path.read_text(encoding='utf-8'))}
LACKING = {path: lacking for path, modules in NEEDS.items()
           if (lacking := [name for name in modules if find_spec(name) is None])}
collect_ignore = list(LACKING)
MARKERS = {
    'long': 'stands in long.txt; ./dev test leaves it out, ./dev test --all runs it',
    'slow': 'takes long without numba; left out with the oldest versions',
    'needs_numba': 'tests the compiled path; skipped where numba is not installed',
    'flaky': 'in real time, which a busy machine can spoil: tried twice; the summary tells',
}
# Tests and files that take long, one a line, as --write-long found them.
LONG = Path(__file__).with_name('long.txt')
# Tests whose nodes run as processes begin first, in two rows beside the others: whole runs, most
# of them in lockstep, which bear any load; and nodes in real time.
RUNS = ('nodes/test_closed_circuit.py', 'nodes/test_failures.py', 'nodes/test_recorded.py',
        'nodes/test_run.py', 'cli/test_demo.py', 'test_tutorial.py')
IN_REAL_TIME = ('nodes/', 'test_launch.py', 'test_ros2_lines.py')


def pytest_addoption(parser):
    """Declare what measures the tests."""
    parser.addoption('--write-long', type=float, metavar='SECONDS',
                     help='write the tests that take longer into test/long.txt')


def pytest_configure(config):
    """Declare the markers."""
    for name, meaning in MARKERS.items():
        config.addinivalue_line('markers', f'{name}: {meaning}')
    limit = config.getoption('--write-long')
    if limit is not None and not hasattr(config, 'workerinput'):
        config.pluginmanager.register(Stopwatch(limit))


class Stopwatch:
    """Notes tests that take longer than a limit (s), and files whose fixtures do."""

    def __init__(self, limit: float):
        self.limit, self.found = limit, set()

    def pytest_runtest_logreport(self, report):
        """Note one test."""
        if report.duration > self.limit:
            path = report.nodeid.partition('::')[0]
            self.found.add(report.nodeid if report.when == 'call' else path)

    def pytest_sessionfinish(self):
        """Write them."""
        LONG.write_text(''.join(f'{name}\n' for name in sorted(self.found)), encoding='utf-8')


def row(nodeid: str) -> str:
    """Return which tests run one after the other: those of a file, or all with nodes of a kind."""
    path = nodeid.removeprefix('test/').partition('::')[0]
    return ('runs' if path in RUNS else 'real time' if path.startswith(IN_REAL_TIME)
            else path)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give each process whole files, for tests of a file share what they have made."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return row(nodeid)

    config.option.loadscopereorder = False
    return ByFile(config, log)


def pytest_report_header():
    """Say what is left out."""
    return [f'left out: test/{path} (not installed: {", ".join(lacking)})'
            for path, lacking in LACKING.items()]


def pytest_collection_modifyitems(items):
    """Sort, mark what takes long, and skip what this environment lacks."""
    items.sort(key=lambda item: row(item.nodeid) not in ('runs', 'real time'))
    long = set(LONG.read_text(encoding='utf-8').splitlines())
    for item in items:
        if not long.isdisjoint((item.nodeid, item.nodeid.partition('::')[0])):
            item.add_marker(pytest.mark.long)
        if not HAS_NUMBA and item.get_closest_marker('needs_numba'):
            item.add_marker(pytest.mark.skip(reason='numba is not installed'))
        if row(item.nodeid) == 'real time':
            item.add_marker(pytest.mark.flaky(reruns=1, only_rerun=['.']))
