# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Signals of which no row can be judged, and where a recording begins."""
from dataclasses import replace

from bench.campaigns import as_runs
from hst_drive.identify.model import Model
from hst_drive.identify.part import campaign_of
from hst_drive.measure.compare import compare
from hst_drive.measure.run import Run
from hst_drive.model import Drive
from hst_drive.report.comparison import text
from hst_drive.rig import default_rig
import numpy as np
import pytest

from ..diagnose import benches
from ..truth import make_campaign

TIME = np.arange(4000) * 0.005


def test_a_signal_without_a_usable_row_is_left_out_and_told():
    """At a creep no law tells how friction and load share the torque."""
    rig, runs, _ = as_runs(make_campaign(45, {}, on_datasheet=True))
    run = replace(runs[0], channels={**runs[0].channels,
                                     'motor_speed': 0.02 * runs[0]['motor_speed']})
    found = compare(Drive(rig), [run])
    assert 'load_torque' not in found.signals and 'motor_speed' in found.signals
    assert found.logs[0].unjudged == ('load_torque',)
    assert 'load_torque, of which no row can be judged' in text(found)


def test_a_log_at_rest_beside_one_that_turns_changes_nothing_of_a_part():
    """No row of it is judged, and so it has no floor of its own."""
    turning, rest = (benches.motor_bench(seed=seed) for seed in (1, 2))
    rest.channels['motor_speed'] = benches.NOISE['motor_speed'] * np.random.default_rng(
        0).standard_normal(len(rest))
    alone, both = (campaign_of(benches.motor_rig(), runs) for runs in (
        [turning], [rest, turning]))
    assert both.ratios(both.errors(Model()), True) == alone.ratios(alone.errors(Model()), True)


def cut(run, row):
    """Return what a recording holds from a row on."""
    return replace(run, time=run.time[row:] - run.time[row],
                   channels={name: values[row:] for name, values in run.channels.items()})


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [45, 46, 47])
def test_a_recording_may_begin_anywhere(seed):
    """Cut 30 ms after a step of the load, and while the speed moves to another set point."""
    rig, runs, held = as_runs(make_campaign(seed, {}, on_datasheet=True))
    drive = Drive(rig)
    for run in (runs[0], *held):
        steps = np.flatnonzero(np.abs(np.diff(run['pprv_command'])) > 0.3)
        moves = np.flatnonzero(np.abs(np.diff(run['speed_setpoint'])) > 0.3)
        whole = compare(drive, [run]).signals
        for row in (steps[2] + 3, steps[3] + 3, *(moves[1:3] + 20)):
            found = compare(drive, [cut(run, int(row))])
            # After a load step the first second is left out, and told.
            assert {span.why for span in found.logs[0].judged.left_out} <= {
                'start in motion', 'cavitation'}
            for name, entry in found.signals.items():
                assert entry.noise_ratio < 1.25 * max(whole[name].noise_ratio, 1.0), name


def test_a_plate_with_play_rests_where_many_rows_say():
    """One noisy row put it elsewhere, and there it stayed until the command moved."""
    rig = default_rig()
    play = {'pump_hysteresis': {'width': 0.35, 'softness': 0.0, 'spread': 0.0}}
    drive = Drive(rig, play)
    time = np.arange(0, 9.0, 0.01)
    inputs = {'pump_command': 5.8 + 0.5 * (np.abs(time - 1.5) < 0.5) - 0.02 * (time > 8.0),
              'pprv_command': np.full(len(time), 5.7),
              'oil_temperature': np.full(len(time), 323.0), 'load_disturbance': 0.0 * time}
    signals = drive.simulate(time, inputs, drive.initial_state(
        pump_command=5.8, pprv_command=5.7, speed=10.0))
    random = np.random.default_rng(2)
    size = {'pump_outlet_pressure': 3e4, 'motor_speed': 0.03, 'load_torque': 0.5}
    run = cut(Run('play', time, {
        **{name: inputs[name] for name in ('pump_command', 'pprv_command', 'oil_temperature')},
        **{name: signals[name] + noise * random.standard_normal(len(time))
           for name, noise in size.items()}}, 'play'), 400)
    assert compare(drive, [run]).signals['motor_speed'].noise_ratio < 1.3
