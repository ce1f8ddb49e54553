# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A return line that is not free: what stands in it, and what its filter and pipe add."""
from hst_drive.effects.base import Effect, Parameter
from hst_drive.effects.slots import DRILLING_SPEED


def outlet(motor_speed, outlet_pressure, flow_share):
    """Return the pressure at the hydromotor outlet, Pa."""
    return outlet_pressure * (1.0 + flow_share * (abs(motor_speed) / DRILLING_SPEED - 1.0))


def loss(motor_speed, outlet_pressure, flow_share, loss_share):
    """Return by how much the pressure that the losses go with lies above the difference, Pa."""
    return loss_share * outlet_pressure * (
        1.0 + flow_share * (abs(motor_speed) / DRILLING_SPEED - 1.0))


EFFECT = Effect(
    id='back_pressure',
    title='the hydromotor discharges against a return pressure',
    slot='back_pressure',
    function=outlet,
    also=(('loss_pressure', loss),),
    equation='T = (P - P_out - (1 - eta(P_loss)) * P_loss) * D_m, '
             'P_loss = P - (1 - loss_share) * P_out, '
             'P_out = outlet_pressure * (1 + flow_share * (|omega| / (10 rad/s) - 1))',
    parameters=(
        Parameter('outlet_pressure', 'Pa', 0.0, 6e6, 4e5,
                  'gauge pressure at the hydromotor outlet, at 10 rad/s'),
        Parameter('flow_share', '1', 0.0, 0.6, 0.0,
                  'share of it that goes with the flow (filter, return pipe)', whole_drive=True),
        # On a bench without the gauge nobody could tell it from a higher pressure.
        Parameter('loss_share', '1', 0.0, 2.0, 0.0,
                  '0: losses follow the difference of the port pressures, 1: the inlet pressure, '
                  '2: their sum', whole_drive=True, needs='motor_outlet_pressure',
                  usual=(0.0, 1.0)),
    ),
    telltale='Pressure is too high by the same amount at every load; at every speed, too, unless '
             'the return line throttles.',
    source='Torque of a hydromotor from the difference of its port pressures: H. E. Merritt, '
           'Hydraulic Control Systems, Wiley 1967; ISO 4409. Laminar return line: the same.',
    shows_in=('pump_outlet_pressure', 'motor_inlet_pressure', 'motor_outlet_pressure',
              'motor_speed'),
    alike=('bearing_friction', 'pressure_sensor_bias'),
    starts=({'loss_share': 1.0},),
    formula_error=0.3,      # at low pressure nobody knows which losses it takes with it
    gauge='a pressure gauge in the return line',
)
