# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Replay: a perfect model reaches its floor, whatever was recorded and however fast."""
from hst_drive.errors import InputError
from hst_drive.measure.compare import compare
from hst_drive.measure.floor import of_rough_load, replay_floor
from hst_drive.measure.replay import Replay
from hst_drive.measure.run import Run
from hst_drive.model import Drive, SensorBank
from hst_drive.model.steady import operating_point
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

RIG = default_rig()


def ratios(seeds, **settings):
    """Return the mean noise ratio by signal: ringing is rare events, one record scatters."""
    drive = Drive(RIG)
    found = [compare(drive, [record(seed, **settings)]).signals for seed in seeds]
    return {name: np.sqrt(np.mean([signals[name].noise_ratio**2 for signals in found]))
            for name in found[0]}


@pytest.mark.needs_numba
@pytest.mark.parametrize('settings', [
    {}, {'roughness': 0.0}, {'roughness': 0.5}, {'roughness': 3.0}, {'time_constant': 0.05},
    {'noise': 0.3}, {'noise': 3.0}, {'rate': 50}, {'rate': 500, 'duration': 15.0},
    {'leave_out': ('motor_speed',)}, {'leave_out': ('pump_outlet_pressure',)},
    {'leave_out': ('motor_inlet_flow',)}, {'leave_out': ('oil_temperature',)},
    {'roughness': 0.0, 'rate': 20}, {'rate': 20}, {'rate': 20, 'roughness': 3.0},
], ids=str)
def test_a_perfect_model_reaches_the_floor(settings):
    found = ratios(range(20, 26), **settings)
    assert len(found) == 4 - (settings.get('leave_out', ('oil_temperature',))[0]
                              != 'oil_temperature')
    for name, ratio in found.items():
        assert 0.9 < ratio < (1.2 if settings.get('rate') == 20 else 1.15), name


@pytest.mark.needs_numba
@pytest.mark.parametrize('roughness, rate', [(0.0, 200), (0.5, 200), (1.5, 200), (1.5, 100)])
@pytest.mark.parametrize('compliance, share, damping_time', [
    (1 / 400, 0.6, 0.004), (1 / 1200, 0.5, 0.002), (1 / 250, 0.7, 0.016)])
def test_rough_rock_behind_a_flexible_shaft(compliance, share, damping_time, roughness, rate):
    """The sensor feels the shaft swing; what shakes it is the load behind."""
    effects = {'shaft_compliance': {'compliance': compliance, 'load_side_share': share,
                                    'hardening': 0.0, 'damping_time': damping_time}}
    runs = [record(seed, effects=effects, roughness=roughness, rate=rate) for seed in (20, 21)]
    found = compare(Drive(RIG, effects), runs).signals
    for name in ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed'):
        assert found[name].noise_ratio < 1.4, name


@pytest.mark.needs_numba
@pytest.mark.parametrize('series', [0.0, 0.4])
def test_a_late_reading_of_the_speed_does_not_spoil_the_load(series):
    """The load depends on the speed that there was, not on what was read."""
    effects = {'speed_sensor_lag': {'time_constant': 0.1, 'series': series}}
    runs = [record(seed, effects=effects, roughness=0.5) for seed in range(20, 24)]
    found = compare(Drive(RIG, effects), runs).signals
    for name, entry in found.items():
        assert entry.noise_ratio < 1.25, name


LATE = {'speed_sensor_lag': {'time_constant': 0.1, 'series': 0.0}}


@pytest.mark.needs_numba
def test_only_a_speed_that_was_read_is_read_late():
    """The flow meter, which tells the speed where no sensor does, is not late."""
    run = record(20, effects=LATE, leave_out=('motor_speed',))
    for name, entry in compare(Drive(RIG, LATE), [run]).signals.items():
        assert entry.noise_ratio < 1.25, name


@pytest.mark.needs_numba
def test_a_late_speed_that_the_model_does_not_know_is_no_rough_load():
    effects = {'speed_sensor_lag': {'time_constant': 0.2, 'series': 0.0}}
    found = [Replay(record(seed, effects=effects, roughness=0.5), Drive(RIG)).roughness.std
             for seed in range(20, 24)]
    assert np.mean(found) == pytest.approx(0.5, rel=0.25)


@pytest.mark.needs_numba
def test_a_drive_that_leaves_all_bounds_does_not_make_the_load_smooth():
    run, drive = record(20), Drive(RIG, {'formula_load': {'coefficient_1': -1e3, 'speed_1': 2.0}})
    replay = Replay(run, drive)
    assert not np.isfinite(replay.predict(drive)['pump_outlet_pressure']).all()
    assert replay.roughness.std > 0.5


