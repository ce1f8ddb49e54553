# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Drilling logs: a made-up log of known content, bad ones, and real ones where there are any."""
from pathlib import Path

from hst_drive.errors import InputError
from hst_drive.load import load_scenario, parse_scenario
from hst_drive.load.drilling_log import parse_drilling_log, to_profile, Use
import numpy as np
import pytest

MADE_UP = Path(__file__).with_name('made_up_mud_log.csv')
REAL = Path(__file__).resolve().parents[3] / 'shared' / 'real'
FORGE = REAL / 'forge_16B-78-32_drilling_log' / 'forge_16B_1ft.csv'


def parse(text, **columns):
    """Parse a log given as text."""
    return parse_drilling_log(text, 'log.csv', columns)


def test_units_of_the_header_count():
    log = parse('depth[ft],torque[klbf.ft],rpm[rpm],rop[ft/h]\n100,10,60,50\n101,,60,50\n'
                '102,12,60,100\n')
    assert log.columns['depth'] == pytest.approx([30.48, 30.7848, 31.0896])
    assert log.columns['torque'][0] == pytest.approx(13558.18, rel=1e-6)
    assert np.isnan(log.columns['torque'][1])
    assert log.columns['penetration_rate'][2] == pytest.approx(100 * 0.3048 / 3600)


def test_time_from_penetration_rate_and_gap():
    log = parse('depth[m],torque[N.m],rop[m/h]\n0,100,36\n1,,36\n2,300,36\n4,300,72\n')
    profile, notes = to_profile(log, Use(factor=0.5, speed_up=10.0, start=3.0))
    # 1 m at 36 m/h is 100 s; 2 m at the mean of 36 and 72 m/h 133.3 s; ten times faster.
    assert profile.times == pytest.approx([3.0, 13.0, 23.0, 23.0 + 13.3333333])
    assert profile.values == pytest.approx([50.0, 100.0, 150.0, 150.0])
    assert any('1 of 4 rows without torque' in note for note in notes)


def test_percent_needs_a_range():
    log = parse('time[s],torque[%]\n' + ''.join(f'{i},{20 + i}\n' for i in range(101)))
    profile, notes = to_profile(log, Use(torque_range=(50.0, 250.0)))
    assert profile.values[0] == profile.values[1] == pytest.approx(50.0)
    assert profile.values[50] == pytest.approx(150.0)
    assert profile.values[-1] == pytest.approx(250.0)
    assert 'mapped to 50 to 250 N.m' in notes[0]
    with pytest.raises(InputError, match='percent'):
        to_profile(log, Use(factor=1.0))


def test_foreign_names():
    log = parse('MD,TRQ_KFTLB\n1,2\n2,3\n', depth=('MD', 'm'), torque=('TRQ_KFTLB', 'klbf.ft'))
    assert log.columns['torque'][1] == pytest.approx(3 * 1355.818, rel=1e-6)
    with pytest.raises(InputError, match="did you mean 'TRQ_KFTLB'"):
        parse('MD,TRQ_KFTLB\n1,2\n2,3\n', torque=('TRQ_KFTL', 'klbf.ft'))


@pytest.mark.parametrize('text, what', (
    ('', 'empty'), ('x' * 200000, 'expected a CSV'),
    ('depth,torque\n1,2\n', 'no column for torque'),
    ('torque[N.m]\n1\n2\n', 'time or depth'),
    ('time[s],torque[N.m]\n0,1\n1,hard\n', "row 3, column 'torque\\[N.m\\]': found 'hard'"),
    ('time[s],torque[N.m]\n0,1\n1\n', 'row 3 has 1 cells'),
    ('time[s],torque[N.m]\n0,1\n', 'fewer than 2 rows'),
    ('time[s],torque[bar]\n0,1\n1,2\n', 'unit \\[bar\\]'),
    ('time[s],torque[N.m]\n0,1\n5,1\n4,1\n', 'time runs back'),
    ('depth[m],torque[N.m]\n0,1\n5,1\n', 'state time_per_row_s'),
    ('time[s],torque[N.m]\n,1\n,1\n', 'at one time or depth, or have none'),
    ('depth[m],torque[N.m],rop[m/h]\n7,1,9\n7,1,9\n', 'at one time or depth, or have none'),
    ('depth[m],torque[N.m],rop[m/h]\n0,1,0\n5,1,\n', 'penetration rate above 0'),
))
def test_bad_logs_get_one_line(text, what):
    with pytest.raises(InputError, match=what) as error:
        to_profile(parse(text), Use(factor=1.0))
    assert '\n' not in str(error.value) and str(error.value).startswith('log.csv')


