# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The speed controller of the drive: its law, its feed-forward and its margins."""
from hst_drive.control.feed_forward import PumpFeedForward
from hst_drive.control.margins import choose_gains, Margins, margins
from hst_drive.control.pi import PiController

__all__ = ['choose_gains', 'Margins', 'margins', 'PiController', 'PumpFeedForward']
