# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the drive has to turn against: rock, steps, recorded torque, and the scenario of a run."""
from hst_drive.load.files import load_scenario, shipped_scenarios
from hst_drive.load.loading_unit import LoadingUnit
from hst_drive.load.scenario import parse_scenario, Scenario

__all__ = ['LoadingUnit', 'load_scenario', 'parse_scenario', 'Scenario', 'shipped_scenarios']
