# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""CSV recordings: what is written comes back, and what is wrong is said in one line."""
from hst_drive.bag import read_csv, read_log, write_csv
from hst_drive.bag.bench_table import read_points
from hst_drive.bag.channels import ChannelMap
from hst_drive.bag.csv_sections import csv_sections
from hst_drive.channels import CHANNELS
from hst_drive.errors import InputError
from hst_drive.measure.run import Run
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from .records import make_run

HEADER = 'time[s],motor_speed[rpm]'
ROWS = [f'{i * 0.01:.2f},{i}' for i in range(50)]


def save(tmp_path, header, rows, name='log.csv', newline='\n', encoding='utf-8'):
    path = tmp_path / name
    path.write_bytes(newline.join([header, *rows, '']).encode(encoding))
    return path


def swap(row, text):
    return [*ROWS[:row - 2], text, *ROWS[row - 1:]]


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_what_is_written_comes_back(tmp_path_factory, data):
    names = data.draw(st.lists(st.sampled_from(sorted(CHANNELS)), min_size=1, unique=True))
    rows = data.draw(st.integers(10, 30))
    number = st.floats(-1e6, 1e6) | st.just(float('nan'))
    values = {name: np.array(data.draw(st.lists(number, min_size=rows, max_size=rows)))
              for name in names}
    for column in values.values():
        column[0] = 1.5
    run = Run('r', np.cumsum(np.full(rows, 0.013)), values)
    path = tmp_path_factory.mktemp('csv') / 'r.csv'
    write_csv(path, run)
    back = read_csv(path)
    assert set(back.channels) == set(names)
    np.testing.assert_allclose(back.time, run.time, rtol=1e-11)
    for name in names:
        scale = 300.0 if name == 'oil_temperature' else 0.0
        np.testing.assert_allclose(back[name], run[name], rtol=1e-8, atol=1e-8 * scale + 1e-12)


def test_the_unit_in_the_header_counts(tmp_path):
    header = 'time[ms],motor_speed[rad/s],pump_outlet_pressure[psi],oil_temperature[degF],' \
        'motor_inlet_flow[m^3/h]'
    run = read_csv(save(tmp_path, header, [f'{10 * i},2,1000,122,3.6' for i in range(20)]))
    assert run.time[1] == pytest.approx(0.01)
    assert run['motor_speed'][0] == 2.0
    assert run['pump_outlet_pressure'][0] == pytest.approx(6.894757e6, rel=1e-6)
    assert run['oil_temperature'][0] == pytest.approx(323.15)
    assert run['motor_inlet_flow'][0] == pytest.approx(1e-3)


@pytest.mark.parametrize('header', [
    'time(s),motor_speed(rpm),case_drain_flow(L/h)',
    'time (s),motor_speed (rpm),case_drain_flow [L/h]',
    'time [s], motor_speed [1/min], case_drain_flow ( l/h )'])
def test_units_in_round_brackets_count_too(tmp_path, header):
    run = read_csv(save(tmp_path, header, [f'{0.1 * i:.1f},60,36' for i in range(20)]))
    assert run['motor_speed'][0] == pytest.approx(2 * np.pi)
    assert run['case_drain_flow'][0] == pytest.approx(1e-5)


@pytest.mark.parametrize('stamp', [
    '2026-11-03 12:0{}:{:05.2f}', '2026-11-03T12:0{}:{:05.2f}Z', '3.11.2026 9:0{}:{:05.2f}+02:00',
    '9:0{}:{:05.2f}', '12:0{}:{:05.2f}'])
@pytest.mark.parametrize('comma', [False, True])
@pytest.mark.parametrize('reader', [
    read_csv, lambda path: next(csv_sections(path, ChannelMap(), 1e3, 0.0, 0.0)).run])
