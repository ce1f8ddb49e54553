# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The speed controller of the drive: its law, its feed-forward, its way to standstill.

Margins and the choice of gains are in ``hst_drive.control.margins``, which needs SciPy and is
not loaded with the law.
"""
from hst_drive.control.feed_forward import PumpFeedForward
from hst_drive.control.pi import PiController
from hst_drive.control.safety import SafetySettings, Supervisor

__all__ = ['PiController', 'PumpFeedForward', 'SafetySettings', 'Supervisor']