def test_what_friction_and_load_share_at_rest_is_not_judged():
    """A locked shaft may carry any torque; no law of friction at speed tells which."""
    run = record(21, duration=12.0)
    drive, rest = Drive(RIG), run.time > 8.0
    inputs = {'pump_command': np.where(rest, 0.0, run['pump_command']),
              'pprv_command': run['pprv_command']}
    signals = drive.simulate(run.time, inputs)
    stuck = rest & (np.abs(signals['motor_speed']) < 0.05)
    assert stuck.sum() > 200
    signals['load_torque'] = signals['load_torque'] + 30.0 * stuck
    noisy = SensorBank(RIG, 5).read({
        name: signals[name] for name in RIG.sensors if name in signals})
    replay = Replay(Run('rest', run.time, {**inputs, **noisy}), drive)
    error = replay.predict(drive)['load_torque'] - replay.run['load_torque']
    slow = np.abs(noisy['motor_speed']) < 0.5
    assert np.abs(error[slow]).max() < 1e-9 < np.std(error[~slow])


def test_a_perfect_model_reaches_the_floor_in_short():
    """The same with plain Python, short."""
    found = compare(Drive(RIG), [record(21, duration=6.0)]).signals
    for name, entry in found.items():
        assert 0.75 < entry.noise_ratio < 1.4, name
        assert entry.noise_std == pytest.approx(RIG.sensors[name].noise_std, rel=0.35)


@pytest.mark.needs_numba
def test_without_torque_the_record_shows_the_roughness():
    drive = Drive(RIG)
    floors = []
    for roughness in (0.0, 1.5):
        run = record(20, leave_out=('load_torque',), roughness=roughness)
        replay = Replay(run, drive)
        assert not replay.can_correct
        assert not replay.disturbance(drive).any()
        floors.append(replay_floor(replay, drive)['motor_speed'] / replay.noise['motor_speed'])
        # Nothing is missing in the model: what is left must not look like it.
        assert 0.7 < compare(drive, [run]).signals['motor_speed'].noise_ratio < 1.3
    assert floors[0] < 1.2 < 1.5 < floors[1]


@pytest.mark.needs_numba
@pytest.mark.parametrize('time_constant', [0.05, 0.3])
def test_without_torque_a_rough_load_moves_the_pressure_for_as_long_as_it_lasts(time_constant):
    """Its correlation after 0.1 s, against a twin in smooth rock; what is slow is motion."""
    rough, smooth = (record(20, leave_out=('load_torque',), roughness=roughness,
                            time_constant=time_constant) for roughness in (3.0, 0.0))
    moved = (rough['pump_outlet_pressure'] - smooth['pump_outlet_pressure'])[200:]
    alike = moved[:-10] @ moved[10:] / (moved @ moved)
    drive = Drive(RIG)
    found = of_rough_load(Replay(rough, drive), drive)['pump_outlet_pressure']
    assert alike - 0.3 < np.exp(-0.1 / found.time_constant) < alike


@pytest.mark.needs_numba
def test_floor_responds_to_the_torque_sensor():
    drive = Drive(RIG)
    floors = [replay_floor(Replay(run, drive), drive) for run in (
        record(20, noise=noise) for noise in (0.3, 1.0, 4.0))]
    for name in ('pump_outlet_pressure', 'motor_speed', 'load_torque'):
        quiet, usual, loud = (floor[name] for floor in floors)
        assert quiet < usual < loud


@pytest.mark.needs_numba
def test_gaps_are_bridged_and_not_judged():
    run = record(20, settled=True)
    random = np.random.default_rng(1)
    holes = {}
    for name, values in run.channels.items():
        holes[name] = values.copy()
        holes[name][random.uniform(size=len(run)) < 0.02] = np.nan
    holes['motor_speed'][500:550] = np.nan
    found = compare(Drive(RIG), [Run('holes', run.time, holes, 'holes.csv')]).signals
    for name, entry in found.items():
        assert np.isfinite(entry.rmse)
        assert entry.samples == np.isfinite(holes[name]).sum()
        # The bridged commands and speeds cost something, but little.
        assert 0.85 < entry.noise_ratio < 1.4, name


@pytest.mark.needs_numba
def test_a_hidden_effect_stands_out():
    run = record(20, effects={'motor_leakage': {'conductance': 3e-12}})
    result = compare(Drive(RIG), [run])
    assert result.signals['motor_speed'].noise_ratio > 5
    known = Drive(RIG, {'motor_leakage': {'conductance': 3e-12}})
    assert compare(known, [run]).signals['motor_speed'].noise_ratio < 1.3
    assert result.where[0].variable in ('pump_outlet_pressure', 'load_torque', 'pprv_command')


@pytest.mark.needs_numba
def test_a_late_channel_shows_its_delay():
    run = record(20, roughness=0.3)
    late = dict(run.channels)
    late['motor_inlet_flow'] = np.interp(run.time - 0.01, run.time, late['motor_inlet_flow'])
    found = compare(Drive(RIG), [Run('late', run.time, late, 'late.csv')]).logs[0].delays
    assert found['motor_inlet_flow'] == pytest.approx(0.01, abs=0.002)
    assert found['motor_speed'] == pytest.approx(0, abs=2e-3)


