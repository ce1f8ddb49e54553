# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings and foreign bags for the tests of the bag package."""
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.writer import BagWriter
from hst_drive.measure.run import Run
import numpy as np

NAMES = ('pump_command', 'speed_setpoint', 'oil_temperature', 'pump_outlet_pressure',
         'motor_inlet_flow', 'motor_speed', 'load_torque')


def make_run(rows=400, seed=1, names=NAMES):
    """Return a recording of smooth random signals of plausible size at 100 Hz."""
    random = np.random.default_rng(seed)
    size = {'pump_outlet_pressure': 1e7, 'motor_inlet_flow': 3e-4, 'oil_temperature': 320.0}
    return Run('made', np.arange(rows) * 0.01, {
        name: size.get(name, 10.0) * (1.0 + 0.1 * random.standard_normal(rows).cumsum()
                                      / np.sqrt(rows)) for name in names})


def write_bag(folder, topics, **options):
    """
    Write a bag from {topic: (type, [(log_time, bytes), ...])} with the standard definitions.

    A type that is a pair holds its own definition text.
    """
    with BagWriter(folder, **options) as bag:
        for name, (kind, _) in topics.items():
            kind, text = kind if isinstance(kind, tuple) else (kind, find_definition(kind))
            bag.add_topic(name, kind, text)
        rows = [(at, name, data) for name, (_, messages) in topics.items()
                for at, data in messages]
        for at, name, data in sorted(rows):
            bag.write(name, data, at)
    return folder
