# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The watch: closed forms of its parts, quiet on sound units, right on units that change."""
from dataclasses import replace
from pathlib import Path

from bench.watch import drilling, SIGNALS, watch_unit
from hst_drive.bag import read_log
from hst_drive.effects import catalogue
from hst_drive.effects.slots import OF_OTHER_CIRCUITS
from hst_drive.model.part import PartModel
from hst_drive.rig import default_rig
from hst_drive.rig.fingerprint import Fingerprint
from hst_drive.watch import watch as watching
from hst_drive.watch.calibration import Calibration, LIMIT
from hst_drive.watch.characteristic import Characteristic
from hst_drive.watch.drive import Observer
from hst_drive.watch.naming import likely, Signatures
from hst_drive.watch.residuals import Balances, Residual
from hst_drive.watch.stream import Window
from hst_drive.watch.watch import Chart, DRIFT, THRESHOLD, Watch
import numpy as np
import pytest

CASES = Path(__file__).resolve().parents[3] / 'shared' / 'cases'
RIG = default_rig()
LEAK = catalogue()['motor_leakage'].parameters[0]


def test_learning_is_bayesian_least_squares():
    """Block after block comes to the closed form over all blocks."""
    random = np.random.default_rng(2)
    spread = {'a': 0.5, 'b': 2.0, 'c': 0.1}
    learnt = Calibration(spread)
    rows, values, deviation = random.standard_normal((40, 3)), [], 0.3
    true = np.array([0.3, -1.1, 0.05])
    for row in rows:
        value = float(row @ true + deviation * random.standard_normal())
        values.append(value)
        learnt.learn(Residual(value, deviation, 0.0, dict(zip('abc', row))))
    precision = np.diag([1 / s**2 for s in spread.values()]) + rows.T @ rows / deviation**2
    assert learnt.covariance == pytest.approx(np.linalg.inv(precision))
    assert learnt.mean == pytest.approx(np.linalg.solve(
        precision, rows.T @ np.array(values) / deviation**2))


def test_a_fingerprint_that_ties_quantities_learns_one_from_the_other():
    """The mean of a Gaussian pair, one of which is measured exactly, in closed form."""
    learnt = Calibration({'a': 0.5, 'b': 2.0}, {('a', 'b'): -0.6, ('b', 'a'): -0.6})
    learnt.learn(Residual(0.3, 1e-9, 0.0, {'a': 1.0}))
    assert learnt.mean == pytest.approx([0.3, -0.6 * 2.0 / 0.5 * 0.3])
    assert learnt.covariance[1, 1] == pytest.approx(2.0**2 * (1.0 - 0.6**2))
    assert learnt.fresh().covariance[0, 1] == pytest.approx(-0.6)


def test_what_no_unit_explains_stays_in_the_residual():
    learnt = Calibration({'a': 0.01})
    for _ in range(200):
        left = learnt.learn(Residual(1.0, 0.01, 0.0, {'a': 10.0}))
    assert learnt.unit[0] == pytest.approx(LIMIT * 0.01)
    assert left.value == pytest.approx(1.0 - 10.0 * LIMIT * 0.01)


def test_a_lasting_deviation_within_the_drift_never_alarms():
    random, chart = np.random.default_rng(3), Chart()
    for stamp in range(100_000):
        chart.add(0.5 * DRIFT + 0.5 * random.standard_normal(), stamp)
        assert not chart.failing


def test_a_jolt_does_not_alarm_and_a_jump_does_when_it_must():
    chart = Chart()
    chart.add(100.0, 1)
    assert not chart.failing
    for stamp in range(2, 20):
        chart.add(0.0, stamp)
    steps = 0
    while not chart.failing:
        chart.add(-3.0, 100 + steps)
        steps += 1
    assert steps == THRESHOLD / (3.0 - DRIFT) and chart.since == 100


@pytest.mark.needs_numba
def test_an_effect_moves_a_balance_or_is_said_not_to_be_watched():
    piece = next(drilling(RIG, 1, 1.0))
    time = np.arange(300) / 100
    window = Window(0, time, {name: values[:300] for name, values in piece.items()})
    balances, asked = Balances(RIG, SIGNALS), set()

    class Asked(PartModel):
        def terms(self, slot, known):
            asked.add(slot)
            return super().terms(slot, known)

    balances.model = Asked(RIG)
    balances.of(window, 1_000_000_000, 3_000_000_000)
    unseen = Signatures(PartModel(RIG)).unseen
    for name, effect in catalogue().items():
        if effect.searched == 'always' and name not in unseen and (
                effect.slot not in OF_OTHER_CIRCUITS):
            assert {slot for slot, _ in effect.terms} & asked, name
    assert {'pump_lag', 'pump_hysteresis', 'shaft_compliance'} <= set(unseen)


