# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The equation of each balance of an open circuit, for logs of a part and for the watch.

An equation gets the model, what is known (``measured_state``), the channels and the weak form in
which both sides are compared; it returns what the sensor would read, SI.
"""
from __future__ import annotations

from typing import Any, Callable, Mapping, NamedTuple

from hst_drive.channels import PRESSURES
from hst_drive.measure.start import resting
from hst_drive.model.part import Known, PartModel
import numpy as np

_READ = ('motor_speed', 'pump_speed', 'pump_command', 'pprv_command', 'oil_temperature',
         'viscosity_ratio')


class Weak(NamedTuple):
    """
    A weak form: what smooths, and what gives the equally smoothed rate of change (per s).

    ``time`` is that of the rows, s; None for operating points, where all has settled.
    """

    time: np.ndarray | None
    mean: Callable[[Any], Any]
    rate: Callable[[Any], Any]


def source_of(channels: Mapping[str, Any]) -> str:
    """Return the channel that tells the pressure at the pump; '' without one."""
    return next((name for name in PRESSURES[::-1] if name in channels), '')


def measured_state(model: PartModel, channels: Mapping[str, np.ndarray], creeping: float,
                   angle: np.ndarray | None = None) -> dict[str, Any]:
    """
    Return what the equations and effects may read: true values, where a reading is off.

    Parameters
    ----------
    model : PartModel
        The model.
    channels : mapping of str to ndarray
        Readings, SI.
    creeping : float
        Speed below which friction hangs on how it changes its sign, rad/s.
    angle : ndarray, optional
        Of the hydromotor's shaft, rad.

    """
    known: dict[str, Any] = {name: channels[name] for name in _READ if name in channels}
    known['creeping'] = creeping
    known.setdefault('oil_temperature', np.full(
        len(next(iter(channels.values()))), model.rig.characterised_at))
    if angle is not None:
        known['motor_angle'] = angle
    known = model.complete(known)
    source = source_of(channels)
    if source:
        reading = channels[source]
        known['pump_pressure'] = reading
        known['pump_pressure'] = reading - model.terms('pressure_reading', {
            **known, 'pressure': reading})
        known['pressure'] = known['pump_pressure'] if source == 'motor_inlet_pressure' else \
            channels.get('motor_inlet_pressure', known['pump_pressure'])
        if 'motor_outlet_pressure' in channels:
            known['outlet_pressure'] = channels['motor_outlet_pressure']
    if 'motor_inlet_flow' in channels:
        reading = channels['motor_inlet_flow']
        known['flow'] = reading - model.terms('flow_reading', {**known, 'flow': reading})
    elif 'pressure' in known and 'motor_speed' in known and model.motor_displacement:
        known['flow'] = (model.motor_displacement * known['motor_speed']
                         + model.motor_leakage(known))
    if source == 'pump_outlet_pressure' and 'motor_inlet_pressure' not in channels and (
            'flow' in known):
        known['pressure'] = known['pump_pressure'] - model.line_drop(known)
    return known


def _torque_reading(model: PartModel, known: Known, torque) -> Any:
    return torque + model.terms('torque_reading', {**known, 'load_torque': torque})


def hydromotor_torque(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the torque at the hydromotor's shaft."""
    return _torque_reading(model, known, weak.mean(model.motor_torque(known))
                           - model.inertia * weak.rate(known['motor_speed']))


def mass(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the torque that drives a mass: without oil all that its equation has is friction."""
    drive = weak.mean(channels.get('load_torque', 0.0) - model.motor_torque(known))
    return _torque_reading(model, known, drive + model.inertia * weak.rate(known['motor_speed']))


def load(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the torque with which the loading unit brakes."""
    torque = model.braking_torque(weak.time, channels['pprv_command'], known)
    return _torque_reading(model, known, torque)


def hydromotor_flow(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the flow into the hydromotor."""
    flow = model.motor_displacement * known['motor_speed'] + model.motor_leakage(known)
    return flow + model.terms('flow_reading', {**known, 'flow': flow})


def hydromotor_speed(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the speed that the flow into the hydromotor gives."""
    return (known['flow'] - model.motor_leakage(known)) / model.motor_displacement


def case_drain(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the leakage of the hydromotor."""
    return model.case_drain(known)


def return_line(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the pressure at the hydromotor's outlet."""
    return model.terms('back_pressure', known)


def line(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the pressure before the line."""
    pressure = channels['motor_inlet_pressure'] + model.line_drop(known)
    return pressure + model.terms('pressure_reading', {**known, 'pressure': pressure})


def stroke(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the pump's displacement."""
    if weak.time is not None:
        known = {**known, **resting(model, known, channels)}
    return model.stroke(weak.time, channels['pump_command'], known)


def _with_stroke(model: PartModel, known: Known, channels: Known, weak: Weak) -> dict[str, Any]:
    """Return what is known, and the displacement on which the pump stands."""
    if 'pump_displacement' in channels:
        found = channels['pump_displacement']
    elif 'pump_command' in channels and model.rig.pump.displacement is not None:
        found = stroke(model, known, channels, weak)
    else:
        found = model.factor('pump.displacement_vs_command') * model.rig.pump.max_displacement
    return {**known, 'displacement': found}


def pump_torque(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the torque that drives the pump."""
    return model.pump_torque(_with_stroke(model, known, channels, weak))


def pump_power(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the power that drives the pump."""
    return pump_torque(model, known, channels, weak) * model.pump_speed(known)


def _delivered(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    known = _with_stroke(model, known, channels, weak)
    return weak.mean(model.pump_flow(known)) - weak.mean(
        model.capacity(known)) * weak.rate(known['pump_pressure'])


def pump_flow(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the flow that the pump delivers into the line."""
    flow = _delivered(model, known, channels, weak)
    return flow + model.terms('flow_reading', {**known, 'flow': flow})


def flow_through_both(model: PartModel, known: Known, channels: Known, weak: Weak) -> Any:
    """Return the speed that the pump's flow gives the hydromotor."""
    return (_delivered(model, known, channels, weak)
            - weak.mean(model.motor_leakage(known))) / model.motor_displacement