def test_stamps_may_be_dates(tmp_path, stamp, comma, reader):
    times = 59.0 + 0.05 * np.arange(40)
    rows = [f'{k};' + stamp.format(int(time // 60), time % 60) for k, time in enumerate(times)]
    text = '\n'.join(['motor_speed[rpm];time', *rows])
    path = tmp_path / 'dates.csv'
    path.write_text(text.replace('.', ',') if comma and '.2026' not in text else text)
    run = reader(path)
    np.testing.assert_allclose(run.time, times - 59.0, atol=1e-6)
    np.testing.assert_allclose(run['motor_speed'], np.arange(40) * np.pi / 30)


@pytest.mark.parametrize('stamp', ['11/03/2026 12:00:00', '2026', 'noon', '2026-13-03 12:00:00'])
def test_what_is_no_date_is_refused(tmp_path, stamp):
    path = save(tmp_path, 'time,motor_speed[rpm]', ['2026-11-03 12:00:00,1', f'{stamp},2'])
    with pytest.raises(InputError, match='no unit' if stamp == '2026' else "row 3, column 'time': "
                       f"expected a date like 2026-11-03 12:00:01.25, found '{stamp}'"):
        read_csv(path)


@pytest.mark.parametrize('above', [False, True])
@pytest.mark.parametrize('reader', [
    read_csv, lambda path: next(csv_sections(path, ChannelMap(), 10.0, 0.0, 0.0)).run])
def test_units_may_have_a_line_of_their_own(tmp_path, reader, above):
    names, units = 'time;motor_speed;pump_command;note;coil', 's;[rpm];V;[-];A'
    lines = [units, names] if above else [names, units]
    path = tmp_path / 'a.csv'
    path.write_text('\n'.join([*lines, *(f'{0.01 * k};{60 + k};5;{k};0' for k in range(30))]))
    run = reader(path)
    assert len(run) == 30 and set(run.channels) == {'motor_speed', 'pump_command'}
    assert run['motor_speed'][0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize('rate, begins', [(5000, 0.0), (1500, 0.0), (1100, 0.0), (5000, 0.0007)])
def test_rows_that_share_a_rounded_stamp_are_spread(tmp_path, rate, begins):
    exact = begins + np.arange(3000) / rate
    path = tmp_path / 'a.csv'
    path.write_text('time[s],motor_speed[rpm]\n' + ''.join(
        f'{np.floor(stamp * 1000 + 1e-6) / 1000:.3f},{60 + stamp}\n' for stamp in exact))
    run = read_csv(path)
    assert np.all(np.diff(run.time) > 0) and np.abs(run.time - exact).max() < 1e-3
    if rate == 5000:
        assert np.diff(run.time) == pytest.approx(2e-4, abs=1e-7)
    assert any('rounded to 0.001 s' in note for note in run.notes)


def test_other_words_in_round_brackets_are_part_of_the_name(tmp_path):
    header = HEADER + ',motor_speed (1),motor_speed (raw)'
    run = read_csv(save(tmp_path, header, [f'{row},1,2' for row in ROWS]))
    assert run['motor_speed'][3] == pytest.approx(np.pi / 10)
    assert any("'motor_speed (1)' is not known" in note for note in run.notes)
    assert any("'motor_speed (raw)' is not known" in note for note in run.notes)


@pytest.mark.parametrize('separator, decimal', [(',', '.'), (';', '.'), (';', ','), ('\t', '.'),
                                                ('\t', ',')])
@pytest.mark.parametrize('newline, encoding', [('\n', 'utf-8'), ('\r\n', 'utf-8-sig'),
                                               ('\r\n', 'utf-16')])
def test_files_of_other_programs(tmp_path, separator, decimal, newline, encoding):
    rows = [row.replace(',', separator) if decimal == '.' else
            row.replace(',', separator).replace('.', decimal) for row in ROWS]
    rows[3:3] = ['# a comment', '', '   ']
    rows = [row + separator + f'"1{decimal}5"' if '0' in row else row for row in rows]
    header = '# made by a logger' + newline + HEADER.replace(',', separator) \
        + separator + '"load_torque[N.m]"'
    run = read_csv(save(tmp_path, header, rows, newline=newline, encoding=encoding))
    np.testing.assert_allclose(run.time, np.arange(50) * 0.01)
    np.testing.assert_allclose(run['motor_speed'] * 30 / np.pi, np.arange(50))
    np.testing.assert_allclose(run['load_torque'], 1.5)


def test_missing_samples_are_kept_and_noted(tmp_path):
    rows = swap(10, '0.08,')
    rows[20] = '0.20,NaN'
    run = read_csv(save(tmp_path, HEADER, rows))
    assert np.flatnonzero(np.isnan(run['motor_speed'])).tolist() == [8, 20]
    assert any('motor_speed: 2 of 50 samples missing' in note for note in run.notes)


def test_a_name_in_other_letters_is_near(tmp_path):
    run = read_csv(save(tmp_path, HEADER + ',line_A_pressure[bar]', [row + ',1' for row in ROWS]))
    assert any("did you mean 'line_a_pressure'" in note for note in run.notes), run.notes


def test_unknown_and_empty_columns_are_noted(tmp_path):
    rows = [row + ',x,' for row in ROWS]
    run = read_csv(save(tmp_path, HEADER + ',operator,load_torque[N.m]', rows))
    assert list(run.channels) == ['motor_speed']
    assert any('operator' in note for note in run.notes)
    assert any('load_torque: no numbers' in note for note in run.notes)


@pytest.mark.parametrize('header, rows, said', [
    ('', [], 'empty'),
    ('# nothing', [], 'only comments'),
    (HEADER, [], 'no rows'),
    ('time,motor_speed[rpm]', ROWS, r"'time' has no unit; write it as time\[s\]"),
    ('time[s],motor_speed', ROWS, r"'motor_speed' has no unit; write it as motor_speed\[rpm\]"),
    ('time[s],motor_speed,load_torque', ROWS, r"columns 'motor_speed', 'load_torque' "
     r'have no unit; write them as motor_speed\[rpm\], load_torque\[N.m\]'),
    (ROWS[0], ROWS[1:], 'no header'),
    (HEADER, swap(22, '0.20,abc'), r"row 22, column 'motor_speed\[rpm\]'.*'abc'"),
    (HEADER, ['a,b'] * 20, r"row 2, column 'time\[s\]'.*'a'"),
    (HEADER, swap(22, '0.10,1'), 'row 22: the time runs back.*cut the log there'),
    (HEADER, swap(22, '0.19,1'), 'row 22: the time stands still.*rows that come twice'),
    (HEADER, swap(22, 'nan,1'), 'row 22: the time is missing'),
    (HEADER, swap(22, 'inf,1'), 'row 22: the time is missing or not finite'),
    (HEADER, swap(22, '0.20'), 'row 22 has 1 cells, the header 2'),
    (HEADER, swap(22, '0.20,1,2'), 'row 22 has 3 cells, the header 2'),
    (HEADER, ROWS[:2], 'only 2 rows'),
    (HEADER, [row.split(',')[0] + ',' for row in ROWS], 'none of its channels holds a number'),
    (HEADER + ',motor_speed[rad/s]', [row + ',1' for row in ROWS], "'motor_speed' comes twice"),
    ('time[s],motor_speed[bar]', ROWS, r"'motor_speed\[bar\]'.*another quantity"),
    ('time[s],motor_speed[rmp]', ROWS, r"'motor_speed\[rmp\]'.*unknown unit"),
    ('t[s],motor_speed[rpm]', ROWS, r'no column time\[s\]'),
    ('time[s],motr_speed[rpm]', ROWS, r'none of its columns is known.*motor_speed\?.*--channels'),
])
def test_what_is_wrong_is_one_clear_line(tmp_path, header, rows, said):
    path = save(tmp_path, header, rows)
    with pytest.raises(InputError, match=said) as caught:
        read_log(path)
    assert '\n' not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize('rest', ['0.2', '0.20', '"0.20'])
def test_a_last_row_that_was_not_written_to_its_end_is_left_out(tmp_path, rest):
    path = save(tmp_path, HEADER, ROWS)
    whole = read_log(path)
    with open(path, 'a', encoding='utf-8') as file:
        file.write(rest)
    run = read_log(path)
    assert np.array_equal(run.time, whole.time)
    assert np.array_equal(run['motor_speed'], whole['motor_speed'])
    assert f'the last row ({len(ROWS) + 2}) is cut off; left out' in run.notes
    assert not any('cut off' in note for note in whole.notes)


@pytest.mark.parametrize('after', ['\n', '\n# the end', '\n\n'])
def test_a_short_row_that_was_written_to_its_end_is_refused(tmp_path, after):
    path = save(tmp_path, HEADER, ROWS)
    with open(path, 'a', encoding='utf-8') as file:
        file.write('0.20' + after)
    with pytest.raises(InputError, match=f'row {len(ROWS) + 2} has 1 cells, the header 2'):
        read_log(path)


def test_a_quote_that_is_left_open_is_told(tmp_path):
    path = save(tmp_path, HEADER, [ROWS[0], '0.01,"1', *(f'{k},1' for k in range(40_000))])
    with pytest.raises(InputError, match='log.csv: cannot be read up to row .* quote'):
        read_log(path)


def test_binary_and_missing_files_are_refused(tmp_path):
    path = tmp_path / 'picture.csv'
    path.write_bytes(bytes(range(256)) * 9)
    with pytest.raises(InputError, match='not a CSV file'):
        read_log(path)
    with pytest.raises(InputError, match='No such file'):
        read_log(tmp_path / 'none.csv')


def test_an_error_in_a_long_file_is_found(tmp_path):
    run = make_run(100_000)
    write_csv(tmp_path / 'long.csv', run)
    with open(tmp_path / 'long.csv', 'a', encoding='utf-8') as file:
        file.write('1000,oops' + ',1' * (len(run.channels) - 1) + '\n')
    with pytest.raises(InputError, match="row 100002, column 'pump_command.*'oops'"):
        read_log(tmp_path / 'long.csv')


def test_decimal_commas_may_come_late(tmp_path):
    rows = [*(f'{10 * k};0' for k in range(1500)), *(f'{10 * k};{k},5' for k in range(1500, 1550))]
    run = read_csv(save(tmp_path, 'time[ms];motor_speed[rpm]', rows))
    assert run['motor_speed'][-1] == pytest.approx(1549.5 * np.pi / 30)


@pytest.mark.parametrize('newline', ['\n', '\r\n', '\r'])
def test_dots_of_windows_end_no_line(tmp_path, newline):
    rows = [f'{row},1' for row in ROWS]
    path = save(tmp_path, HEADER + ',state\x85 of', rows, newline=newline, encoding='latin-1')
    assert read_csv(path)['motor_speed'] == pytest.approx(np.arange(50) * np.pi / 30)


def test_time_since_1970_is_written_to_the_microsecond(tmp_path):
    run = Run('r', 1.7e9 + 1e-3 * np.arange(50), {'motor_speed': np.arange(50.0)})
    write_csv(tmp_path / 'r.csv', run)
    np.testing.assert_allclose(read_csv(tmp_path / 'r.csv').time, run.time, rtol=0, atol=1e-6)


@pytest.mark.parametrize('summer, winter', [('+02:00', '+01:00'), ('-0230', '-0330'),
                                            ('+02', ' +01')])
def test_a_clock_put_back_in_autumn_goes_on(tmp_path, summer, winter):
    stamps = [*(f'2026-10-25 02:59:{k}{summer}' for k in range(50, 60)),
              *(f'2026-10-25 02:00:0{k}{winter}' for k in range(10))]
    rows = [f'{stamp},{k}' for k, stamp in enumerate(stamps)]
    run = read_csv(save(tmp_path, 'time,motor_speed[rpm]', rows))
    np.testing.assert_allclose(run.time, np.arange(20.0))


@pytest.mark.parametrize('reader', [
    read_csv, read_points, lambda path: next(csv_sections(path, ChannelMap(), 10.0, 0.0, 0.0))])
def test_a_line_of_hundreds_of_kilobytes_is_no_header(tmp_path, reader):
    with pytest.raises(InputError, match='cannot be read up to row 1 .field larger'):
        reader(save(tmp_path, 'x' * 200_000, ROWS))
