# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The estimator in whole runs: real processes, real DDS, and what the plant knows."""
from hst_drive.effects import catalogue
from hst_drive.rig import default_rig, default_rig_file
import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import get_typestore, Stores
import yaml

from .processes import messages, node, run, wait_for

rclpy = pytest.importorskip('rclpy')
BEGIN, SECONDS = 20.0, 38.0
LEAKAGE = 1.3e-12       # m^3/(s.Pa)
RIG = default_rig()


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Record changing rock; the hydromotor begins to leak in the middle."""
    folder = tmp_path_factory.mktemp('estimator') / 'bag'
    code, _, err = run('run', 'layered_ground', '-o', str(folder), '--duration', str(SECONDS),
                       '--effect', f'motor_leakage.conductance={LEAKAGE}', '--effects-from',
                       str(BEGIN), '--truth', '--topic', 'case_drain_flow')
    assert code == 0, err
    return folder


@pytest.fixture(scope='module')
def found(bag):
    """Return what the bag holds."""
    return read(bag)


def read(bag):
    """Return by topic the rows of time (s of the run) and numbers; words and verdicts."""
    store, rows, words, verdicts = get_typestore(Stores.ROS2_JAZZY), {}, [], []
    with Reader(bag) as reader:
        for connection, _, data in reader.messages():
            message = store.deserialize_cdr(data, connection.msgtype)
            stamp = message.header.stamp
            time = stamp.sec - 1 + 1e-9 * stamp.nanosec
            if connection.msgtype.endswith('DiagnosticArray'):
                words += [(time, status) for status in message.status]
                continue
            if connection.topic == '/drive/verdict':
                verdicts.append((time, *(list(getattr(message, name)) for name in (
                    'name', 'position', 'velocity', 'effort'))))
                continue
            if connection.msgtype.endswith('JointState'):
                numbers = (message.velocity[0], message.effort[0])
            elif connection.msgtype.endswith('FluidPressure'):
                numbers = (message.fluid_pressure - 101325.0,)
            elif connection.msgtype.endswith('Temperature'):
                numbers = (message.temperature,)
            else:
                numbers = (message.vector.x, message.vector.y, message.vector.z)
            rows.setdefault(connection.topic.removeprefix('/drive/'), []).append((time, *numbers))
    return {name: np.array(values) for name, values in rows.items()}, words, verdicts


def truth_at(rows, times):
    """
    Return volumetric and hydro-mechanical efficiency and leakage that the plant had.

    From its pressure and speed without noise, through its own tables and the hidden effect.
    """
    speed = np.interp(times, rows['truth/motor'][:, 0], rows['truth/motor'][:, 1])
    pressure = np.interp(times, *rows['truth/pump_outlet_pressure'].T)
    leak = RIG.motor.leakage(pressure, speed) + np.where(times > BEGIN, LEAKAGE * pressure, 0.0)
    turned = RIG.motor.displacement * speed
    return (turned / (turned + leak), RIG.motor.mechanical_efficiency(pressure, speed), leak,
            pressure)


def test_figures_are_the_truth_within_one_percent_steady_and_changing(found):
    rows, *_ = found
    times = rows['efficiency'][:, 0]
    volumetric, mechanical, _, pressure = truth_at(rows, times)
    # From the touch of the bit on: below 10 bar the torque sensor's noise alone is 1 %.
    drilling = times > 6.3
    assert drilling.sum() > 200 and np.ptp(pressure[drilling]) > 40e5
    measured = rows['efficiency'][drilling, 1:]
    for column, true in enumerate((volumetric, mechanical, volumetric * mechanical)):
        assert np.abs(measured[:, column] / true[drilling] - 1).max() < 0.01
    # And the model's stay those of the tables: beside a worn motor they are too good.
    late = times > BEGIN + 1
    assert np.all(rows['model_efficiency'][late, 1] - volumetric[late] > 0.005)


def test_uncertainties_come_with_every_figure_and_hold_the_truth(found):
    rows, *_ = found
    times, stated = rows['efficiency'][:, 0], rows['efficiency_uncertainty']
    assert np.array_equal(stated[:, 0], times)
    volumetric, mechanical, _, _ = truth_at(rows, times)
    drilling = times > 6.3
    for column, true in ((1, volumetric), (2, mechanical)):
        error = rows['efficiency'][drilling, column] - true[drilling]
        assert np.mean(np.abs(error) < 2 * stated[drilling, column]) > 0.95


def test_resistances_are_the_plants_once_the_range_was_visited(found):
    rows, words, _ = found
    # The buckets remember the time before the wear; at 10 bar the leakage is next to nothing.
    before = rows['leakage_resistance'][rows['leakage_resistance'][:, 0] < BEGIN]
    before = before[before[:, 0] > 8]
    assert len(before) > 4
    for time, value, model, uncertainty in before:
        fine = np.linspace(time - 1, time, 101)
        _, mechanical, leak, pressure = truth_at(rows, fine)
        assert value == pytest.approx((pressure / leak).mean(), rel=0.03)
        assert model == pytest.approx((pressure / leak).mean(), rel=0.01)
        assert 0 < uncertainty < value
    port = rows['port_resistance'][rows['port_resistance'][:, 0] < BEGIN]
    for time, value, *_ in port[port[:, 0] > 8]:
        fine = np.linspace(time - 1, time, 101)
        volumetric, mechanical, leak, pressure = truth_at(rows, fine)
        through = RIG.motor.displacement * np.interp(
            fine, rows['truth/motor'][:, 0], rows['truth/motor'][:, 1])
        drop = pressure * (1 - mechanical)
        assert value == pytest.approx((drop / through).mean(), rel=0.03)
    # All that this plant leaks goes to the case.
    drained = rows['external_leakage_resistance']
    drained = drained[(drained[:, 0] > 8) & (drained[:, 0] < BEGIN)]
    for time, value, *_ in drained:
        _, _, leak, pressure = truth_at(rows, np.linspace(time - 1, time, 101))
        assert value == pytest.approx((pressure / leak).mean(), rel=0.03)
    assert 'internal_leakage_resistance' not in rows
    reasons = [value.value for _, status in words if status.name.endswith('watch')
               for value in status.values if value.key == 'resistances']
    assert 'not valid yet' in reasons[0] and 'valid' in reasons


def test_the_watch_names_the_effect_within_seconds_and_points_to_the_section(found, bag):
    _, words, _ = found
    said = [(time, status) for time, status in words if status.name == '/drive/estimator: watch']
    assert {status.level for time, status in said if 3 < time < BEGIN} == {0}
    alarms = [(time, status) for time, status in said if status.level == 1]
    first, status = alarms[0]
    assert BEGIN < first <= BEGIN + 6
    assert 'fails since 20 s' in status.message
    assert 'motor_leakage' in status.message
    assert all('motor_leakage' in later.message for _, later in alarms)
    values = {value.key: value.value for value in alarms[-1][1].values}
    assert set(values['balances'].split(', ')) == {'hydromotor flow', 'case drain'}
    first, _, size = values['effects'].partition(' (conductance about ')
    assert first == 'motor_leakage'
    assert float(size.split()[0]) == pytest.approx(LEAKAGE * 6e9, rel=0.03)   # L/min/bar
    assert values['diagnose'] == f'hst-drive diagnose {bag}'
    low, high = float(values['section_from']) - 1, float(values['section_to']) - 1
    assert low < BEGIN < high <= SECONDS


def test_the_verdict_is_for_machines(found, bag):
    _, words, verdicts = found
    told = {time: status for time, status in words if status.name == '/drive/estimator: watch'
            and status.level < 2}
    # One for each block that is judged, and whoever reads joints by name reads this.
    assert [time for time, *_ in verdicts] == list(told)
    alarms = [verdict for verdict in verdicts if verdict[1]]
    assert [time for time, *_ in alarms] == [
        time for time, status in told.items() if status.level == 1]
    assert BEGIN < alarms[0][0] <= BEGIN + 6
    for time, names, sizes, shares, since in alarms:
        assert names[0] == 'motor_leakage' and 0.5 < shares[0] <= 1.0 + 1e-9
        effects = [name for name in names if not name.endswith('.rate')]
        assert names[:len(effects)] == effects
        explained = list(shares[:len(effects)])
        assert explained == sorted(explained, reverse=True)
        assert time - since[0] == pytest.approx(BEGIN, abs=2.0)
        assert len(names) == len(sizes) == len(shares) == len(since)
    _, names, rates, low, high = alarms[-1]
    assert rates[0] == pytest.approx(LEAKAGE, rel=0.03)
    # It came at once and stays as it is: no trend.
    place = names.index('motor_leakage.rate')
    assert low[place] < 0.0 < high[place] and low[place] < rates[place] < high[place]


def test_with_a_machines_own_file_what_came_since_is_told(tmp_path):
    """A leak that was there from the start of the log, of half its typical size."""
    sheet = yaml.safe_load(default_rig_file().read_text())
    tolerances = sheet['tolerances_1_sigma_relative']
    unit = tmp_path / 'unit.yaml'
    unit.write_text(yaml.safe_dump({**sheet, 'calibration': {}, 'commissioned': {
        'sigma_relative': {key: 0.1 * value for key, value in tolerances.items()},
        'correlation': np.eye(len(tolerances)).tolist(), 'day_to_day_share_of_tolerance': 0.1,
        'conditions': {}}}))
    leak = 0.5 * catalogue()['motor_leakage'].parameters[0].typical
    for hidden in ([], ['--effect', f'motor_leakage.conductance={leak}']):
        folder = tmp_path / f'bag_{len(hidden)}'
        code, _, err = run('run', 'layered_ground', '--rig', str(unit), '-o', str(folder),
                           '--duration', str(SECONDS), *hidden)
        assert code == 0, err
        _, words, verdicts = read(folder)
        alarms = [status for _, status in words
                  if status.name == '/drive/estimator: watch' and status.level == 1]
        assert bool(alarms) == bool(hidden)
        assert any(names for _, names, *_ in verdicts) == bool(hidden)
    _, names, sizes, *_ = verdicts[-1]
    assert names[0] == 'motor_leakage' and 'motor_leakage.rate' in names
    assert 0.5 * leak < sizes[0] < 1.1 * leak
    values = {value.key: value.value for value in alarms[-1].values}
    assert values['effects'].startswith('motor_leakage (conductance about')
    assert 'L/min/bar an hour' in values['trend']


def test_residuals_say_which_balance_and_how_much(found):
    rows, *_ = found
    late = rows['motor_flow_residual'][rows['motor_flow_residual'][:, 0] > BEGIN + 2]
    pressure = truth_at(rows, late[:, 0] - 0.5)[3]
    assert late[:, 1] == pytest.approx(LEAKAGE * pressure, rel=0.15)
    assert late[-1, 3] >= 1.0
    for name in ('pump_flow', 'motor_torque', 'load_torque'):
        assert rows[f'{name}_residual'][:, 3].max() < 1.0
    assert 'case_drain_flow_residual' in rows and 'line_pressure_residual' not in rows


def test_nothing_in_the_bag_is_nan_and_times_rise(found, bag):
    rows, *_ = found
    assert all(np.isfinite(values).all() for values in rows.values())
    times = [time for _, time, _ in messages(bag)]
    assert times == sorted(times)


def test_alone_it_tells_what_is_missing_and_bears_whatever_comes():
    """A rig of its own: readings with NaN, a jump back in time, a sensor that falls silent."""
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import Vector3Stamped
    from sensor_msgs.msg import FluidPressure, JointState

    context = rclpy.Context()
    rclpy.init(context=context)
    rig = rclpy.create_node('rig', context=context, namespace='drive')
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(rig)
    told, figures = [], []
    try:
        publishers = [rig.create_publisher(kind, name, 10) for kind, name in (
            (JointState, 'motor'), (FluidPressure, 'pump_outlet_pressure'),
            (Vector3Stamped, 'motor_inlet_flow'))]
        rig.create_subscription(
            DiagnosticArray, '/diagnostics',
            lambda message: told.extend(status.message for status in message.status), 100)
        rig.create_subscription(Vector3Stamped, 'efficiency', figures.append, 100)

        def play(first, speed, pressure, flow, until):
            """Send samples of 10 ms until a condition holds."""
            for step in range(3000):
                stamp = Time(sec=first + step // 100, nanosec=step % 100 * 10_000_000)
                joint = JointState(name=['motor'], position=[0.0], velocity=[speed],
                                   effort=[150.0])
                motor_pressure = FluidPressure(fluid_pressure=pressure)
                motor_flow = Vector3Stamped()
                motor_flow.vector.x = flow
                for message, publisher in zip((joint, motor_pressure, motor_flow), publishers):
                    message.header.stamp = stamp
                    if message is not motor_flow or flow:
                        publisher.publish(message)
                executor.spin_once(timeout_sec=0.01)
                if until():
                    return
            raise AssertionError(f'waited in vain; last said: {told[-3:]}')

        with node('estimator'):
            wait_for(lambda: (executor.spin_once(timeout_sec=0.05),
                              all(p.get_subscription_count() for p in publishers))[1])
            wait_for(lambda: (executor.spin_once(timeout_sec=0.05),
                              'not valid: no signal comes' in told)[1])
            play(100, 10.0, 60e5, 330e-6, lambda: len(figures) > 3)
            play(200, float('nan'), 60e5, 330e-6, lambda: 'not valid: no speed' in told)
            play(300, 10.0, 60e5, 0.0, lambda: 'not valid: no flow' in told)
            told.clear()
            play(50, 0.0, 60e5, 330e-6, lambda: any('standstill' in text for text in told))
            figures.clear()
            play(20, 10.0, 60e5, 330e-6, lambda: len(figures) > 3)
            assert all(10 < figure.header.stamp.sec < 60 for figure in figures)
            assert all(np.isfinite([figure.vector.x, figure.vector.y, figure.vector.z]).all()
                       for figure in figures)
    finally:
        rig.destroy_node()
        rclpy.shutdown(context=context)
