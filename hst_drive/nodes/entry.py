# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes as programs: one line, no traceback, where the packages that they need are missing."""
from __future__ import annotations

from functools import partial
from importlib import import_module
import sys

_OWN = 'hst_drive'


def run(name: str) -> int:
    """
    Run a node.

    Returns
    -------
    int
        As of ``hst_drive.nodes.base.main``, also if told to stop (SIGINT) before that has begun;
        1 if a package is missing.

    """
    try:
        module = import_module(f'hst_drive.nodes.{name}')
    except ImportError as error:
        missing = (error.name or '').partition('.')[0]
        if missing in ('', _OWN):
            raise
        print(f"{name}: the Python package '{missing}' cannot be imported ({error}); source ROS 2 "
              "Jazzy (. /opt/ros/jazzy/setup.sh) and let 'rosdep install --from-paths src "
              "--ignore-src' bring what is missing", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 0
    return module.main()


plant = partial(run, 'plant')
controller = partial(run, 'controller')
estimator = partial(run, 'estimator')
load_profile = partial(run, 'load_profile')
recorder = partial(run, 'recorder')
manager = partial(run, 'manager')
