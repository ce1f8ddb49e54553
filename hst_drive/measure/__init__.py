# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Measurements: one time base, named SI channels, noise, errors, and where a model fails."""
