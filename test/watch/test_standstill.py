# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a drive stands, or creeps, is judged by its own size: a slow machine is no idle one."""
from dataclasses import replace

from hst_drive.errors import InputError
from hst_drive.measure.replay import Replay
from hst_drive.measure.useful import refuse_useless
from hst_drive.model import Drive
from hst_drive.rig import default_rig
from hst_drive.watch.residuals import Balances, Block
from hst_drive.watch.stream import Window
import numpy as np
import pytest

from ..measure.synthetic import record

RIG = default_rig()
SLOWER = 100.0
SPEED, TORQUE = 'motor_speed', 'load_torque'


def slower(rig):
    """Return the drive with a hydromotor so much larger, and all behind it geared to suit."""
    sensor = rig.sensors[SPEED]
    return replace(
        rig, motor=replace(rig.motor, displacement=SLOWER * rig.motor.displacement,
                           inertia=SLOWER**2 * rig.motor.inertia),
        loading=replace(rig.loading, gear_ratio=SLOWER * rig.loading.gear_ratio),
        sensors={**rig.sensors, SPEED: replace(sensor, noise_std=sensor.noise_std / SLOWER,
                                               resolution=sensor.resolution / SLOWER)})


def of_it(run):
    """Return what that drive would have recorded."""
    return replace(run, channels={**run.channels, SPEED: run[SPEED] / SLOWER,
                                  TORQUE: run[TORQUE] * SLOWER})


@pytest.fixture(scope='module')
def drilling():
    """Return a log in which the drive comes to rest on the way."""
    run = record(duration=20.0)
    slows = np.clip(np.abs(run.time - 10.0) - 1.0, 0.0, 1.0)
    return replace(run, channels={**run.channels, SPEED: run[SPEED] * slows}, source='slow.csv')


def test_a_slow_drive_turns_and_rests_as_a_fast_one(drilling):
    refuse_useless(slower(RIG), [of_it(drilling)])
    rests = [Replay(run, Drive(rig)).at_rest for rig, run in (
        (RIG, drilling), (slower(RIG), of_it(drilling)))]
    assert 0.05 < rests[0].mean() < 0.2
    assert np.mean(rests[0] != rests[1]) < 0.01
    noise = np.random.default_rng(0).standard_normal(len(drilling))
    still = replace(drilling, channels={**drilling.channels, SPEED: 0.016 * noise})
    for rig, run in ((RIG, still), (slower(RIG), of_it(still)), (slower(RIG), still)):
        with pytest.raises(InputError, match='never turns'):
            refuse_useless(rig, [run])


def test_the_watch_takes_no_slow_drive_for_one_at_rest(drilling):
    signals = tuple(drilling.channels)
    for begins, told in ((2, None), (8, 'standstill')):
        for rig, run in ((RIG, drilling), (slower(RIG), of_it(drilling))):
            rows = (run.time >= begins) & (run.time < begins + 3)
            window = Window(0, run.time[rows] - begins, {
                name: values[rows] for name, values in run.channels.items()})
            found = Balances(rig, signals).of(window, 1_000_000_000, 3_000_000_000)
            assert found == told if told else isinstance(found, Block)
