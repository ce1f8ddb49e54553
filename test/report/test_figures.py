# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures: drawn into files, and what stops them said in one line."""
import sys

from hst_drive.errors import InputError
from hst_drive.measure.compare import compare
from hst_drive.model import Drive
from hst_drive.report.figures import comparison_figure
from hst_drive.rig import default_rig
import numpy as np
import pytest

from ..measure.synthetic import record


@pytest.fixture(scope='module')
def log():
    """Return one compared log with a gap."""
    run = record(1, duration=2.0, settled=True)
    run.channels['motor_speed'][50:60] = np.nan
    return compare(Drive(default_rig()), [run]).logs[0]


def test_a_png_with_all_signals(log, tmp_path):
    image = pytest.importorskip('matplotlib.image')
    comparison_figure(log, tmp_path / 'a.png')
    pixels = image.imread(tmp_path / 'a.png')
    assert pixels.shape[0] > 700 and pixels.shape[1] > 900
    # Measured, model and residual are there: black, vermilion and blue.
    for colour in ((0, 0, 0), (0xD5, 0x5E, 0), (0, 0x72, 0xB2)):
        distance = np.abs(pixels[..., :3] * 255 - colour).max(axis=2)
        assert (distance < 8).sum() > 200


@pytest.mark.parametrize('name', ['a.xyz', 'none/a.png'])
def test_files_that_cannot_be_written(log, tmp_path, name):
    pytest.importorskip('matplotlib')
    with pytest.raises(InputError, match='cannot be written .*; use a name ending') as said:
        comparison_figure(log, tmp_path / name)
    assert '\n' not in str(said.value)


def test_without_matplotlib(log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    with pytest.raises(InputError, match="matplotlib is not installed; plots need it: 'pip inst"):
        comparison_figure(log, tmp_path / 'a.png')


def test_every_axis_says_its_unit(log, tmp_path, monkeypatch):
    pytest.importorskip('matplotlib')
    figures = []
    monkeypatch.setattr('hst_drive.report.figures.save', lambda figure, _: figures.append(figure))
    comparison_figure(log, tmp_path / 'a.png')
    labels = [axis.get_ylabel() for axis in figures[0].axes]
    assert len(labels) == 2 * len(log.signals) + 1
    assert labels.pop() == 'pump command\n[V]'
    for top, bottom in zip(labels[::2], labels[1::2]):
        unit = top.partition('\n')[2]
        assert unit.startswith('[') and bottom == f'error\n{unit}'
    assert figures[0].axes[-1].get_xlabel() == 'time [s]'
