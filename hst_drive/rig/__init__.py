# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What a rig is: its numbers in SI, their tolerances, and the strict loading of a rig file."""
from hst_drive.rig.load import default_rig, default_rig_file, load_rig, parse_rig
from hst_drive.rig.rig import Rig
from hst_drive.rig.tables import Curve, Surface

__all__ = ['Curve', 'Rig', 'Surface', 'default_rig', 'default_rig_file', 'load_rig', 'parse_rig']
