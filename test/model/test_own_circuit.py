# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A circuit of one's own, of three equations: the integrator by another solver, and effects."""
import math

from hst_drive.model import circuits
from hst_drive.model.circuit_model import CircuitModel
from hst_drive.model.circuits import Circuit, Input, Part, State
from hst_drive.model.circuits.base import Balance
from hst_drive.rig import parse_rig
import numpy as np
import pytest
from scipy.integrate import solve_ivp

CC_REV = 1e-6 / (2.0 * math.pi)
KNOWN = circuits.circuits()


@pytest.fixture(autouse=True)
def own_circuit(monkeypatch):
    """Add a circuit of three equations, as CONTRIBUTING's recipe has it."""
    own = Circuit(
        id='own', title='a hydromotor on a measured pressure', hold=hold, equations=equations,
        numbers=lambda rig: {'motor_displacement': rig.motor.displacement,
                             'inertia': rig.motor.inertia},
        sections=('motor',), tables={}, scaled={'motor.inertia': 'inertia'},
        steps=lambda numbers: (1e-3, 1e-3),
        states=(State('motor_speed', 'rad/s', 'inertia'), State('motor_angle', 'rad')),
        held_inputs=(Input('valve_command'),),
        inputs=(Input('pump_outlet_pressure'), Input('motor_torque')),
        quantities=('motor_torque', 'inertia'),
        balances=(Balance('shaft', 'motor_torque', 'torque', 'torque at the shaft',
                          (Part('motor_torque', '', 'motor_speed', 'inertia'),),
                          needs=('motor_speed', 'pump_outlet_pressure')),))
    monkeypatch.setattr(circuits, 'circuits', lambda: {**KNOWN, 'own': own})


def hold(valve_command, interval, memory, p, on, cells, layout):
    """Return what holds for a row: nothing moves here."""
    return (valve_command,)


def equations(motor_speed, motor_angle, spool, pump_outlet_pressure, load, p, on, cells, layout):
    """Return acceleration, speed; torque and inertia."""
    motor_torque_loss = 3.0 * motor_speed
    # slot motor_torque_loss
    torque = pump_outlet_pressure * p[P_motor_displacement] - motor_torque_loss  # noqa: F821
    return ((torque - load) / p[P_inertia], motor_speed, torque, p[P_inertia])   # noqa: F821


def test_the_integrator_agrees_with_radau():
    """Three equations: the same rates by Radau of SciPy, and a closed form."""
    rig = parse_rig({'name': 'own', 'circuit': 'own', 'motor': {
        'displacement_cc_rev': 100, 'inertia_total_kg_m2': 0.5}})
    time = np.linspace(0.0, 2.0, 201)
    pressure = 50e5 + 30e5 * np.sign(np.sin(4.0 * time))
    found = CircuitModel(rig).run(time, {'pump_outlet_pressure': pressure}, {}, np.zeros(2))
    swept = 100 * CC_REV

    def rates(at, state):
        return [(np.interp(at, time, pressure) * swept - 3.0 * state[0]) / 0.5, state[0]]

    want = solve_ivp(rates, (0.0, 2.0), [0.0, 0.0], 'Radau', time, rtol=1e-9, atol=1e-9,
                     max_step=1e-3)
    np.testing.assert_allclose(found['motor_speed'], want.y[0], atol=1e-4 * want.y[0].max())
    torque = CircuitModel(rig).run(time, {'pump_outlet_pressure': pressure}, {
        'motor_speed': np.full(201, 7.0)})['motor_torque']
    np.testing.assert_allclose(torque, pressure * swept - 21.0)


def test_effects_enter_a_circuit_of_ones_own():
    """What reads only what it knows has a term, the others have none."""
    model = CircuitModel(parse_rig({'name': 'own', 'circuit': 'own', 'motor': {
        'displacement_cc_rev': 100, 'inertia_total_kg_m2': 0.5}}), compiled=False)
    assert model.enters('hydrodynamic_drag') and not model.enters('pump_leakage')
