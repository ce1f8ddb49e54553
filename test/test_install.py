# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The package as pip and as colcon install it."""
from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import subprocess
import sys
from zipfile import ZipFile

import hst_drive
import pytest

ROOT = Path(__file__).parents[1]
NODES = ('controller', 'estimator', 'load_profile', 'plant', 'recorder')
PROGRAMS = sorted(('hst-drive', 'manager', *NODES))
ASK = 'from hst_drive.resources import share; print(share("config"))'


@pytest.fixture(scope='module')
def source(tmp_path_factory):
    """Return a copy of what is installed, in the src folder of a workspace."""
    target = tmp_path_factory.mktemp('workspace') / 'src' / 'hst_drive'
    target.mkdir(parents=True)
    for name in ('hst_drive', 'config', 'launch', 'resource', 'scripts'):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, target / name,
                            ignore=shutil.ignore_patterns('__pycache__'))
    for name in ('package.xml', 'setup.py', 'setup.cfg'):
        shutil.copy(ROOT / name, target)
    return target


def shell(command, folder, **environment):
    """Return what a command prints in a clean environment; the venv's programs come first."""
    keep = {name: os.environ[name] for name in ('HOME', 'LANG') if name in os.environ}
    done = subprocess.run(
        ['sh', '-c', command], cwd=folder, capture_output=True, text=True, timeout=300,
        env=keep | {'PATH': f'{Path(sys.executable).parent}:/usr/bin:/bin',
                    'AMENT_PREFIX_PATH': sys.prefix} | environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip()


def test_wheel(source, tmp_path):
    """A wheel holds code, shipped files and entry points, and no second hst-drive."""
    shell(f'python -m pip wheel -q --no-deps --no-build-isolation -w . {source}', tmp_path)
    path, = tmp_path.glob('*.whl')
    with ZipFile(path) as wheel:
        names = wheel.namelist()
        entries = wheel.read(next(name for name in names if name.endswith('entry_points.txt')))
    stem = f'hst_drive-{hst_drive.__version__}'
    data = {name.removeprefix(f'{stem}.data/data/') for name in names if '.data/data/' in name}
    shipped = {f'share/hst_drive/{path.relative_to(ROOT).as_posix()}'
               for folder in ('config', 'launch') for path in (ROOT / folder).rglob('*')
               if path.is_file() and '__pycache__' not in path.parts}
    assert data == shipped | {'share/hst_drive/package.xml',
                              'share/ament_index/resource_index/packages/hst_drive'}
    assert 'hst_drive/cli/__init__.py' in names
    assert 'hst_drive/report/assets/page.css' in names
    assert 'hst_drive/py.typed' in names
    assert 'hst_drive/workbench/assets/workbench.html' in names
    assert not [name for name in names if name.startswith('test')]
    for program in PROGRAMS:
        assert f'\n{program} = hst_drive.' in entries.decode()


@pytest.mark.skipif(find_spec('colcon_ros') is None, reason='colcon is not installed')
@pytest.mark.parametrize('option', ['', '--symlink-install'])
def test_colcon(source, tmp_path, option):
    """After sourcing, ros2 run finds all programs, and hst-drive is on the PATH."""
    workspace = source.parents[1]
    bases = f'--build-base {tmp_path}/build --install-base {tmp_path}/install'
    shell(f'colcon --log-base {tmp_path}/log build {bases} {option}', workspace)
    prefix = tmp_path / 'install' / 'hst_drive'
    library = prefix / 'lib' / 'hst_drive'
    assert sorted(path.name for path in library.iterdir()
                  if os.access(path, os.X_OK)) == PROGRAMS
    assert (prefix / 'share/ament_index/resource_index/packages/hst_drive').exists()

    setup = f'. {tmp_path}/install/setup.sh'
    assert shell(f'{setup}; command -v hst-drive', '/') == str(prefix / 'bin' / 'hst-drive')
    assert shell(f'{setup}; hst-drive --version', '/') == f'hst-drive {hst_drive.__version__}'
    config = Path(shell(f"{setup}; python -c '{ASK}'", '/'))
    assert prefix in config.parents or option and tmp_path / 'build' in config.parents
    assert (config / 'fastdds_local.xml').is_file()
