# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The only place that imports rclpy: each node is a thin shell around the pure library."""
