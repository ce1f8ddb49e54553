# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured campaigns of closed-circuit and valve-driven heads; it knows nothing of the product."""
