# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drive as equations: balances, integration, operating points, sensors.

The papers, as the docstrings name them:

drill-drive paper
    Dynamics of a displacement-controlled hydrostatic drive of a blast-hole drill: variable pump,
    low-speed high-torque hydromotor, PPRV-braked loading pump. doi 10.1007/978-981-99-4270-1_4.
    Eqs. (1) to (8).
motor-loss paper
    A. K. Pandey, A. Kumar, N. Kumar: Analysis on the Steady-state Performance and Losses of a
    Bent-axis Type Hydraulic Motor Used in Heavy Earth Moving Machinery. International Journal of
    Fluid Power 22(3), 2021, 293-330, doi 10.13052/ijfp1439-9776.2231. Eqs. (1) to (15).
"""
from hst_drive.model.drive import Drive, OUTPUTS, STATES
from hst_drive.model.sensors import SensorBank, usual_sensors

__all__ = ['Drive', 'OUTPUTS', 'STATES', 'SensorBank', 'usual_sensors']
