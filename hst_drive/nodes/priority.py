# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Real-time scheduling of a node."""
from __future__ import annotations

from contextlib import suppress
import os

from hst_drive.errors import InputError


def go_before_others(priority: int) -> None:
    """
    Give this process real-time priority: the threads that it has, and all that come. 0: none.

    Raises
    ------
    InputError
        If the system or the user's limits do not allow it.

    """
    if not priority:
        return
    try:
        for thread in os.listdir('/proc/self/task'):
            with suppress(ProcessLookupError):      # it has just ended
                os.sched_setscheduler(int(thread), os.SCHED_RR, os.sched_param(priority))
    except (AttributeError, OSError) as error:
        raise InputError(
            f'parameter priority {priority}: {getattr(error, "strerror", None) or error}; '
            'it needs Linux, and root or an rtprio limit of the user '
            '(/etc/security/limits.conf); 0 goes without') from None
