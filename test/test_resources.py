# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Shipped files are found in every kind of installation."""
from pathlib import Path

from hst_drive import resources
from hst_drive.errors import InputError
import pytest


def test_share_finds_a_shipped_file():
    """The path is absolute and the file is there."""
    path = resources.share('config', 'fastdds_local.xml')
    assert path.is_absolute() and path.is_file()
    assert resources.share('config/fastdds_local.xml') == path


@pytest.mark.parametrize('package, root', [
    ('src/hst_drive', 'src'),
    ('venv/lib/python3.12/site-packages/hst_drive', 'venv/share/hst_drive'),
    ('ws/install/hst_drive/lib/python3.12/site-packages/hst_drive',
     'ws/install/hst_drive/share/hst_drive'),
    ('usr/local/lib/python3.12/dist-packages/hst_drive', 'usr/local/share/hst_drive'),
    ('target/hst_drive', 'target/share/hst_drive'),
])
def test_beside_the_code(tmp_path, package, root):
    """Source tree, pip, colcon, Debian's python and pip --target."""
    (tmp_path / package).mkdir(parents=True)
    (tmp_path / root / 'config').mkdir(parents=True)
    (tmp_path / root / 'package.xml').touch()
    assert resources._root(tmp_path / package) == tmp_path / root


def test_ament_index_when_the_code_is_elsewhere(tmp_path, monkeypatch):
    """A symlinked colcon build runs the code of the build folder."""
    pytest.importorskip('ament_index_python')
    marker = tmp_path / 'install/share/ament_index/resource_index/packages/hst_drive'
    marker.parent.mkdir(parents=True)
    marker.touch()
    (tmp_path / 'install/share/hst_drive').mkdir()
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'install'))
    assert resources._root(tmp_path / 'build/hst_drive/hst_drive') == Path(
        tmp_path / 'install/share/hst_drive')


def test_nothing_shipped(tmp_path, monkeypatch):
    """One line says what is wrong."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    with pytest.raises(InputError, match='install hst_drive again'):
        resources._root(tmp_path / 'hst_drive')
