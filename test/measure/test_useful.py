# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that tell nothing are refused in one line; those that tell something are not."""
from dataclasses import replace

from hst_drive.errors import InputError
from hst_drive.measure.compare import compare, model_of
from hst_drive.measure.useful import refuse_useless
from hst_drive.model import Drive
from hst_drive.report.comparison import remarks
from hst_drive.rig import default_rig
import numpy as np
import pytest

from .synthetic import record

RIG = default_rig()


@pytest.fixture(scope='module')
def drilling():
    return replace(record(duration=20.0), source='drilling.csv')


def with_channels(run, change):
    return replace(run, channels={name: change(name, values)
                                  for name, values in run.channels.items()})


def refused(*runs):
    with pytest.raises(InputError) as it:
        refuse_useless(RIG, runs)
    assert '\n' not in str(it.value)
    return str(it.value)


def test_a_record_that_holds_one_number_in_each_reading(drilling):
    still = with_channels(drilling, lambda name, values: np.full_like(values, values[100]))
    assert refused(drilling, still).startswith('drilling.csv: every reading holds one number')
    with pytest.raises(InputError, match='every reading holds one number'):
        compare(Drive(RIG), [still])


def test_a_drive_at_rest(drilling):
    noise = np.random.default_rng(0)
    rest = with_channels(drilling, lambda name, values: values if name != 'motor_speed' else (
        0.016 * noise.standard_normal(len(values))))
    assert 'the drive never turns (motor_speed is 0.' in refused(rest, rest)
    # Stalled in one log, it turns in the other: what leaks then is worth having.
    refuse_useless(RIG, [rest, drilling])


def test_rows_that_are_too_far_apart(drilling):
    assert 'has a row each 1 s' in refused(with_rows(drilling, 100))
    milliseconds = replace(drilling, time=1000.0 * drilling.time)
    assert "name their unit ('time[ms]')" in refused(milliseconds)
    refuse_useless(RIG, [with_rows(drilling, 5)])


def test_compare_tells_of_rows_that_are_too_far_apart(drilling):
    told, = remarks(RIG, [with_rows(drilling, 100)])
    assert 'has a row each 1 s' in told
    assert remarks(RIG, [with_rows(drilling, 5)]) == []


def with_rows(run, every):
    return replace(run, time=run.time[::every], channels={
        name: values[::every] for name, values in run.channels.items()})


def test_rows_of_a_part_may_be_as_far_apart_as_they_like(drilling):
    bench = with_rows(drilling, 100)
    bench = replace(bench, channels={name: bench[name] for name in (
        'motor_inlet_pressure', 'motor_speed', 'load_torque') if name in bench})
    bench.channels['motor_torque'] = bench['load_torque'] / 20.0
    bench.channels.setdefault('motor_inlet_pressure', drilling['pump_outlet_pressure'][::100])
    refuse_useless(RIG, [bench])


def test_a_record_of_another_circuit_is_not_judged_by_what_the_test_rig_shares_with_it(drilling):
    closed = replace(drilling, channels={
        name: drilling[name] for name in ('pump_command', 'motor_speed', 'load_torque')} | {
            'line_a_pressure': drilling['pump_outlet_pressure']})
    told = refused(drilling, closed)
    assert 'drilling.csv: has the channel line_a_pressure' in told and '--rig' in told
    with pytest.raises(InputError, match="is of 'circuit: open'"):
        model_of(RIG, [closed])
    # An open circuit with more sensors than it needs.
    more = replace(drilling, channels={**drilling.channels, 'charge_pressure': np.arange(
        len(drilling), dtype=float)})
    refuse_useless(RIG, [more])
