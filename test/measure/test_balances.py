# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which balances a log closes."""
from hst_drive.diagnose.decide import diagnose
from hst_drive.errors import InputError
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.measure.balances import closed, is_table
from hst_drive.measure.equations import case_drain, hydromotor_flow
from hst_drive.measure.part import PartReplay
from hst_drive.measure.run import Run
from hst_drive.model.part import PartModel
from hst_drive.rig import default_rig, parse_rig
import numpy as np
import pytest


def log(seconds, *channels):
    """Return a log at rest in its operating point, with a little noise."""
    values = {'pump_outlet_pressure': 60e5, 'motor_inlet_flow': 3.3e-4, 'motor_speed': 10.0,
              'load_torque': 150.0, 'pump_command': 5.6, 'pprv_command': 2.5}
    time = np.arange(0.0, seconds, 0.01)
    random = np.random.default_rng(0)
    return Run('log', time, {name: values[name] * (1 + 1e-3 * random.standard_normal(len(time)))
                             for name in channels}, 'log.csv')


def names(run: Run) -> dict[str, str]:
    """Return the name of the balance of the test rig that predicts each signal."""
    return {signal: balance.name for signal, balance in closed(run, default_rig()).items()}


def test_a_pump_that_can_be_set_is_not_taken_for_one_at_full_stroke():
    """Without command and stroke the flow is the hydromotor's alone to predict."""
    measured = ('pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'load_torque')
    found = names(log(10.0, *measured))
    assert 'pump flow' not in found.values()
    assert found['motor_inlet_flow'] == 'hydromotor flow'
    assert names(log(10.0, *measured, 'pump_command'))['motor_inlet_flow'] == 'pump flow'


def test_a_loading_unit_is_judged_by_its_command_and_speed():
    """Without any pressure, against the steady state that the load profile goes by."""
    run, rig = log(10.0, 'pprv_command', 'motor_speed', 'load_torque'), default_rig()
    assert names(run) == {'load_torque': 'load torque'}
    model = PartModel(rig)
    predicted = PartReplay(run, model).predict(model)['load_torque']
    assert predicted.mean() == pytest.approx(
        LoadingUnit.of(rig.loading).torque_of_command(2.5, 10.0), rel=1e-3)


def test_a_hydromotor_with_both_ports_leaks_and_loses_as_by_hand():
    """It turns either way and drives or is driven; its meter is at the inlet."""
    model = PartModel(parse_rig({'motor': {
        'displacement_cc_rev': 250, 'leakage_L_min': {'laminar_L_min_per_bar': 0.006},
        'mechanical_efficiency': {'coulomb_N_m': 8, 'viscous_N_m_s_per_rad': 0.5,
                                  'pressure_share': 0.035}}}))
    speed = np.array([12.0, 12.0, -12.0, -12.0])
    inlet, outlet = 1e5 * np.array([[140.0, 4.0, 5.0, 90.0], [5.0, 90.0, 140.0, 4.0]])
    known = model.complete({'motor_speed': speed, 'pressure': inlet, 'outlet_pressure': outlet})
    displacement, leakage = 250e-6 / (2 * np.pi), 1e-3 / 60 * 0.006 / 1e5
    ideal = displacement * (inlet - outlet)
    lost = 8 + 0.5 * 12 + 0.035 * abs(ideal)
    for found, true in ((model.motor_torque(known), ideal - lost * np.sign(speed)),
                        (hydromotor_flow(model, known, {}, None),
                         displacement * speed + leakage * inlet),
                        (case_drain(model, known, {}, None), leakage * (inlet + outlet))):
        np.testing.assert_allclose(found, true, rtol=2e-3)


def test_oil_of_a_parts_line_stiffens_under_pressure():
    """Its compressibility falls on a straight line, to 0.8 of the datasheet's at 200 bar."""
    rig = default_rig()
    model = PartModel(rig, {}, {'line.compressibility_under_pressure': 0.8})
    pressure = np.array([0.0, 50e5, 200e5])
    found = model.capacity(model.complete({'pump_pressure': pressure}))
    np.testing.assert_allclose(
        found, rig.line.volume / rig.line.bulk_modulus * np.array([1.0, 0.95, 0.8]))


def test_a_log_with_nothing_to_judge_on_is_refused():
    short = log(0.25, 'pump_outlet_pressure', 'motor_inlet_flow', 'motor_speed', 'pump_command',
                'pprv_command')
    with pytest.raises(InputError, match='log.csv: .*too short'):
        diagnose(default_rig(), [short])


@pytest.mark.parametrize('speeds', [4, 6, 8])
def test_a_grid_of_operating_points_is_a_table_however_fast_it_was_written(speeds):
    speed = np.tile(np.arange(1.0, speeds + 1), 6)
    pressure = np.repeat(np.arange(1.0, 7.0), speeds)
    order = np.random.default_rng(speeds).permutation(len(speed))
    for rows in (slice(None), order):
        assert is_table(Run('grid', 0.01 * np.arange(len(speed)), {
            'motor_speed': speed[rows], 'motor_inlet_pressure': 1e6 * pressure[rows]}))


def test_a_swing_at_a_seventh_of_the_sampling_rate_is_a_motion():
    """Stick-slip, say: rows differ much, but each follows from those before it."""
    time = 0.01 * np.arange(3000)
    random = np.random.default_rng(2)
    speed = np.maximum(1.0 + 1.2 * np.sin(2 * np.pi * time / 0.07), 0.0)
    assert not is_table(Run('slip', time, {
        'motor_speed': speed + 0.02 * random.standard_normal(len(time))}))
