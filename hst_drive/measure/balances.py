# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which balances a log of a part closes, and which channels would close one."""
from __future__ import annotations

from typing import Any, Callable, Container, Iterable

from hst_drive.channels import PRESSURES, TORQUES
from hst_drive.measure import equations
from hst_drive.measure.run import FEWEST, Run
from hst_drive.model.circuits import Balance, OF_A_LEAK
from hst_drive.rig import Rig
import numpy as np

SLOWEST = 0.5           # s between rows: a longer step is a table of operating points
_RESTLESS = 0.3         # of the variance: two rows before tell a motion, even a swing, better
_VARIES = 0.05          # of the largest value: less is noise about one operating point
_BACKWARDS, _SELDOM = 0.02, 0.01     # of the greatest speed; of the rows
FIXED_PUMP = 'pump.max_displacement_cc_rev'
_LIKELY = ('hydromotor torque', 'mass', 'pump flow', 'hydromotor flow')
_STROKES = ('pump_command', 'pump_displacement', FIXED_PUMP)


_INLET, _OUTLET = '|'.join(PRESSURES), '|'.join(PRESSURES[::-1])
_DRIVEN, _STROKE = 'pump_speed|pump.shaft_speed_rpm', '|'.join(_STROKES)
_SPEED, _FLOW = 'motor_speed', 'motor_inlet_flow'
_DISPLACEMENT = ('motor.displacement_cc_rev',)
_SWALLOWED, _PUMPED = 'oil that turns the hydromotor', 'oil delivered by the pump'
_BY_MOTOR, _BY_PUMP = 'formula_motor_flow', 'formula_pump_flow'


def _balance(name: str, equation: Callable[..., Any], signal: str, needs: tuple[str, ...],
             rig: tuple[str, ...], enters: str, place: str, formula: str = '', **more: Any
             ) -> Balance:
    return Balance(name, signal, enters, place, (), needs, formula, equation=equation, rig=rig,
                   **more)


BALANCES: dict[str, Balance] = {entry.name: entry for entry in (
    _balance('hydromotor torque', equations.hydromotor_torque, '|'.join(TORQUES),
             (_INLET, _SPEED), _DISPLACEMENT, 'torque', 'torque of the hydromotor',
             'formula_torque', id='motor_torque'),
    _balance('mass', equations.mass, 'motor_torque', (_SPEED,), ('motor.inertia_total_kg_m2',),
             'torque', 'torque on the mass', 'formula_torque', sign=-1.0, without=PRESSURES),
    _balance('load torque', equations.load, 'load_torque', ('pprv_command', _SPEED),
             ('loading',), 'load', 'load torque', 'formula_load', id='load_torque'),
    _balance('pump stroke', equations.stroke, 'pump_displacement', ('pump_command',),
             ('pump.displacement_vs_command',), 'pump_actuator', 'displacement of the pump',
             id='pump_displacement'),
    _balance('pump flow', equations.pump_flow, _FLOW, (_OUTLET, _DRIVEN, _STROKE), ('pump',),
             'flow', _PUMPED, _BY_PUMP, id='pump_flow'),
    _balance('pump torque', equations.pump_torque, 'pump_torque', (_OUTLET, _STROKE),
             ('pump',), 'torque', 'torque of the pump'),
    _balance('pump power', equations.pump_power, 'pump_power', (_OUTLET, _DRIVEN, _STROKE),
             ('pump',), 'torque', 'power of the pump'),
    _balance('hydromotor flow', equations.hydromotor_flow, _FLOW, (_INLET, _SPEED),
             _DISPLACEMENT, 'flow', _SWALLOWED, _BY_MOTOR, sign=-1.0, id='motor_flow'),
    _balance('hydromotor speed', equations.hydromotor_speed, _SPEED, (_INLET, _FLOW),
             _DISPLACEMENT, 'flow', _SWALLOWED, _BY_MOTOR, swept=True),
    _balance('flow through both', equations.flow_through_both, _SPEED,
             (_OUTLET, _DRIVEN, '|'.join(_STROKES[:2])), _DISPLACEMENT, 'flow', _PUMPED, _BY_PUMP,
             swept=True, without=(_FLOW,)),
    _balance('case drain', equations.case_drain, 'case_drain_flow', (_INLET, _SPEED),
             ('motor.leakage_L_min',), 'flow', _SWALLOWED, _BY_MOTOR, sign=-1.0,
             id='case_drain_flow', sheet=OF_A_LEAK),
    _balance('return line', equations.return_line, 'motor_outlet_pressure', (_INLET, _SPEED),
             _DISPLACEMENT, 'torque', 'return line'),
    _balance('line', equations.line, 'pump_outlet_pressure', ('motor_inlet_pressure',),
             ('line',), 'torque', 'pressure lost in the line', id='line_pressure'),
)}


