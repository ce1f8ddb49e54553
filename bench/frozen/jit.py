# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Compile with numba where there is one; else plain Python."""
try:
    import numba
except ImportError:
    numba = None

COMPILED = numba is not None


def njit(function):
    """Return the function, compiled where numba is there."""
    return numba.njit(cache=True, error_model='numpy')(function) if COMPILED else function
