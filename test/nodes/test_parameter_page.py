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


def declared() -> dict[str, tuple]:
    """Return the declarations by node."""
    from hst_drive.nodes.parameters import COMMON
    classes = {name: getattr(import_module(f'hst_drive.nodes.{name}'), title)
               for name, title in NODES.items()}
    return {'all but manager': COMMON,
            **{name: entry.parameters for name, entry in classes.items()}}


def generated() -> str:
    """Return the part of the page that comes from the declarations."""
    from hst_drive.nodes.parameters import markdown
    return markdown(declared())


def head() -> str:
    """Return the part of the page that is written by hand."""
    return PAGE.read_text(encoding='utf-8').partition('\n## ')[0] + '\n'


def test_the_page_is_that_of_the_nodes():
    assert PAGE.read_text(encoding='utf-8') == head() + generated()


def test_describe_says_of_every_text_what_it_may_be():
    """As of a number its range: the words that there are, or the form."""
    shown = {(name, entry.name): entry.descriptor().additional_constraints
             for name, entries in declared().items() for entry in entries
             if isinstance(entry.default, (str, list))}
    assert [key for key, text in shown.items() if not text] == []
    assert shown['controller', 'mode'] == 'one of: closed_loop, open_loop'
    assert shown['controller', 'antiwindup_strategy'] == (
        'one of: conditional_integration, back_calculation, none')
    assert 'layered_ground' in shown['load_profile', 'scenario']


if __name__ == '__main__':
    PAGE.write_text(head() + generated(), encoding='utf-8')
