# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of the ladder: marks where the numbers are, and nothing lies over anything."""
import sys

from hst_drive import cli
from hst_drive.diagnose.result import Step
from hst_drive.errors import InputError
from hst_drive.report.drawing import save
from hst_drive.report.ladder_figure import ladder_figure
import numpy as np
import pytest

SIGNALS = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
STEPS = tuple(Step(added, dict.fromkeys(SIGNALS, value), dict.fromkeys(SIGNALS, 1.2 * value))
              for added, value in (('datasheet', 30.0), ('calibrated unit', 8.0),
                                   ('leakage_temperature', 2.0), ('stribeck_friction', 0.9)))


def test_it_shows_every_step(tmp_path, monkeypatch):
    backend = pytest.importorskip('matplotlib.backends.backend_agg')
    kept = []
    monkeypatch.setattr('hst_drive.report.ladder_figure.save',
                        lambda figure, path: kept.append(figure) or save(figure, path))
    ladder_figure(STEPS, tmp_path / 'a.png', 'a title')
    axis, = kept[0].axes
    lines = [line for line in axis.get_lines() if len(line.get_xdata()) == len(STEPS)]
    assert len(lines) == 2 * len(SIGNALS)
    for line in lines:
        share = 1.0 if line.get_linestyle() == ':' else 1.2
        assert np.allclose(line.get_ydata(), share * np.array([30.0, 8.0, 2.0, 0.9]))
    assert axis.get_yscale() == 'log' and '[1]' in axis.get_ylabel()
    # No label of a step lies over another one, nor over the legend.
    renderer = backend.FigureCanvasAgg(kept[0]).get_renderer()
    boxes = [label.get_window_extent(renderer) for label in axis.get_xticklabels()]
    boxes.append(axis.get_legend().get_window_extent(renderer))
    for place, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[place + 1:])
    assert (tmp_path / 'a.png').stat().st_size > 10_000


def test_without_matplotlib_nothing_is_diagnosed(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    assert cli.main(['diagnose', 'none.csv', '--plot', str(tmp_path / 'a.png')]) == 2
    assert 'matplotlib is not installed' in capsys.readouterr().err
    assert cli.main(['diagnose', 'none.csv', '--plot', str(tmp_path / 'a.doc')]) == 2
    assert 'expected a name that ends in .png' in capsys.readouterr().err


def test_a_file_that_cannot_be_written(tmp_path):
    pytest.importorskip('matplotlib')
    with pytest.raises(InputError, match='cannot be written'):
        ladder_figure(STEPS, tmp_path / 'none' / 'a.png')