@pytest.mark.parametrize('leave_out, expected', [
    (('pump_command',), "channel 'pump_command' is missing; a replay of the whole drive needs"),
    (('pprv_command',), "channel 'pprv_command' is missing"),
    (('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque'),
     'nothing to compare; expected at least one of'),
])
def test_logs_that_cannot_be_replayed(leave_out, expected):
    with pytest.raises(InputError, match=expected) as caught:
        Replay(record(1, duration=1.0, leave_out=leave_out), Drive(RIG))
    assert str(caught.value).startswith('synthetic.csv: ')


def test_the_start_is_what_the_signals_tell():
    drive = Drive(RIG)
    run = record(3, duration=2.0, settled=True)
    whole = Replay(run, drive).start(drive)
    for place, name in ((1, 'pump_outlet_pressure'), (2, 'motor_speed')):
        assert whole[place] == pytest.approx(run[name][0], abs=4 * RIG.sensors[name].noise_std)
    for missing in ('pump_outlet_pressure', 'motor_speed', 'motor_inlet_flow'):
        part = Run(run.name, run.time, {name: values for name, values in run.channels.items()
                                        if name != missing}, run.source)
        found = Replay(part, drive).start(drive)
        np.testing.assert_allclose(found[:4], whole[:4], rtol=0.03)


@pytest.mark.parametrize('leave_out', [(), ('pump_outlet_pressure',)])
@pytest.mark.parametrize('share', [0.0, 0.3, 1.0])
def test_a_log_starts_with_what_its_gauge_reads_wherever_the_line_takes_pressure(share, leave_out):
    rig = default_rig()
    effects = {'line_loss': {'laminar': 6e9, 'turbulent': 0.0, 'viscosity_share': 0.0,
                             'upstream_share': share}}
    drive, time = Drive(rig, effects), np.arange(0.0, 40.0, 0.01)
    point = operating_point(drive, 10.0, 100.0)
    commands = {'pump_command': np.full(len(time), point.pump_command),
                'pprv_command': np.full(len(time), point.pprv_command)}
    exact = drive.simulate(time, commands, point.state.copy())
    run = Run('steady', time[:1000], {name: values[-1000:] for name, values in {
        **commands, **{name: exact[name] for name in (
            'pump_outlet_pressure', 'motor_inlet_pressure', 'motor_speed')}}.items()
        if name not in leave_out}, 'steady.csv')
    found = Replay(run, drive).predict(drive)['motor_inlet_pressure']
    # The line takes 20 bar.
    assert np.abs(found - run['motor_inlet_pressure']).max() < 0.2e5


def test_noise_of_the_last_samples_is_no_load():
    drive = Drive(RIG)
    ends, middles = [], []
    for seed in range(8):
        run = record(seed, duration=6.0, roughness=0.0)
        found = Replay(run, drive).disturbance(drive)
        ends.append(found[-20:])
        middles.append(found[280:320])
    assert np.std(ends) < 4 * np.std(middles) + 0.02


def test_a_reading_at_the_end_of_its_range_says_there_or_beyond():
    drive = Drive(RIG)
    run = record(3, duration=3.0)
    low, high = RIG.sensors['pump_outlet_pressure'].range
    channels = dict(run.channels)
    pressure = channels['pump_outlet_pressure'].copy()
    pressure[100:120], pressure[200:220] = low, high
    channels['pump_outlet_pressure'] = pressure
    replay = Replay(Run('ends', run.time, channels, 'ends.csv'), drive)
    for model, below, above in ((low - 1e5, True, False), (high + 1e5, False, True)):
        seen = replay.readings.as_read('pump_outlet_pressure', np.full(len(run), model))
        assert np.all((seen[100:120] == low) == below)
        assert np.all((seen[200:220] == high) == above)
        assert np.all(np.delete(seen, np.r_[100:120, 200:220]) == model)


def test_a_reading_at_the_end_of_its_range_shows_no_noise():
    """A third of the pressure record stands at zero; what moves still tells the noise."""
    run = record(23, duration=12.0)
    pressure = run['pump_outlet_pressure'].copy()
    for start in (200, 600, 1000):
        pressure[start:start + 130] = 0.0
    clipped = Run(run.name, run.time, {**run.channels, 'pump_outlet_pressure': pressure},
                  run.source)
    stated = RIG.sensors['pump_outlet_pressure'].noise_std
    assert Replay(clipped, Drive(RIG)).noise['pump_outlet_pressure'] == pytest.approx(
        stated, rel=0.2)


@pytest.mark.needs_numba
def test_what_earlier_steps_do_is_that_of_the_drive_that_is_asked():
    """A plate that follows ten times as slowly moves less in half a row."""
    replay = Replay(record(20), Drive(RIG))

    def moves(effects):
        early = replay.half_a_row_early(Drive(RIG, effects))
        return [float(np.abs(moved['motor_inlet_flow']).max()) for _, moved in early][0]

    usual = moves({})
    assert moves({'pump_lag': {'time_constant': 1.0}}) < 0.5 * usual
    assert moves({}) == usual > 0.0
