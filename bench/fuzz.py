# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Spoilt files for every reader: each is read, or refused in one line, in time.

    python -m bench.fuzz --count 20000                # of each reader
    python -m bench.fuzz --count 200000 --reader mcap --seed 3

A failure is anything but ``InputError``: another exception, more than ten CPU seconds, an error
text of several lines, or a file that was left behind. Hypothesis then shows the smallest case.
"""
from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from copy import deepcopy
from itertools import count as numbers
from pathlib import Path
import signal
import sqlite3
import sys
from tempfile import TemporaryDirectory
import time
import warnings

from hst_drive.bag import ChannelMap, cut_log, read_log, recover, write_csv, write_run
from hst_drive.bag.bench_table import read_points
from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.channels import load_channel_map, parse_channel_map
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.diagnostic_values import read_values
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.load import load_scenario
from hst_drive.load.drilling_log import parse_drilling_log
from hst_drive.load.scenario import parse_scenario
from hst_drive.measure.run import Run
from hst_drive.nodes.settings import parse_effects
from hst_drive.resources import share
from hst_drive.rig import default_rig, load_rig
from hst_drive.rig.load import parse_rig
from hypothesis import given, HealthCheck, Phase, seed, settings, strategies as st
import numpy as np
import yaml

PATIENCE = 10
HEAD = f'{"reader":18}{"cases":>9}{"read":>9}{"refused":>9}{"slowest [s]":>13}'
TOKENS = [b'nan', b'-inf', b'1e400', b'-', b'', b'\0', b',', b';', b'\t', b'\n', b'"', b"'",
          b'[V]', b'[', b']', b'{', b'}', b': ', b'- ', b'#', b'&a ', b'*a',
          b'!!python/object:os.system ',
          b'<<: *a', b'time[s]', b'0x10', b'1_000', b'9' * 400, b'\xff\xfe', b'\xef\xbb\xbf',
          b'\xc3', b'true', b'null', b'../../x', b'\r', b'1,5', b'--- ']
EDIT = st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), st.one_of(
    st.sampled_from(TOKENS), st.binary(max_size=8)))
VALUE = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=6),
              st.sampled_from(['V', 'bar', '1 bar', 'psi', 'ramps', '2024-01-01'])),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(
        st.one_of(st.text(max_size=6), st.integers()), inner, max_size=3)), max_leaves=6)


def spoil(data: bytes, edits) -> bytes:
    """Return the bytes with parts replaced: (place 0 to 1, length, what comes instead)."""
    for place, length, new in edits:
        at = int(place * len(data))
        data = data[:at] + new + data[at + length:]
    return data


def graft(content: dict, edits) -> dict:
    """Return a mapping with branches replaced: (numbers that lead to the branch, new value)."""
    content = deepcopy(content)
    for steps, value in edits:
        place = content
        for step in steps[:-1]:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys or not isinstance(place[keys[step % len(keys)]], (dict, list)):
                break
            place = place[keys[step % len(keys)]]
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if keys:
            place[keys[steps[-1] % len(keys)]] = value
    return content


class Cases:
    """The readers: for each a strategy, and what to do with a case."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._number = numbers()
        self.readers: dict[str, tuple[st.SearchStrategy, Callable]] = {}
        time_, values = np.arange(40) * 0.01, np.linspace(0.0, 1.0, 40)
        run = Run('log', time_, {name: values + place for place, name in enumerate(
            ('motor_speed', 'pump_command', 'pump_outlet_pressure', 'oil_temperature'))})
        write_csv(folder / 'log.csv', run)
        write_run(folder / 'bag', run)
        csv = (folder / 'log.csv').read_bytes()
        mcap = next((folder / 'bag').glob('*.mcap')).read_bytes()
        metadata = (folder / 'bag' / 'metadata.yaml').read_bytes()
        scenarios = [path.read_bytes() for path in sorted(share('config/scenarios').glob('*.yaml'))
                     if 'real_log' not in path.name]
        rig = share('config/rig/test_rig.yaml').read_bytes()
        channel_map = share('config/channels_example.yaml').read_bytes()
        table = ('motor_displacement[cc/rev],oil_temperature[degC],load_torque[N.m],'
                 'motor_speed[rpm],supply_pressure[bar],supply_flow[L/min]\n'
                 + ''.join(f'195,50,{10 * i},100,{5 * i},{19.5 + i}\n' for i in range(9))).encode()
        self._bytes('csv', '.csv', [csv, csv.replace(b',', b';')], read_log)
        self._bytes('csv_with_map', '.csv', [csv], lambda path: read_log(path, parse_channel_map(
            {'channels': {'load_torque': {'from': 'motor_speed', 'unit': 'N.m'}}})))
        self._bytes('mcap', '.mcap', [mcap], read_log)
        self._bytes('sqlite', '.db3', [self._sqlite(folder / 'bag.db3')], read_log)
        for name, suffix, whole in (('csv', '.csv', csv), ('bag', '.mcap', mcap)):
            self._bytes(f'{name}_sections', suffix, [whole], lambda path: list(
                cut_log(path, ChannelMap(), 0.15, 0.05, 0.02)))
        self._bytes('recover', '.mcap', [mcap, mcap[:-900]], self._recover)
        self._bytes('metadata', '.yaml', [metadata], self._with_metadata(mcap))
        self._bytes('rig_text', '.yaml', [rig], load_rig)
        self._bytes('scenario_text', '.yaml', scenarios, load_scenario)
        self._bytes('channel_map_text', '.yaml', [channel_map], load_channel_map)
        self._bytes('bench_table', '.csv', [table], read_points)
        self._mapping('rig', [rig], parse_rig)
        unit = load_scenario('paper_step').load.unit
        self._mapping('scenario', scenarios, lambda content: parse_scenario(content, unit))
        self._mapping('channel_map', [channel_map], parse_channel_map)
        self.readers['drilling_log'] = (st.builds(
            spoil, st.just(b'time[s],torque[kN.m],rpm[rpm]\n' + b'1,2,3\n' * 12), EDITS),
            lambda data: parse_drilling_log(data.decode('latin-1'), 'log'))
        self.readers['effects'] = (st.lists(st.one_of(st.text(max_size=30), st.builds(
            'motor_leakage.{}={}{}'.format, st.sampled_from(['conductance', 'x']), st.floats(),
            st.sampled_from(['', '[L/min/bar]', '[V]', '[']))), max_size=3), parse_effects)
        self._messages()

    def _bytes(self, name: str, suffix: str, seeds: list[bytes], read: Callable) -> None:
        def one(data: bytes) -> None:
            path = self.folder / f'case{next(self._number)}{suffix}'
            path.write_bytes(data)
            before = set(self.folder.iterdir())
            try:
                read(path)
            finally:
                left = set(self.folder.iterdir()) - before
                path.unlink()
                assert not left, f'left behind: {left}'

        self.readers[name] = st.builds(spoil, st.sampled_from(seeds), EDITS), one

    def _mapping(self, name: str, seeds: list[bytes], parse: Callable) -> None:
        contents = [yaml.safe_load(text) for text in seeds]
        branch = st.tuples(st.lists(st.integers(0, 30), min_size=1, max_size=5), VALUE)
        self.readers[name] = st.builds(graft, st.sampled_from(contents), st.lists(
            branch, min_size=1, max_size=3)), parse

    def _messages(self) -> None:
        def codec_of(kind: str, value: dict) -> tuple[Codec, bytes]:
            codec = Codec(kind, find_definition(kind))
            return codec, codec.encode(value)

        joint, joints = codec_of('sensor_msgs/msg/JointState', {
            'name': ['fan', 'drill'], 'position': [1.0, 2.0], 'velocity': [1.0, 2.0]})
        _, told = codec_of('diagnostic_msgs/msg/DiagnosticArray', {'status': [
            {'name': 'a', 'values': [{'key': 'k', 'value': '1.5'}]}]})

        def read(case: tuple[bytes, bytes]) -> None:
            try:
                joint.extract([joints, case[0]], ['velocity[drill]', 'effort[0]'])
                joint.layout(case[0], ['velocity[0]'])
                read_values([told, case[1]], ['status[a].values[k]'])
            except MalformedError as error:
                raise InputError(str(error)) from None

        self.readers['messages'] = st.tuples(
            st.builds(spoil, st.just(joints), EDITS), st.builds(spoil, st.just(told), EDITS)), read

    def _with_metadata(self, mcap: bytes) -> Callable:
        def read(path: Path) -> None:
            with TemporaryDirectory(dir=self.folder) as folder:
                (Path(folder) / 'bag_0.mcap').write_bytes(mcap)
                path.rename(Path(folder) / 'metadata.yaml')
                try:
                    read_log(folder)
                finally:
                    (Path(folder) / 'metadata.yaml').rename(path)

        return read

    def _recover(self, path: Path) -> None:
        with TemporaryDirectory(dir=self.folder) as folder:
            target = Path(folder) / 'saved'
            try:
                recover(path, target)
            except InputError:
                assert not target.exists(), 'a bag that is not whole'
                raise
            assert (target / 'metadata.yaml').is_file()

    @staticmethod
    def _sqlite(path: Path) -> bytes:
        kind = 'std_msgs/msg/Float64'
        data = Codec('sensor_msgs/msg/FluidPressure', find_definition(
            'sensor_msgs/msg/FluidPressure')).encode({'fluid_pressure': 2e5})
        with sqlite3.connect(path) as base:
            base.execute('CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, '
                         'serialization_format TEXT, offered_qos_profiles TEXT)')
            base.execute('CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, '
                         'timestamp INTEGER, data BLOB)')
            base.execute("INSERT INTO topics VALUES (1, '/pump_outlet_pressure', "
                         "'sensor_msgs/msg/FluidPressure', 'cdr', '')")
            base.execute('INSERT INTO topics VALUES (2, ?, ?, ?, ?)', ('/x', kind, 'cdr', ''))
            base.executemany('INSERT INTO messages VALUES (?, 1, ?, ?)', [
                (i, i * 10**7, data) for i in range(1, 41)])
        base.close()
        found = path.read_bytes()
        path.unlink()
        return found


