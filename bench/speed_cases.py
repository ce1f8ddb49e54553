# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``bench.speed`` measures: the work itself."""
from __future__ import annotations

from collections.abc import Callable, Sequence
import os
from pathlib import Path
import subprocess
import sys
import tempfile
from test.measure.synthetic import record
from test.model.reference import Reference
import time

from bench.watch import drilling
from hst_drive.bag import read_log, write_csv, write_run
from hst_drive.diagnose.decide import diagnose
from hst_drive.effects import catalogue
from hst_drive.identify.part import campaign_of
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.resources import share
from hst_drive.rig import default_rig, load_rig
import numpy as np
from scipy.integrate import solve_ivp

RIG = default_rig()
_COLUMNS = ('pump_displacement', 'pump_outlet_pressure', 'motor_speed', 'pprv_pressure')
_SIZE = np.array([1e-7, 1e5, 1.0, 1e5])     # of the states, for SciPy's absolute tolerances
_LEAK, _RUB = {'motor_leakage': {}}, {'bearing_friction': {}}
DIAGNOSES = (
    (20.0, _LEAK, ()), (40.0, _LEAK, ()), (60.0, _LEAK, ()), (60.0, {}, ()),
    (60.0, {**_LEAK, **_RUB, 'pump_command_offset': {}}, ()),
    (60.0, _LEAK, ('motor_inlet_flow', 'oil_temperature')))


