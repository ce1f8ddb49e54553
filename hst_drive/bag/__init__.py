# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings on disk: CSV files, rosbag2 folders and MCAP files; all of it works without ROS."""
