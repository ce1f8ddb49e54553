# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Hydrostatic rotary drive of a drill rig: model, nodes, and what the model lacks."""

__version__ = '0.1.0'
