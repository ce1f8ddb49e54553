# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording as the load of a scenario."""
import math
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.load import load_scenario, LoadingUnit, parse_scenario
from hst_drive.load.recorded import Recording
from hst_drive.rig import default_rig
import numpy as np
import pytest

RPM = math.pi / 30.0
UNIT = LoadingUnit.of(default_rig().loading)
TIME = 5.0 + np.arange(1000) / 100.0
CHANNELS = {
    'speed_setpoint': np.where(TIME < 10.0, 80 * RPM, 120 * RPM),
    'pprv_command': np.where(TIME < 8.0, 1.0, 3.0),
    'load_torque': 50.0 + 10.0 * (TIME - 5.0),
    'oil_temperature': 320.0 + 0.5 * (TIME - 5.0),
    'motor_speed': np.full(1000, 79 * RPM)}
PLAIN = {'title': 'again', 'start': 'recorded', 'speed_setpoint': {'kind': 'recorded'},
         'load': {'kind': 'recorded'}, 'oil_temperature': {'kind': 'recorded'}}


def played(content=PLAIN, drop=(), **other):
    """Return the scenario of a recording with channels left out or replaced."""
    channels = {name: values for name, values in {**CHANNELS, **other}.items()
                if name not in drop}
    return parse_scenario(content, UNIT, 'mine.yaml', None,
                          lambda file, mapping: Recording('log.csv', TIME, channels))


def test_it_asks_what_the_recording_asked():
    scenario = played()
    assert scenario.duration == pytest.approx(10.0)
    assert scenario.start == 'steady'
    assert [scenario.speed_setpoint(t) / RPM for t in (0.0, 4.99, 5.01, 20.0)] == pytest.approx(
        [80, 80, 120, 120])
    assert [scenario.load.pprv_command(t) for t in (0.0, 2.99, 3.01, 9.0)] == [1, 1, 3, 3]
    # the mean of a straight line is the line, but at its ends
    assert scenario.oil_temperature(5.0) == pytest.approx(322.5)
    assert scenario.notes[0] == 'the load is pprv_command of log.csv'


def test_a_torque_becomes_the_command_that_gives_it():
    """The loading unit's own equation, forward, gives the recorded torque back."""
    for scenario in (played(drop=['pprv_command']),
                     played({**PLAIN, 'load': {'kind': 'recorded', 'channel': 'load_torque'}})):
        for t in (1.0, 4.0, 7.0):
            command, speed = scenario.load.pprv_command(t), scenario.speed_setpoint(t)
            assert UNIT.torque_of_command(command, speed) == pytest.approx(50.0 + 10.0 * t)


def test_a_part_of_it_and_a_drive_at_rest():
    scenario = played({**PLAIN, 'recording': {'time_range_s': [7, 9]}},
                      motor_speed=np.zeros(1000))
    assert scenario.duration == pytest.approx(2.01) and scenario.start == 'rest'
    assert [scenario.load.pprv_command(t) for t in (0.99, 1.01)] == [1, 3]


def test_what_is_missing_is_bridged_and_told():
    torn = np.where((TIME > 6.995) & (TIME < 9.495), np.nan, CHANNELS['pprv_command'])
    scenario = played(pprv_command=torn)
    assert [scenario.load.pprv_command(t) for t in (3.5, 4.51)] == [1, 3]
    assert any('250 of 1000 samples missing, held for up to 2.51 s' in note
               for note in scenario.notes)


def test_what_the_recording_lacks_otherwise():
    content = {**PLAIN, 'speed_setpoint': {'kind': 'recorded', 'otherwise_speed_rpm': 90}}
    for scenario in (played(content, drop=['speed_setpoint']),
                     played(content, speed_setpoint=np.zeros(1000))):
        assert scenario.speed_setpoint(3.0) == pytest.approx(90 * RPM)
        assert any('90 rpm throughout' in note for note in scenario.notes)


@pytest.mark.parametrize('content, drop, what', (
    (PLAIN, ['speed_setpoint'], 'log.csv: speed_setpoint is not in it; name .* --channels'),
    (PLAIN, ['pprv_command', 'load_torque'], 'log.csv: no load in it: expected the channel'),
    ({**PLAIN, 'load': {'kind': 'recorded', 'channel': 'motor_torque'}}, [], 'motor_torque'),
    ({**PLAIN, 'load': {'kind': 'recorded', 'chanel': 'load_torque'}}, [], "mean 'channel'"),
    ({**PLAIN, 'oil_temperature': {'kind': 'recorded', 'K': 3}}, [], 'oil_temperature.K'),
    ({**PLAIN, 'recording': {'time_range_s': [90, 99]}}, [], 'runs from 5 to 14.99 s'),
    ({**PLAIN, 'recording': {'fiel': 'a'}}, [], "mean 'file'")))
def test_slips_are_one_line(content, drop, what):
    with pytest.raises(InputError, match=what) as caught:
        played(content, drop)
    assert '\n' not in str(caught.value)


def test_files_and_maps_that_would_not_count(tmp_path):
    with pytest.raises(InputError, match="'recording.file' is missing"):
        load_scenario('recorded', read=lambda *_: None)
    with pytest.raises(InputError, match='--channels map.yaml would not count'):
        load_scenario('paper_step', channels='map.yaml')
    with pytest.raises(InputError, match='cannot be read here'):
        load_scenario('recorded')
    asked = []

    def read(path: Path, mapping):
        asked.append((path, mapping))
        return Recording('log.csv', TIME, CHANNELS)

    (tmp_path / 'mine.yaml').write_text(
        'title: a\nspeed_setpoint: {speed_rpm: 90}\nload: {kind: recorded}\n'
        'recording: {file: a.csv, channels: map.yaml}\n')
    load_scenario(tmp_path / 'mine.yaml', read=read)
    load_scenario(tmp_path / 'mine.yaml', log='b.csv', channels='other.yaml', read=read)
    assert asked == [(tmp_path / 'a.csv', tmp_path / 'map.yaml'),
                     (Path('b.csv'), Path('other.yaml'))]


def test_a_drive_that_turns_backwards_has_a_set_point():
    content = {**PLAIN, 'start': 'rest', 'load': {'kind': 'recorded', 'channel': 'load_torque'}}
    backwards = {**CHANNELS, 'speed_setpoint': -CHANNELS['speed_setpoint']}
    scenario = parse_scenario(content, None, 'mine.yaml', None,
                              lambda file, mapping: Recording('log.csv', TIME, backwards))
    assert scenario.speed_setpoint(0.0) == pytest.approx(-80 * RPM)
