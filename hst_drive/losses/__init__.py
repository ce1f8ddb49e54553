# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Steady-state losses of a hydraulic motor.

References
----------
Motor-loss paper: A. K. Pandey et al., losses of bent-axis hydro-motors of five sizes at three
oil temperatures. Its Eqs. (11) to (15) are the actual performance, from measured signals.

"""
from hst_drive.as_function import make_callable

make_callable(__name__)