EDITS = st.lists(EDIT, min_size=1, max_size=3)


def checker(cases: Cases, name: str, count: int, start: int = 0) -> tuple[
        Callable, Counter, list[float]]:
    """Return a test of so many cases, what becomes of them, and the slowest one's time, s."""
    strategy, read = cases.readers[name]
    seen: Counter = Counter()
    slowest = [0.0]

    def late(*_: object) -> None:
        raise AssertionError(f'took more than {PATIENCE} s of CPU time')

    @seed(start)
    @settings(max_examples=count, deadline=None, database=None, derandomize=False,
              suppress_health_check=list(HealthCheck), phases=(Phase.generate, Phase.shrink))
    @given(strategy)
    def run(case) -> None:
        # CPU time: on a machine that others keep busy nothing hangs for that.
        began = time.process_time()
        before = signal.signal(signal.SIGPROF, late)
        signal.setitimer(signal.ITIMER_PROF, PATIENCE)
        seen['cases'] += 1
        try:
            read(case)
            seen['read'] += 1
        except InputError as error:
            seen['refused'] += 1
            assert str(error).strip() and len(str(error).splitlines()) == 1, repr(str(error))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.signal(signal.SIGPROF, before)
            slowest[0] = max(slowest[0], time.process_time() - began)

    return run, seen, slowest