def closed(run: Run, rig: Rig) -> dict[str, Balance]:
    """
    Return the signals that the other channels predict, each with its balance.

    Where pump and hydromotor could both predict the flow, the pump does, and the measured flow
    predicts the speed.
    """
    found: dict[str, Balance] = {}
    for balance in BALANCES.values():
        if lacking(balance, run, rig):
            continue
        signal = balance.channels(run)[0]
        if balance.name == 'hydromotor speed' and (
                found.get('motor_inlet_flow') is not BALANCES['pump flow']):
            continue
        if balance.name == 'line' and not ('motor_inlet_flow' in run or 'motor_speed' in run):
            continue
        if balance.name == 'return line' and not _returns(run):
            continue
        if signal not in found:
            found[signal] = balance
    return found


def _returns(run: Run) -> bool:
    """Say whether the outlet is a return line: none that drives, nor one that is an inlet, too."""
    inlet = next(run[name] for name in PRESSURES if name in run)
    speed, outlet = run['motor_speed'], run['motor_outlet_pressure']
    backwards = speed < -_BACKWARDS * np.nanmax(np.abs(speed))
    return float(np.mean(backwards | (outlet > inlet))) < _SELDOM


def lacking(balance: Balance, run: Container[str], rig: Rig) -> list[str]:
    """Return what a balance lacks, as texts; empty if it is closed."""
    lacks = []
    for group in balance.groups:
        if not any(name in run or ('.' in name and _given(rig, name)) for name in group):
            lacks.append(' or '.join(name for name in group if '.' not in name))
    if any(name in run for name in balance.without) and not lacks:
        # A mass may be driven by a hydromotor whose displacement is not given.
        if balance.name != 'mass' or _given(rig, 'motor.displacement_cc_rev'):
            lacks.append(f'no {balance.without[0]}')
    lacks += [f"'{name}' in the rig file" for name in balance.rig if not _given(rig, name)]
    return lacks


def _given(rig: Rig, key: str) -> bool:
    section, _, name = key.partition('.')
    if key == FIXED_PUMP and _given(rig, 'pump.displacement_vs_command'):
        # A pump that can be set stands anywhere: only its command, or its stroke, says where.
        return False
    return getattr(rig, section) is not None and (not name or name in getattr(rig, section).given)


def what_would_close(run: Run, rig: Rig, balances: Iterable[Balance] = ()) -> str:
    """Return the line for a log that closes no balance, of a circuit's own if they are given."""
    texts = []
    for balance in balances or (BALANCES[name] for name in _LIKELY):
        lacks = lacking(balance, run, rig)
        present = len(balance.needs) + 1 - sum("'" not in text for text in lacks)
        texts.append((len(lacks) if balances else -present, len(lacks),
                      f'{balance.name} lacks {", ".join(lacks)}'))
    texts.sort(key=lambda item: item[:2])
    listed = '; '.join(text for _, _, text in texts[:3])
    have = ', '.join(name for name in run.channels) or 'none but time'
    circuit = f" of 'circuit: {rig.circuit}'" if balances else ''
    whole = '' if balances else ' a replay of the whole drive needs pump_command and pprv_command;'
    return (f'{run.source}: its channels ({have}) close no balance{circuit}: {listed};{whole} '
            'name foreign columns with --channels')


def is_part(run: Run, rig: Rig) -> bool:
    """
    Say whether a log is judged balance by balance.

    It is if the rig file describes a part only, or if the log lacks a command of the whole drive
    and closes a balance without it.
    """
    if not rig.whole:
        return True     # so are all circuits but the open one
    return not {'pump_command', 'pprv_command'} <= set(run.channels) and bool(closed(run, rig))


def is_table(run: Run) -> bool:
    """Say whether the rows are operating points rather than samples of a motion."""
    if run.sample_time >= SLOWEST:
        return True
    for name in (*PRESSURES, 'motor_speed', 'pump_speed'):
        values = run.channels.get(name)
        if values is None:
            continue
        values = values[np.isfinite(values)]
        if len(values) >= FEWEST and values.std() > _VARIES * np.max(np.abs(values)):
            before = np.column_stack([values[1:-1], values[:-2], np.ones(len(values) - 2)])
            told = before @ np.linalg.lstsq(before, values[2:], rcond=None)[0]
            if np.mean((values[2:] - told)**2) > _RESTLESS * values.var():
                return True
    return False
