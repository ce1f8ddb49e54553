# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The verb compare: its JSON, its inputs good and bad, its picture."""
import json
import subprocess
import sys

from hst_drive import bag
from hst_drive.bag import write_csv
from hst_drive.measure.run import Run
from hst_drive.resources import share
import numpy as np
import pytest
import yaml

from .verbs import calls_of
from ..measure.synthetic import record

command, refused = calls_of('compare')
SUMMARY = {'unit': str, 'samples': int, 'rmse': float, 'bias': float, 'max_abs': float,
           'noise_std': float, 'floor': float, 'noise_ratio': float, 'russell': dict}
REGION = {'signal': str, 'variable': str, 'low': float, 'high': float, 'unit': str,
          'share_of_error': float, 'share_of_time': float}
UNITS = {'pump_outlet_pressure': 'Pa', 'motor_inlet_flow': 'm^3/s', 'motor_speed': 'rad/s',
         'load_torque': 'N.m'}


@pytest.fixture(scope='module')
def run():
    """Return a short recording."""
    return record(3, duration=4.0, settled=True)


@pytest.fixture(scope='module')
def log(run, tmp_path_factory):
    """Return the recording as a CSV file."""
    path = tmp_path_factory.mktemp('logs') / 'run.csv'
    write_csv(path, run)
    return path


def check(content, schema):
    """Check keys and types."""
    for key, kind in schema.items():
        found = content[key]
        assert isinstance(found, (int, float) if kind is float else kind), key
        assert not isinstance(found, bool)


def test_json_is_that_of_the_contract(log, tmp_path, capsys):
    rig = tmp_path / 'other.yaml'
    rig.write_text(share('config', 'rig', 'test_rig.yaml').read_text().replace(
        'displacement_cc_rev: 195', 'displacement_cc_rev: 185'))
    code, out, err = command(capsys, log, '--rig', rig, '--json', tmp_path / 'a.json')
    assert code == 0 and not err
    content = json.loads((tmp_path / 'a.json').read_text())
    assert content['schema'] == 'hst_drive/comparison/1'
    assert content['rig'] == str(rig) and content['logs'] == [str(log)]
    assert {name: entry['unit'] for name, entry in content['signals'].items()} == UNITS
    for entry in content['signals'].values():
        check(entry, SUMMARY)
        check(entry['russell'], dict.fromkeys(('magnitude', 'phase', 'comprehensive'), float))
        assert entry['noise_ratio'] == pytest.approx(entry['rmse'] / entry['floor'])
    assert content['where']
    for region in content['where']:
        check(region, REGION)
        assert region['low'] < region['high'] and 0 <= region['share_of_time'] <= 1
    # A hydromotor that is said to be smaller turns faster, by 195/185.
    speed = content['signals']['motor_speed']
    assert speed['bias'] == pytest.approx(10 * (195 / 185 - 1), rel=0.3)
    assert 'does not explain the measurements' in out
    for title in ('pump outlet pressure [bar]', 'hydromotor speed [rpm]', 'x floor', 'Russell'):
        assert title in out


def test_json_alone_on_standard_output(log, capsys):
    code, out, err = command(capsys, log, '--json', '-')
    assert code == 0 and json.loads(out)['signals'].keys() == UNITS.keys()


def test_a_bag_gives_what_the_csv_gives(run, log, tmp_path, capsys):
    pytest.importorskip('mcap')
    bag.write_run(tmp_path / 'bag', run)
    mcap = next((tmp_path / 'bag').glob('*.mcap'))
    found = [json.loads(command(capsys, path, '--json', '-')[1])['signals']
             for path in (log, tmp_path / 'bag', mcap)]
    for signals in found[1:]:
        for name in UNITS:
            # Times of a bag are whole nanoseconds, a CSV keeps nine digits.
            assert signals[name]['rmse'] == pytest.approx(found[0][name]['rmse'], rel=1e-3)
            assert signals[name]['samples'] == found[0][name]['samples'] == len(run)