def test_missing_value_marks_of_mud_logs():
    log = parse('time[s],torque[N.m]\n0,5\n1,-999.25\n2,7\n')
    assert np.isnan(log.columns['torque'][1])


def test_window():
    log = parse('depth[m],torque[N.m]\n' + ''.join(f'{i},{10 * i}\n' for i in range(50)))
    profile, notes = to_profile(log, Use(factor=1.0, window=(10.0, 20.0), time_per_row=0.5))
    assert profile.values[0] == 100.0 and profile.values[-1] == 200.0
    assert 'rows 12 to 22 used, 39 others left out' in notes[0]
    with pytest.raises(InputError, match='the log runs from 0 to 49'):
        to_profile(log, Use(factor=1.0, window=(100.0, 200.0), time_per_row=0.5))


def test_shipped_template_takes_the_made_up_log():
    """A log written for this test in the manner of a mud log: gaps, a spike, a connection."""
    scenario = load_scenario('real_log', log=MADE_UP)
    torques = [scenario.load.torque(t) for t in np.arange(6.0, scenario.duration, 0.1)]
    assert min(torques) == pytest.approx(30.0, abs=1e-6)
    assert max(torques) == pytest.approx(240.0, abs=1e-6)
    assert any('without torque' in note for note in scenario.notes)


@pytest.mark.skipif(not FORGE.is_file(), reason='no real logs beside the repository')
def test_utah_forge_log():
    scenario = load_scenario('real_log_utah_forge', log=FORGE)
    with FORGE.open() as file:
        cells = [line.split(',')[2] for line in file.readlines()[1:]]
    rows = [i for i, cell in enumerate(cells) if cell]
    assert scenario.duration == pytest.approx(6.0 + 0.1 * (rows[-1] - rows[0]))
    # A row in the middle of the range, mapped by hand from the file's own percentiles.
    logged = np.array([float(cells[i]) if cells[i] else np.nan
                       for i in range(rows[0], rows[-1] + 1)])
    good = np.flatnonzero(np.isfinite(logged))
    filled = np.interp(np.arange(len(logged)), good, logged[good])
    low, high = np.percentile(filled, [1, 99])
    at = 5000
    expected = np.clip(30 + 210 * (filled[at] - low) / (high - low), 30, 240)
    assert scenario.load.torque(6.0 + 0.1 * at) == pytest.approx(expected, rel=1e-6)


@pytest.mark.skipif(not FORGE.is_file(), reason='no real logs beside the repository')
@pytest.mark.parametrize('path', sorted((REAL / 'mwd_cme550x_boreholes').glob('*.csv')),
                         ids=lambda path: path.stem)
def test_auger_logs(path):
    scenario = load_scenario('real_log_auger_mwd', log=path)
    rows = sum(1 for _ in path.open()) - 1
    assert scenario.duration >= 6.0 + (rows - 1) / 10.0 - 1e-6
    assert all(0.5 <= scenario.load.pprv_command(t) <= 10.0
               for t in np.linspace(0, scenario.duration, 200))


@pytest.mark.parametrize('given, first, last', [
    ({'time_range_s': [20, 30]}, 20.0, 30.0), ({'depth_range_m': [530, 550]}, 30.0, 50.0)])
def test_a_range_is_of_what_its_key_says(given, first, last):
    """Of a log with time and depth; one without depth has no range of it."""
    content = {'title': 'a log', 'speed_setpoint': {'speed_rpm': 60},
               'load': {'kind': 'drilling_log', 'torque_factor': 1.0, **given}}
    rows = [(k, k, 500 + k) for k in range(60)]
    text = 'time[s],torque[N.m],depth[m]\n' + ''.join('%d,%d,%d\n' % row for row in rows)
    load = parse_scenario(content, None, read_text=lambda name: (text, 'log.csv')).load
    assert (load.torque(0.0), load.torque(999.0)) == (first, last)
    if 'depth_range_m' in given:
        text = text.replace('depth[m]', 'other[m]')
        with pytest.raises(InputError, match='log.csv: has no depth.*it has time, torque'):
            parse_scenario(content, None, read_text=lambda name: (text, 'log.csv'))