@pytest.mark.needs_numba
def test_hours_of_an_alarm_keep_few_blocks_and_are_named_anew(monkeypatch):
    """What is kept from an alarm does not grow with its length, nor does its name stay behind."""
    window = Window(0, np.arange(300) / 100, {
        name: values[:300] for name, values in next(drilling(RIG, 1, 1.0)).items()})
    balances = Balances(RIG, SIGNALS)
    sound = balances.of(window, 1_000_000_000, 3_000_000_000)
    worn = sound._replace(residuals={
        name: entry._replace(value=entry.value + 50 * (entry.noise + entry.floor))
        for name, entry in sound.residuals.items()})
    watch, named = Watch(Calibration(balances.spread), Signatures(PartModel(RIG))), []
    monkeypatch.setattr(watching, 'likely', lambda *given: named.append(watch.blocks) or ())
    for block in [sound] * 100 + [worn] * 5000:
        watch.add(block)
    assert named[0] < 110 and named[-1] > 4700
    assert len(watch._blocks) <= 61 and len(watch._before) <= 120


def test_a_broken_sensor_does_not_fill_the_range_without_end():
    known = Characteristic(PartModel(RIG))
    for step in range(5000):
        known.add(50e5, 4.0 * step, 0.0, 0.0)
        known.add(50e5, 10.0, 1e-5, 2.0)
    assert len(known._buckets) == len(known._counts) <= 1000
    assert known.at(50e5, 10.0)[:2] == pytest.approx([1e-5, 2.0], rel=0.01)


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [11, 12])
def test_units_within_tolerance_drill_without_alarm(seed):
    """``python -m bench.watch`` does this for hundreds of hours."""
    blocks, alarms = watch_unit(RIG, seed, 20.0)
    assert blocks > 1000 and alarms == []


@pytest.mark.needs_numba
@pytest.mark.parametrize('seed', [41, 43])
def test_a_leak_since_commissioning_that_the_make_swallows_is_alarmed(seed):
    """Another day of a commissioned machine: quiet when sound, and told what came meanwhile."""
    own = replace(RIG, fingerprint=Fingerprint({
        name: 0.12 * sigma for name, sigma in RIG.tolerances.items()}))
    worn = {'motor_leakage': {'conductance': 0.3 * LEAK.typical}}
    assert watch_unit(own, seed, 4.0)[1] == []
    assert watch_unit(own, seed, 4.0, worn, judged=RIG)[1] == []
    alarms = watch_unit(own, seed, 4.0, worn)[1]
    assert alarms and all('motor_leakage' in alarm for alarm in alarms)


@pytest.mark.needs_numba
@pytest.mark.parametrize('celsius, power', [(30.0, 0.5), (30.0, 1.0), (70.0, 0.5), (70.0, 1.0)])
def test_a_commissioned_machine_in_other_oil_is_healthy(celsius, power):
    """It drills in oil of some 50 degC, 20 K from where its numbers were learnt."""
    kelvin = celsius + 273.15
    own = replace(RIG, characterised_at=kelvin, fingerprint=Fingerprint(
        {name: 0.12 * sigma for name, sigma in RIG.tolerances.items()},
        conditions={'oil_temperature': (kelvin - 3.0, kelvin + 3.0)}))
    machine = replace(own, effects={'leakage_temperature': {'exponent': power}})
    assert watch_unit(machine, 41, 4.0, machine.effects, judged=own)[1] == []


def drilled(balances, rig, minutes, effects=None):
    """Return the blocks of a drive, each of two seconds."""
    blocks = []
    for piece in drilling(rig, 51, minutes, effects):
        for first in range(0, 1600, 200):
            window = Window(0, np.arange(300) / 100, {
                name: values[first:first + 300] for name, values in piece.items()})
            block = balances.of(window, 1_000_000_000, 3_000_000_000)
            blocks += [] if isinstance(block, str) else [block]
    return blocks


@pytest.mark.needs_numba
@pytest.mark.parametrize('off', [0.995, 1.01])
def test_a_leak_of_a_machine_that_is_not_quite_as_commissioned_is_named(off):
    """Its calibration stands at four sigma of its file: what came was unknown, or a flow meter."""
    own = replace(RIG, fingerprint=Fingerprint({
        name: 0.06 * sigma for name, sigma in RIG.tolerances.items()}))
    machine = replace(RIG, tolerances={}, calibration={'pump.displacement_vs_command': off})
    balances = Balances(own, SIGNALS)
    calibration = Calibration(balances.spread, balances.correlation)
    for block in drilled(balances, machine, 1.0):
        for residual in block.residuals.values():
            calibration.learn(residual)
    leak = {'motor_leakage': {'conductance': 0.8 * LEAK.typical}}
    first, *_ = likely(Signatures(balances.model), drilled(balances, machine, 0.4, leak),
                       calibration, {})
    assert first.effect == 'motor_leakage'
    assert first.size == pytest.approx(0.8 * LEAK.typical, rel=0.2)