def test_several_logs(log, tmp_path, capsys):
    run = record(4, duration=4.0, settled=True)
    write_csv(tmp_path / 'run.csv', run)
    code, out, err = command(capsys, log, tmp_path / 'run.csv', '--plot', tmp_path / 'a.png',
                             '--json', tmp_path / 'a.json')
    assert code == 0 and '2 logs:' in out and 'log by log' in out
    # Equal names are told apart by their folders.
    for folder in (log.parent.name, tmp_path.name):
        assert f'{folder}/run' in out
    pictures = sorted(tmp_path.glob('a_*.png'))
    assert len(pictures) == 2 and err.count('wrote ') == 2
    content = json.loads((tmp_path / 'a.json').read_text())
    assert content['signals']['motor_speed']['samples'] == 2 * len(run)
    assert len(content['by_log']) == 2


def test_a_picture(log, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    assert command(capsys, log, '--plot', tmp_path / 'a.png')[0] == 0
    assert (tmp_path / 'a.png').read_bytes().startswith(b'\x89PNG')


def test_without_matplotlib(log, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    code, out, err = command(capsys, log, '--plot', tmp_path / 'a.png')
    assert code == 2 and 'matplotlib is not installed' in err


def test_foreign_names(run, tmp_path, capsys):
    csv, channels = tmp_path / 'a.csv', tmp_path / 'map.yaml'
    write_csv(csv, run)
    csv.write_text(csv.read_text().replace('motor_speed[rpm]', 'Drehzahl [1/min]'))
    assert 'hydromotor speed' not in command(capsys, csv)[1].partition('where')[0]
    channels.write_text('channels: {motor_speed: "Drehzahl [1/min]"}\n')
    assert 'hydromotor speed [rpm]' in command(capsys, csv, '--channels', channels)[1]


def lines(log):
    """Return header and rows of a log."""
    head, *rows = log.read_text().splitlines(keepends=True)
    return head, rows


BAD = {
    'empty': (lambda head, rows: '', 'the file is empty'),
    'no units': (lambda head, rows: 'time,motor_speed[rpm]\n0,1\n1,1\n', "'time' has no unit"),
    'text': (lambda head, rows: head + ''.join(
        row.rsplit(',', 1)[0] + ',abc\n' for row in rows), "expected a number, found 'abc'"),
    'time back': (lambda head, rows: head + ''.join(rows[:50] + rows[40:]), 'runs back'),
    'two rows': (lambda head, rows: head + ''.join(rows[:2]), 'only 2 rows'),
    'header': (lambda head, rows: head, 'no rows of data'),
    'inputs alone': (lambda head, rows: 'time[s],pump_command[V],pprv_command[V]\n' + ''.join(
        f'{k / 100},5,2\n' for k in range(30)), 'nothing to compare'),
    'no command': (lambda head, rows: 'time[s],motor_speed[rpm]\n' + ''.join(
        f'{k / 100},5\n' for k in range(30)), "channel 'pump_command' is missing"),
    'no name': (lambda head, rows: 'time[s],foo[V]\n0,1\n1,2\n', 'none of its columns is known'),
}


@pytest.mark.parametrize('case', BAD)
def test_bad_files(log, tmp_path, capsys, case):
    change, expected = BAD[case]
    path = tmp_path / 'bad.csv'
    path.write_text(change(*lines(log)))
    said = refused(capsys, path)
    assert str(path) in said and expected in said


def test_bad_bags(run, tmp_path, capsys):
    pytest.importorskip('mcap')
    bag.write_run(tmp_path / 'cut', run)
    mcap = next((tmp_path / 'cut').glob('*.mcap'))
    mcap.write_bytes(mcap.read_bytes()[:-len(mcap.read_bytes()) // 2])
    assert 'was cut off' in refused(capsys, tmp_path / 'cut')
    (tmp_path / 'folder').mkdir()
    assert 'is no bag' in refused(capsys, tmp_path / 'folder')
    assert 'No such file' in refused(capsys, tmp_path / 'none.csv')


def test_a_bag_with_none_of_our_topics(tmp_path, capsys):
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    from rosbags.typesys import get_typestore, Stores

    store = get_typestore(Stores.ROS2_JAZZY)
    text = store.types['std_msgs/msg/String']
    with rosbag2.Writer(tmp_path / 'foreign', version=9) as writer:
        topic = writer.add_connection('/chatter', 'std_msgs/msg/String', typestore=store)
        for k in range(20):
            writer.write(topic, k * 10**7, store.serialize_cdr(text(data='x'), topic.msgtype))
    said = refused(capsys, tmp_path / 'foreign')
    assert '/chatter' in said or 'topic' in said


def test_gaps_are_told_and_judged_around(run, tmp_path, capsys):
    holes = dict(run.channels)
    holes['motor_speed'] = holes['motor_speed'].copy()
    holes['motor_speed'][50:90] = np.nan
    holes['pump_outlet_pressure'] = np.full(len(run), np.nan)
    write_csv(tmp_path / 'gaps.csv', Run('gaps', run.time, holes))
    code, out, err = command(capsys, tmp_path / 'gaps.csv', '--json', tmp_path / 'a.json')
    assert code == 0 and 'motor_speed: 40 of 400 samples missing' in err
    signals = json.loads((tmp_path / 'a.json').read_text())['signals']
    assert signals['motor_speed']['samples'] == 360
    assert 'pump_outlet_pressure' not in signals


@pytest.mark.parametrize('arguments, expected', [
    ([], 'LOG'), (['--rig', 'none.yaml'], 'none.yaml: cannot be read'),
    (['--channels', 'none.yaml'], 'none.yaml'), (['--json', '/none/a.json'], 'cannot be written'),
    (['--closed-loop'], "channel 'speed_setpoint' is missing"), (['--colour'], '--colour')])
def test_wrong_arguments(log, capsys, arguments, expected):
    code, out, err = command(capsys, *([log, *arguments] if arguments else []))
    assert code == 2 and expected in err and err.count('\n') == 1


def test_as_a_process(log):
    done = subprocess.run([sys.executable, '-m', 'hst_drive', 'compare', str(log)],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and 'hydromotor speed [rpm]' in done.stdout and not done.stderr


def test_a_hole_in_the_recording_is_told(run, tmp_path, capsys):
    path = tmp_path / 'hole.csv'
    write_csv(path, Run('hole', np.delete(run.time, slice(100, 200)), {
        name: np.delete(values, slice(100, 200)) for name, values in run.channels.items()}))
    code, out, err = command(capsys, path)
    assert code == 0 and 'no samples for 1.01 s after 0.99 s' in err


def test_impossible_numbers_are_refused(run, tmp_path, capsys):
    path = tmp_path / 'fault.csv'
    speed = run['motor_speed'].copy()
    speed[50:53] = 65535e3
    write_csv(path, Run('fault', run.time, {**run.channels, 'motor_speed': speed}))
    assert 'motor_speed is 6.258e+08 rpm at 0.5 s (3 of 400' in refused(capsys, path)


def test_what_cannot_be_written_or_counts_twice_is_told_at_once(log, tmp_path, capsys):
    assert 'cannot be written' in refused(capsys, log, '--json', tmp_path / 'no' / 'a.json')
    assert 'ends in .png' in refused(capsys, log, '--plot', tmp_path / 'a')
    assert 'cannot be written' in refused(capsys, log, '--plot', tmp_path / 'no' / 'a.png')
    assert 'given twice' in refused(capsys, log, log)
    copy = tmp_path / 'copy.csv'
    copy.write_bytes(log.read_bytes())
    assert f'{copy}: holds the same recording as {log}' in refused(capsys, log, copy)


def test_a_copy_in_another_format_counts_twice(run, log, tmp_path, capsys):
    """A CSV rounds what a bag holds, and its clock begins at 0."""
    copy = tmp_path / 'rounded.csv'
    write_csv(copy, Run('rounded', np.round(run.time - run.time[0], 6), {
        name: values * (1.0 + 1e-8) for name, values in run.channels.items()
        if name != 'speed_setpoint'}))
    assert f'{copy}: holds the same recording as {log}' in refused(capsys, log, copy)


def test_a_rig_that_lacks_a_section_is_told_with_what_is_not_judged(log, tmp_path, capsys):
    content = yaml.safe_load(share('config', 'rig', 'test_rig.yaml').read_text())
    rig = tmp_path / 'rig.yaml'
    rig.write_text(yaml.safe_dump({key: value for key, value in content.items()
                                   if key != 'motor'}))
    code, _, err = command(capsys, log, '--rig', rig)
    assert code == 0 and f"no replay of the whole drive, '{rig}' has no section motor" in err
    assert 'not judged: ' in err and 'hydromotor speed' in err.partition('not judged: ')[2]


def test_a_frozen_channel_is_told(run, tmp_path, capsys):
    path = tmp_path / 'frozen.csv'
    write_csv(path, Run('frozen', run.time, {
        **run.channels, 'motor_speed': np.full(len(run), 10.471975512)}))
    code, out, err = command(capsys, path, '--json', tmp_path / 'a.json')
    assert code == 0 and 'motor_speed: the same number throughout' in err
    assert json.loads((tmp_path / 'a.json').read_text())['signals']['motor_speed']['fit'] is None


def test_what_is_left_out_is_told(run, tmp_path, capsys):
    """A start from rest, a pressure at zero for a while, and one that is there for too long."""
    low, rest = run['pump_outlet_pressure'].copy(), run['motor_speed'].copy()
    low[300:310] = 0.0
    rest[:10] = 0.0
    path = tmp_path / 'low.csv'
    write_csv(path, Run('low', run.time, {**run.channels, 'pump_outlet_pressure': low}))
    code, out, err = command(capsys, path, '--json', tmp_path / 'a.json')
    assert code == 0 and 'low: 3.00 to 3.99 s (cavitation)' in out and "as in 'diagnose'" in out
    entry, = json.loads((tmp_path / 'a.json').read_text())['by_log']
    assert entry['left_out'] == [{'start': 3.0, 'end': pytest.approx(3.99), 'unit': 's',
                                  'why': 'cavitation'}]
    assert entry['seconds_left_out'] == pytest.approx(0.99)
    assert 'not judged' not in command(capsys, path, '--all')[1]
    write_csv(path, Run('low', run.time, {**run.channels, 'pump_outlet_pressure': low,
                                          'motor_speed': rest}))
    out = command(capsys, path)[1]
    assert 'low: 0.00 to 1.10 s (start from rest)' in out
    assert 'low: cavitation makes 25 % of the log, so it is judged' in out


def test_a_log_without_commands_is_judged_in_parts_and_that_is_told(run, tmp_path, capsys):
    path = tmp_path / 'bare.csv'
    write_csv(path, Run('bare', run.time, {name: values for name, values in run.channels.items()
                                           if not name.endswith('_command')}, str(path)))
    code, _, err = command(capsys, path)
    assert code == 0 and 'bare: no replay of the whole drive, which needs pump_command' in err
    assert err.strip().endswith('judged one by one: hydromotor torque, hydromotor flow')


def test_files_are_written_though_nobody_reads_the_text(log, tmp_path):
    """As with ``| head``."""
    process = subprocess.Popen(
        [sys.executable, '-u', '-c', 'from hst_drive import cli; import sys; '
         f"sys.exit(cli.main(['compare', {str(log)!r}, '--json', {str(tmp_path / 'c.json')!r}]))"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    process.stderr.read()
    process.wait()
    assert json.loads((tmp_path / 'c.json').read_text())['signals']