def fuzz(cases: Cases, name: str, count: int, start: int = 0) -> tuple[Counter, float]:
    """Run so many cases of a reader; return what became of them, and the slowest one's time, s."""
    run, seen, slowest = checker(cases, name, count, start)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')     # numpy on overflow
        run()
    return seen, slowest[0]


def row(name: str, seen: Counter, slowest: float) -> str:
    """Return a line of the table under ``HEAD``."""
    return f'{name:18}{seen["cases"]:9}{seen["read"]:9}{seen["refused"]:9}{slowest:13.2f}'


def main() -> int:
    """Fuzz the readers and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=1000, help='cases of each reader')
    parser.add_argument('--reader', action='append', help='only this one (repeatable)')
    parser.add_argument('--seed', type=int, default=0)
    arguments = parser.parse_args()
    default_rig()
    assert CHANNELS
    failed = []
    with TemporaryDirectory(prefix='fuzz_') as folder:
        cases = Cases(Path(folder))
        print(HEAD)
        for name in arguments.reader or cases.readers:
            try:
                seen, slowest = fuzz(cases, name, arguments.count, arguments.seed)
            except Exception as problem:
                failed.append(name)
                notes = '\n  '.join(getattr(problem, '__notes__', ()))
                print(f'{name:18} FAILED {type(problem).__name__}: {problem}\n  {notes}')
                continue
            print(row(name, seen, slowest), flush=True)
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
