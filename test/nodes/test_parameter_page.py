# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of parameters is that of the nodes; ``python -m`` this file writes it anew."""
from importlib import import_module
from pathlib import Path

import pytest

pytest.importorskip('rclpy')
PAGE = Path(__file__).parents[2] / 'docs' / 'parameters.md'
NODES = {'controller': 'Controller', 'estimator': 'Estimator', 'recorder': 'Recorder',
         'plant': 'Plant', 'load_profile': 'LoadProfile', 'manager': 'Manager'}


def generated() -> str:
    """Return the part of the page that comes from the declarations."""
    from hst_drive.nodes.parameters import COMMON, markdown
    classes = {name: getattr(import_module(f'hst_drive.nodes.{name}'), title)
               for name, title in NODES.items()}
    return markdown({'all but manager': COMMON,
                     **{name: entry.parameters for name, entry in classes.items()}})


def head() -> str:
    """Return the part of the page that is written by hand."""
    return PAGE.read_text(encoding='utf-8').partition('\n## ')[0] + '\n'


def test_the_page_is_that_of_the_nodes():
    assert PAGE.read_text(encoding='utf-8') == head() + generated()


if __name__ == '__main__':
    PAGE.write_text(head() + generated(), encoding='utf-8')
