# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Tests that tell explanations apart: drawn, rehearsed, weighed by what they separate."""
from hst_drive.as_function import make_callable

make_callable(__name__)
