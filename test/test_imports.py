# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The architecture, read from the import statements: who may know whom."""
import ast
from pathlib import Path
import subprocess
import sys

import hst_drive
import pytest

PACKAGE = Path(hst_drive.__file__).parent
BASE = {'as_function', 'channels', 'errors', 'plain', 'units'}
MODEL = BASE | {'effects', 'resources', 'rig', 'model'}
PURE = MODEL | {'control', 'load', 'losses', 'measure'}
ABOVE = PURE | {'bag', 'identify', 'design', 'diagnose'}

# Part of the package -> parts that it may import.
MAY_IMPORT = {
    'as_function': set(), 'errors': set(), 'plain': set(), 'units': set(), 'channels': {'units'},
    'resources': {'errors'},
    'rig': BASE | {'resources', 'effects'}, 'effects': BASE, 'model': MODEL,
    'control': BASE, 'load': BASE | {'resources', 'rig'}, 'losses': BASE,
    'measure': PURE, 'bag': BASE | {'measure', 'rig'}, 'watch': PURE, 'identify': PURE,
    'design': PURE | {'identify'}, 'diagnose': ABOVE, 'nodes': PURE | {'bag', 'watch'},
    'report': ABOVE, 'fleet': ABOVE | {'report'}, 'workbench': ABOVE | {'report'},
    'api': ABOVE | {'report'}, 'export': MODEL,
    'cli': ABOVE | {'export', 'fleet', 'nodes', 'report', 'workbench'}, '__main__': {'cli'},
}

# Foreign package -> the only parts that may import it.
ONLY_IN = {
    'rclpy': {'nodes'}, 'rcl_interfaces': {'nodes'}, 'builtin_interfaces': {'nodes'},
    'std_msgs': {'nodes'}, 'std_srvs': {'nodes'}, 'lifecycle_msgs': {'nodes'},
    'sensor_msgs': {'nodes'}, 'geometry_msgs': {'nodes'},
    'diagnostic_msgs': {'nodes'}, 'rosgraph_msgs': {'nodes'}, 'ros2cli': {'cli'},
    'mcap': {'bag'}, 'rosbag2_py': {'bag'}, 'lz4': {'bag'}, 'zstandard': {'bag'},
    'sqlite3': {'bag'},
    'yaml': {'rig', 'bag', 'load', 'nodes', 'cli', 'diagnose', 'report'}, 'numba': {'model'},
    'matplotlib': {'cli', 'report'}, 'plotly': {'report', 'workbench'}, 'dash': {'workbench'},
    'distributed': {'fleet'}, 'pandas': {'api'},
}
SILENT = ['api', 'as_function', 'plain', 'units', 'errors', 'resources', 'rig', 'effects', 'model',
          'control', 'load', 'losses', 'measure', 'bag', 'watch',
          'identify', 'design', 'diagnose', 'export']


def part(path: Path) -> str:
    """Return the part of the package to which a file belongs."""
    return path.relative_to(PACKAGE).parts[0].removesuffix('.py')


FILES = [path for path in sorted(PACKAGE.rglob('*.py')) if path != PACKAGE / '__init__.py']


def imported(path: Path) -> set[str]:
    """Return the dotted names that a file imports anywhere in its code."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: write imports in full'
            names |= {f'{node.module}.{alias.name}' for alias in node.names}
    return names


def test_every_part_has_its_place():
    """A new folder states here whom it may import."""
    assert {part(path) for path in FILES} <= set(MAY_IMPORT)


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_one_way(path):
    """A file imports only parts below its own, and foreign packages only in their place."""
    own = part(path)
    for name in imported(path):
        top, _, rest = name.partition('.')
        if top == 'hst_drive':
            known = rest.partition('.')[0]
            allowed = MAY_IMPORT[own] | {own}
            assert known in allowed or known not in MAY_IMPORT, f'{own} may not import {name}'
        else:
            assert own in ONLY_IN.get(top, {own}), f'{own} may not import {top}'


@pytest.mark.parametrize('path', [path for path in FILES if part(path) in SILENT],
                         ids=lambda path: str(path.relative_to(PACKAGE)))
def test_library_does_not_print(path):
    """What the user reads is said by verbs and nodes."""
    calls = [node for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
             if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    assert not [call.lineno for call in calls if call.func.id == 'print']


def test_diagnosis_cannot_reach_the_truth():
    """With all of it imported, the generator that its benchmark uses was never asked for."""
    code = (
        'import importlib, pkgutil, sys\n'
        'class Closed:\n'
        '    def find_spec(self, name, path=None, target=None):\n'
        '        if name.split(".")[0] in ("test", "bench"):\n'
        '            raise AssertionError(name)\n'
        'sys.meta_path.insert(0, Closed())\n'
        'import hst_drive.diagnose as package\n'
        'for entry in pkgutil.walk_packages(package.__path__, package.__name__ + "."):\n'
        '    importlib.import_module(entry.name)\n'
        'print(len([name for name in sys.modules if name.startswith("hst_drive.diagnose.")]))\n')
    done = subprocess.run([sys.executable, '-c', code], cwd=PACKAGE.parent, text=True,
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 10
