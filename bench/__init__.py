# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Benchmarks: each a module with one command that prints a table."""
import os

from hst_drive.cli import ONE_THREAD

# As ``hst-drive`` itself does.
for _name in ONE_THREAD:
    os.environ.setdefault(_name, '1')
