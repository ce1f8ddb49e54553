# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Which physical effect a model lacks: calibrate, confirm every candidate, judge, decide."""
from hst_drive.as_function import make_callable

make_callable(__name__)