@pytest.mark.needs_numba
@pytest.mark.parametrize('now', [1.6, 0.4])
def test_an_adopted_leak_that_grows_or_shrinks_is_named_with_its_whole_size(now):
    known = replace(RIG, effects={'motor_leakage': {'conductance': LEAK.typical}})
    signatures, balances = Signatures(PartModel(known)), Balances(known, SIGNALS)
    blocks = drilled(balances, replace(RIG, tolerances={}), 0.4, {
        'motor_leakage': {'conductance': now * LEAK.typical}})
    found = {entry.effect: entry.size for entry in likely(
        signatures, blocks, Calibration(balances.spread), {})}
    assert found['motor_leakage'] == pytest.approx(now * LEAK.typical, rel=0.25)


@pytest.mark.needs_numba
@pytest.mark.parametrize('growth', [0.0, 1.0])
def test_a_leak_that_grows_has_its_rate(growth):
    """In 12 minutes of a machine with its own file: nothing, or once its typical size."""
    sizes = LEAK.typical * (1.0 + growth * np.arange(36) / 36)
    own = replace(RIG, tolerances={}, fingerprint=Fingerprint({
        name: 0.12 * sigma for name, sigma in RIG.tolerances.items()}))
    signatures, balances, blocks = Signatures(PartModel(own)), Balances(own, SIGNALS), []
    for number, size in enumerate(sizes):
        piece = next(drilling(replace(RIG, tolerances={}), 60 + number, 0.34, {
            'motor_leakage': {'conductance': size}}))
        window = Window(0, np.arange(300) / 100, {
            name: values[500:800] for name, values in piece.items()})
        start = number * 20_000_000_000
        block = balances.of(window, 1_000_000_000, 3_000_000_000)
        blocks += [] if isinstance(block, str) else [
            block._replace(start=start, end=start + 2_000_000_000)]
    found = {entry.effect: entry for entry in likely(
        signatures, blocks, Calibration(balances.spread, balances.correlation), {})}
    rate, low, high = found['motor_leakage'].rate
    true = growth * LEAK.typical / 720.0
    assert low < true < high and high - low < LEAK.typical / 720.0
    assert (low > 0.0) == (growth > 0.0)


@pytest.mark.needs_numba
@pytest.mark.parametrize('effect, balance', [
    ('motor_leakage', 'motor_flow'), ('bearing_friction', 'motor_torque'),
    ('gearbox_loss', 'load_torque'), ('pump_command_offset', 'pump_flow'),
    ('torque_sensor_scale', 'torque')])
def test_an_effect_that_starts_is_named_within_seconds(effect, balance):
    """On a unit that is off its datasheet; the effect has its typical size."""
    _, alarms = watch_unit(RIG, 21, 7.0, {effect: {}}, begin=5.0)
    first = alarms[0]
    block = int(first.partition('block ')[2].partition(':')[0])
    assert 300 - 5 <= block <= 300 + 12
    assert balance in first and effect in first


@pytest.mark.skipif(not CASES.is_dir(), reason='the sample campaigns are not here')
@pytest.mark.parametrize('case, log, name', [
    ('no_effect', 'drilling', ''), ('no_effect', 'speed_sweep', ''),
    ('no_effect_other_unit', 'drilling', ''), ('no_effect_other_unit', 'open_loop', ''),
    ('worn_motor', 'drilling', 'motor_leakage'), ('dry_bearing', 'speed_sweep',
                                                  'bearing_friction'),
    ('warm_oil', 'speed_sweep', 'leakage_temperature')])
def test_recordings_by_another_model(case, log, name):
    """Sound units stay quiet; an effect that was there from the start shows all the same."""
    run = read_log(CASES / case / f'{log}.csv')
    signals = tuple(channel for channel in run.channels if channel != 'speed_setpoint')
    observer, last = Observer(RIG, signals), None
    for row, time in enumerate(run.time):
        stamp = round((1.0 + time) * 1e9)
        for channel in signals:
            observer.put(channel, stamp, float(run[channel][row]))
        for watched in observer.advance(stamp).watched:
            last = watched.verdict or last
            assert name or not last or not last.failing
    assert [entry.effect for entry in last.effects][:1] == ([name] if name else [])
