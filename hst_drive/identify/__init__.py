# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs as a fitting problem: models fitted to it, searched for and laid side by side."""
