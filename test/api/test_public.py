# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The public library: what importing it costs, its examples, its types, what results become."""
import doctest
from html.parser import HTMLParser
import importlib.util
import inspect
import json
from pathlib import Path
import subprocess
import sys

import hst_drive as hd
from hst_drive import api
from hst_drive.cli import main
from hst_drive.effects import register
from hst_drive.rig import default_rig_file
import numpy as np
import pytest

TOP = Path(__file__).resolve().parents[2]
FUNCTIONS = sorted(set(hd.__all__) - {'InputError'})
DIAGNOSING = ('adopt', 'commission', 'diagnose')      # minutes without numba
LEAK = {'motor_leakage': {'conductance': 2e-12}}


@pytest.fixture(scope='module')
def log():
    return hd.simulate('paper_step', effects=LEAK)


def test_import_is_free_and_order_does_not_matter():
    """The command line and the nodes start without NumPy; packages of the same name stay both."""
    code = ('import sys, hst_drive as hd; '
            'assert not {"numpy", "scipy", "yaml"} & set(sys.modules), "heavy"; '
            'from hst_drive.effects import Effect; import hst_drive.losses.table as table; '
            'import hst_drive.diagnose.result; '
            'assert all(callable(getattr(hd, name)) for name in hd.__all__); '
            'assert hd.effects("motor_leakage").ids == ("motor_leakage",); '
            'assert [name for name in dir(hd) if name[0] != "_"] == sorted(hd.__all__)')
    done = subprocess.run([sys.executable, '-c', code], cwd=TOP, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize('name', [pytest.param(name, marks=[
    pytest.mark.needs_numba] if name in DIAGNOSING else []) for name in FUNCTIONS])
def test_examples_run(name):
    """Each function shows how it is called, and that is so."""
    function = getattr(api, name)
    tests = doctest.DocTestFinder(recurse=False).find(function, name)
    assert tests and tests[0].examples
    said = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(
        tests[0], out=said.append)
    assert not said, ''.join(said)
    assert inspect.signature(getattr(hd, name)) == inspect.signature(function)
    assert inspect.getdoc(getattr(hd, name)) == inspect.getdoc(function)


@pytest.mark.skipif(importlib.util.find_spec('mypy') is None, reason='mypy is not installed')
def test_types_hold(tmp_path):
    """The public part is typed, and so is a program that uses it."""
    user = tmp_path / 'user.py'
    user.write_text('import hst_drive as hd\n'
                    "verdict: str = hd.diagnose('log.csv').verdict\n"
                    "ids: tuple[str, ...] = hd.effects('motor_leakage').ids\n"
                    "hd.compare('log.csv', wrong=1)\n", encoding='utf-8')
    mypy = [sys.executable, '-m', 'mypy', '--cache-dir', str(tmp_path / 'cache')]
    public = [TOP / 'hst_drive' / name for name in ('__init__.py', 'as_function.py', 'api')]
    done = subprocess.run([*mypy, *map(str, public), str(user)], cwd=TOP, capture_output=True,
                          text=True)
    errors = [line for line in done.stdout.splitlines() if ': error:' in line]
    assert len(errors) == 1 and 'wrong' in errors[0], done.stdout + done.stderr


def test_same_as_the_command_line(log, tmp_path, capsys, monkeypatch):
    """Text and JSON are those of the verb."""
    monkeypatch.chdir(tmp_path)
    log.save('log.csv')
    found = hd.compare('log.csv')
    assert main(['compare', 'log.csv', '--json', 'c.json']) == 0
    assert capsys.readouterr().out.strip() == str(found).strip()
    assert json.loads(Path('c.json').read_text()) == found.to_json()
    assert main(['effects', 'motor_leakage', '--json', 'e.json']) == 0
    assert capsys.readouterr().out.strip() == str(hd.effects('motor_leakage')).strip()
    assert json.loads(Path('e.json').read_text()) == hd.effects('motor_leakage').to_json()


@pytest.mark.parametrize('circuit, there, elsewhere', [
    ('test', ('prv_cracking', 'back_pressure', 'pump_lag'), ('valve_lag', 'cross_port_leakage')),
    ('closed', ('charge_pressure_loss', 'cross_port_leakage', 'pump_lag'),
     ('valve_lag', 'prv_cracking')),
    ('valve', ('valve_lag', 'cross_port_leakage', 'back_pressure'),
     ('pump_lag', 'charge_pressure_loss'))])
def test_effects_of_a_circuit(circuit, there, elsewhere, capsys):
    """Listed are those that a rig's circuit has a place for; another one is refused."""
    path = str(default_rig_file().with_name(f'{circuit}_rig.yaml'))
    listed = hd.effects(rig=path)
    assert {*there, 'motor_leakage'} <= {*listed.ids} < {*hd.effects().ids}
    assert not {*elsewhere} & {*listed.ids}
    assert main(['effects', '--rig', path]) == 0
    assert capsys.readouterr().out.strip() == str(listed).strip()
    assert hd.effects(there[0], rig=path).ids == there[:1]
    with pytest.raises(hd.InputError, match="has no place in 'circuit: "):
        hd.effects(elsewhere[0], rig=path)


class Frame(HTMLParser):
    """Collects what an iframe would show."""

    def __init__(self):
        super().__init__()
        self.page = ''

    def handle_starttag(self, tag, attrs):
        """Remember the page of a frame."""
        if tag == 'iframe':
            self.page = dict(attrs)['srcdoc']


def test_html_is_the_page(log):
    """The cell shows the page: whole, with its curves, and nothing of it from outside."""
    found = hd.compare(log)
    frame = Frame()
    frame.feed(found._repr_html_())
    assert frame.page.startswith('<!DOCTYPE html>') and 'id="curve-plots"' in frame.page
    assert f'{found.noise_ratio["motor_speed"]:.2f}' in frame.page
    assert 'src="http' not in frame.page and len(frame.page) < 3e6
    assert '<table' in hd.effects()._repr_html_() and '<dl' in hd.effects('prv_cracking')\
        ._repr_html_()


def test_frames(log):
    """A log goes to pandas and comes back the same; results have a row per signal."""
    pandas = pytest.importorskip('pandas')
    frame = log.to_frame()
    back = hd.read_log(frame.set_index('time[s]'))
    for name in log.channels:
        np.testing.assert_allclose(back.run[name], log.run[name], rtol=1e-12, atol=1e-15)
    table = hd.compare(log).to_frame()
    assert isinstance(table, pandas.DataFrame)
    assert set(table['signal']) == set(hd.compare(log).noise_ratio)


def test_dates_of_a_frame(log):
    """A column or an index of dates, with a time zone or as text, is the time."""
    pandas = pytest.importorskip('pandas')
    frame = log.to_frame()
    dates = pandas.Timestamp('2026-11-03 23:59:58') + pandas.to_timedelta(
        frame.pop('time[s]') - log.run.time[0], unit='s')
    for given in (frame.assign(time=dates), frame.assign(time=dates.dt.tz_localize('UTC')),
                  frame.assign(time=dates.astype(str)), frame.set_index(dates.rename(None)),
                  frame.assign(time=dates - dates[0])):
        np.testing.assert_allclose(hd.read_log(given).run.time, log.run.time - log.run.time[0],
                                   atol=1e-6)


def test_an_index_that_is_a_column_too_counts_once():
    pandas = pytest.importorskip('pandas')
    frame = pandas.DataFrame({'time[s]': np.arange(20.0), 'motor_speed[rpm]': np.arange(20.0)})
    assert len(hd.read_log(frame.set_index('time[s]', drop=False)).run) == 20


def test_a_frame_without_an_index():
    """As other libraries have them."""
    class Other(dict):
        columns = ('time[s]', 'motor_speed[rpm]')

    assert len(hd.read_log(Other(dict.fromkeys(Other.columns, np.arange(20.0)))).run) == 20


def test_without_pandas(log, monkeypatch):
    """One line says what to install."""
    monkeypatch.setitem(sys.modules, 'pandas', None)
    with pytest.raises(ImportError, match=r'pip install .hst_drive\[pandas\]'):
        log.to_frame()


def test_a_rig_is_saved_and_read(tmp_path):
    """What was added to a rig is in its file, and in the model."""
    rig = hd.load_rig().with_effects({'motor_leakage': {'conductance': '0.012 L/min/bar'}})
    rig.save(tmp_path / 'rig.yaml')
    again = hd.load_rig(tmp_path / 'rig.yaml')
    assert again.effects['motor_leakage']['conductance'] == pytest.approx(0.012e-5 / 60e3)
    assert 'motor_leakage.conductance = 0.012 L/min/bar' in str(again)


@pytest.mark.parametrize('place', ['.', 'no/log.csv'])
def test_where_no_log_can_be_saved(log, tmp_path, place):
    with pytest.raises(hd.InputError, match='cannot be written'):
        log.save(tmp_path / place)


def test_a_command_table_is_played():
    """Steady commands bring the model to its steady state, with the noise of its sensors."""
    time = np.arange(0.0, 20.0, 0.01)
    log = hd.simulate({'time[s]': time, 'pump_command[V]': 5.5 + 0 * time,
                       'pprv_command[V]': 2.0 + 0 * time})
    pressure = log.run['pump_outlet_pressure'][1500:]
    rig = hd.load_rig().rig
    assert pressure.std() == pytest.approx(rig.sensors['pump_outlet_pressure'].noise_std, rel=0.2)
    flow = log.run['motor_inlet_flow'][1500:].mean()
    turned = rig.motor.displacement * log.run['motor_speed'][1500:].mean()
    assert turned < flow == pytest.approx(turned, rel=0.1)


def test_losses_of_a_table_are_those_of_its_file(tmp_path):
    """The leakage of a made-up motor, from columns in memory and from a file."""
    speed, load = (axis.ravel() for axis in np.meshgrid([40.0, 80.0, 120.0], [50.0, 150.0]))
    size, leak, drag = 100e-6 / (2 * np.pi), 2e-12, 3.0
    pressure = (load + drag) / size
    flow = size * speed * np.pi / 30 + leak * pressure
    table = {'motor_displacement[cc/rev]': np.full(6, 100.0),
             'oil_temperature[degC]': np.full(6, 50.0), 'load_torque[N.m]': load,
             'motor_speed[rpm]': speed, 'supply_pressure[Pa]': pressure,
             'supply_flow[m^3/s]': flow}
    found = hd.losses(table).to_json()
    for row in found['rows']:
        assert row['resistances']['R_total'] == pytest.approx(1.0 / leak, rel=1e-6)
    path = tmp_path / 'bench.csv'
    path.write_text('\n'.join([','.join(table), *(
        ','.join(f'{value:.12g}' for value in row) for row in zip(*table.values()))]))
    assert str(hd.losses(path)).splitlines()[:3] == str(hd.losses(table)).splitlines()[:3]


@pytest.mark.parametrize('given, told', [
    ({}, 'has no columns'),
    ({'motor_speed[rpm]': range(20)}, 'no column time'),
    ({'time': range(20), 'motor_speed[rpm]': range(20)}, "'time' has no unit"),
    ({'time[s]': range(20), 'motor_speed': range(20)}, 'has no unit'),
    ({'time': [], 'motor_speed[rpm]': []}, 'only 0 rows'),
    ({'time[s]': range(20), 'motor_speed[rpm]': ['fast'] * 20}, 'other things than numbers'),
    ({'time[s]': range(20), 'motor_speed[rpm]': range(19)}, '19 values'),
    ({'time[s]': np.arange(20).astype('datetime64[s]'), 'motor_speed[rpm]': range(20)}, 'dates'),
    ({'time[s]': range(20), 'motor_speed[rpm]': [True] * 20}, 'logical values'),
    ({'time[s]': range(20), 'motor_speed[rpm]': [1j] * 20}, 'complex values'),
    ({'time[s]': [0, 1, 1, *range(3, 20)], 'motor_speed[rpm]': range(20)}, 'row 2'),
    (3, 'expected a path')])
def test_tables_that_cannot_be_used(given, told):
    """One line says what is wrong."""
    with pytest.raises(hd.InputError, match=told) as caught:
        hd.read_log(given)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('call, told', [
    (lambda: hd.compare(None), 'log: found NoneType, expected a path'),
    (lambda: hd.compare([]), 'there is none'),
    (lambda: hd.read_log({}, channels=5), 'channels: found int, expected the path'),
    (lambda: hd.adopt(None), 'diagnosis: found NoneType, expected what diagnose returned'),
    (lambda: hd.effects(5), 'effects: found 5, expected the id'),
    (lambda: hd.load_rig(5), 'rig: found int, expected the path'),
    (lambda: hd.load_rig().with_effects('motor_leakage'), 'expected a mapping'),
    (lambda: hd.load_rig().save(5), 'path: found int'),
    (lambda: hd.simulate('paper_step', effects=3), 'effects: found 3, expected ids'),
    (lambda: hd.simulate('paper_step', effects=['motor_leek']), "did you mean 'motor_leakage'"),
    (lambda: hd.simulate('paper_step', effects={'motor_leakage': None}), 'expected a mapping'),
    (lambda: hd.simulate('paper_step', effects=['valve_lag']), "has no place in 'circuit: open'"),
    (lambda: hd.simulate('paper_step', seed=-1), 'seed: found -1'),
    (lambda: hd.design(effects='motor_leakage'), 'at least two effects'),
    (lambda: hd.design(effects=['motor_leakage', 'pump_leakage'], duration='2 min'),
     "duration: found '2 min', expected a number"),
    (lambda: hd.losses(None), 'table: found NoneType, expected a path'),
    (lambda: hd.diagnose(3, progress='x'), 'log: found int'),
    (lambda: hd.losses({}, oil=None), 'oil: found None')])
def test_arguments_of_another_kind(call, told):
    """They get the line that a wrong file gets."""
    with pytest.raises(hd.InputError, match=told):
        call()


def test_parts_that_are_not_there(log):
    """A span without samples and a log that is none are refused."""
    with pytest.raises(hd.InputError, match='no samples from 1e.06 to 2e.06 s; it goes from'):
        log.between(1e6, 2e6)
    with pytest.raises(hd.InputError, match='log: found 1, expected 0 to 0'):
        hd.compare(log).curves(1)


@pytest.mark.parametrize('effect, told', [
    ('stiff_seal', 'expected an hst_drive.effects.Effect'),
    (hd.effects('motor_leakage').declared['motor_leakage'], 'already')])
def test_register_refuses(effect, told):
    """What does not fit, or would take the place of an effect of the catalogue, stays out."""
    before = hd.effects().ids
    with pytest.raises(hd.InputError, match=told):
        register(effect)
    assert hd.effects().ids == before


def test_a_log_counts_once(log):
    """A copy among the logs would judge what was fitted to it."""
    with pytest.raises(hd.InputError, match='same recording'):
        hd.diagnose(log, holdout=log)
    other = hd.simulate('paper_step', effects=LEAK, seed=2)
    names = [entry['log'] for entry in hd.compare([log, other]).to_json()['by_log']]
    assert len(set(names)) == 2