def clocked(work: Callable[[], object]) -> tuple[float, float]:
    """Return CPU and wall seconds of one call."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall


# The peak of a process counts that of whoever started it; its memory's own does not.
_CALL = """
import sys
from hst_drive.cli import main
code = main(sys.argv[2:])
peak = [line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')]
open(sys.argv[1], 'w').write(peak[0])
sys.exit(code)
"""


def called(arguments: Sequence[str]) -> tuple[float, float, float]:
    """Return CPU and wall seconds, and the peak of memory (MB), of a command line."""
    with tempfile.NamedTemporaryFile() as peak:
        before, began = os.times(), time.perf_counter()
        subprocess.run([sys.executable, '-c', _CALL, peak.name, *map(str, arguments)], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wall, after = time.perf_counter() - began, os.times()
        cpu = (after.children_user + after.children_system
               - before.children_user - before.children_system)
        return cpu, wall, float(peak.read()) / 1024


class Simulation:
    """100 s at 1 ms: both commands step every three seconds, away from corners."""

    def __init__(self, seconds: float = 100.0):
        random = np.random.default_rng(2)
        self.time = np.arange(round(seconds * 1000) + 1) / 1000
        part = (self.time / 3.0).astype(int)
        self.pump = random.uniform(5.0, 6.4, part.max() + 1)[part]
        self.pprv = random.uniform(1.8, 4.2, part.max() + 1)[part]
        self.drives = {share: Drive(RIG, dict.fromkeys(self._names(share), {}))
                       for share in (0.25, 0.5, 1.0)}
        self.drive = Drive(RIG)
        self.start = self.drive.initial_state(pump_command=self.pump[0], pprv_command=self.pprv[0],
                                              speed=10.0)
        self._exact: np.ndarray | None = None

    @property
    def count(self) -> int:
        """How many effects there are."""
        return len(catalogue())

    @staticmethod
    def _names(share: float) -> list[str]:
        names = sorted(catalogue())
        return names[:round(share * len(names))]

    def _run(self, drive: Drive, rows: slice = slice(None)) -> dict[str, np.ndarray]:
        return drive.simulate(self.time[rows], {
            'pump_command': self.pump[rows], 'pprv_command': self.pprv[rows]}, self.start.copy())

    def baseline(self) -> dict[str, np.ndarray]:
        """Simulate without an effect."""
        return self._run(self.drive)

    def every_effect(self) -> None:
        """Simulate with all effects at their typical sizes."""
        self._run(self.drives[1.0])

    def effects(self, share: float) -> None:
        """Simulate with a share of the effects."""
        self._run(self.drives[share])

    def longer(self, factor: int) -> None:
        """Simulate so many times in a row."""
        count = len(self.time) * factor
        self.drive.simulate(np.arange(count) / 1000, {
            'pump_command': np.tile(self.pump, factor),
            'pprv_command': np.tile(self.pprv, factor)}, self.start.copy())

    def plain(self) -> None:
        """Simulate 10 s without the compiler."""
        self._run(Drive(RIG, compiled=False), slice(0, 10_001))

    def ours(self) -> dict[str, np.ndarray]:
        """Return the states of the baseline, as one array under 'all'."""
        found = self.baseline()
        return {'all': np.column_stack([found[name] for name in _COLUMNS])}

    def error(self, states: np.ndarray) -> float:
        """Return the largest error over the signals' ranges, against a tight Radau."""
        if self._exact is None:
            self._exact = self.scipy('Radau', 1e-9)[0]
        return float(np.max(np.abs(states - self._exact) / np.ptp(self._exact, axis=0)))

    def scipy(self, method: str, tolerance: float) -> tuple[np.ndarray, int]:
        """Return the states by ``solve_ivp`` and the count of evaluations."""
        reference, out, calls = Reference(), np.empty((len(self.time), 4)), 0
        out[0] = self.start[:4]
        steps = np.flatnonzero(np.diff(self.pump)) + 1
        for first, last in zip([0, *steps], [*steps, len(self.time) - 1]):
            u, v, rows = self.pump[first], self.pprv[first], slice(first, last + 1)
            found = solve_ivp(lambda t, x, u=u, v=v: reference.rates(x, u, v),
                              (self.time[first], self.time[last]), out[first], method,
                              self.time[rows], rtol=tolerance, atol=tolerance * _SIZE)
            out[rows], calls = found.y.T, calls + found.nfev
        return out, calls

    def as_accurate(self, method: str, error: float) -> tuple[float, float, int]:
        """Return the loosest tolerance that meets an error, the error and the evaluations."""
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
            states, calls = self.scipy(method, tolerance)
            reached = self.error(states)
            if reached <= error:
                break
        return tolerance, reached, calls


class Closed:
    """100 s at 1 ms of the shipped closed circuit: stroke and load step every three seconds."""

    def __init__(self) -> None:
        random, self.time = np.random.default_rng(2), np.arange(100_001) / 1000
        part = (self.time / 3.0).astype(int)
        self.inputs = {'pump_command': random.uniform(3.0, 9.0, part.max() + 1)[part],
                       'opposing_torque': random.uniform(2000.0, 7000.0, part.max() + 1)[part]}
        self.model = CircuitModel(load_rig(share('config', 'rig', 'closed_rig.yaml')))

    def simulate(self) -> dict[str, np.ndarray]:
        """Simulate from rest."""
        return self.model.run(self.time, self.inputs, {})

    def error(self) -> float:
        """Return the largest error over the states' ranges, against steps of 0.01 ms."""
        found, exact = (self.model.run(self.time[:20_001], {
            name: values[:20_001] for name, values in self.inputs.items()}, {}, max_step=step)
            for step in (None, 1e-5))
        return max(float(np.max(np.abs(found[name] - exact[name])) / np.ptp(exact[name]))
                   for name in (entry.name for entry in self.model.circuit.states))


def campaign(seconds: float, effects: dict, without: Sequence[str]) -> list[Run]:
    """Return four logs of a drive."""
    return [record(seed, duration=seconds, effects=effects, leave_out=without)
            for seed in range(70, 74)]


def candidates(logs: list[Run]) -> int:
    """Return how many effects a diagnosis tries."""
    return len(campaign_of(RIG, logs[:3], logs[3:]).candidates())


def diagnosed(logs: list[Run]) -> None:
    """Diagnose, the last log held out."""
    diagnose(RIG, logs[:3], logs[3:])


def long_log(path: Path, minutes: float) -> Path:
    """Write a log of drilling at 100 Hz: a unit off its datasheet, changing rock."""
    pieces = list(drilling(RIG, 7, minutes))
    channels = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    write_csv(path, Run('long', np.arange(len(channels['motor_speed'])) / 100, channels))
    return path


class Bags:
    """A bag of 60 s at 100 Hz with the topics of a drive."""

    def __init__(self, folder: Path):
        self.run, self.folder, self.turn = record(5, duration=60.0), folder, 0
        self.bag = folder / 'bag'
        write_run(self.bag, self.run)
        self.raw = list(self._raw())
        self.messages = len(self.raw)

    def _raw(self):
        from rosbags.rosbag2 import Reader

        with Reader(self.bag) as reader:
            for connection, at, data in reader.messages():
                yield connection.topic, connection.msgtype, at, bytes(data)

    def _new(self) -> Path:
        self.turn += 1
        return self.folder / f'bag_{self.turn}'

    def write(self) -> None:
        """Write the recording."""
        write_run(self._new(), self.run)

    def read(self) -> None:
        """Read the recording."""
        read_log(self.bag)

    def write_with_rosbags(self) -> None:
        """Write the same messages, serialising each from its object."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import get_typestore, Stores

        store = get_typestore(Stores.ROS2_JAZZY)
        objects = getattr(self, '_objects', None)
        if objects is None:
            objects = self._objects = [store.deserialize_cdr(data, kind)
                                       for _, kind, _, data in self.raw]
        with Writer(self._new(), version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            known = {}
            for (topic, kind, at, _), message in zip(self.raw, objects):
                if topic not in known:
                    known[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(known[topic], at, store.serialize_cdr(message, kind))

    def read_with_rosbags(self) -> None:
        """Read the same messages as objects."""
        from rosbags.highlevel import AnyReader

        with AnyReader([self.bag]) as reader:
            for connection, _, data in reader.messages():
                reader.deserialize(data, connection.msgtype)
