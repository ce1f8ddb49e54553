# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Why a node does not start, in one line."""
from __future__ import annotations

import os
import re
import sys

from hst_drive.errors import InputError
from rclpy.exceptions import (InvalidParameterTypeException, InvalidParameterValueException,
                              ParameterException)
from rclpy.impl.implementation_singleton import rclpy_implementation

_PLACE = re.compile(r', at \S+:\d+')    # in rcl's own source
_WRONG_TYPE = re.compile(
    r"Trying to set parameter '(\S+)' to '(.*)' of type '(\w+)', expecting type '(\w+)'.*")
_WRONG_INPUT = (InputError, ParameterException, InvalidParameterTypeException,
                InvalidParameterValueException)
REFUSALS = (*_WRONG_INPUT, rclpy_implementation.RCLError, rclpy_implementation.UnknownROSArgsError)


def tell_refusal(role: str, error: Exception, started: bool) -> int:
    """
    Say why a node does not start; return its exit code, 2 for wrong input, 1 for the rest.

    What rcl complains of in a node that has ``started`` is raised again.
    """
    if wrong := isinstance(error, _WRONG_INPUT):
        told = _WRONG_TYPE.sub(r'parameter \1 is \2 (\3), expected \4', str(error))
    elif started:
        raise error
    else:
        told = _cannot_start(str(error))
    # Some messages say themselves whose they are.
    print(f"{role}: {told.removeprefix(f'{role}: ')}", file=sys.stderr, flush=True)
    return 2 if wrong else 1


def _cannot_start(text: str) -> str:
    """Return in one line what rcl or the middleware complain of at start, and what to do."""
    lines = (_PLACE.sub('', line).strip().rstrip(',') for line in text.splitlines())
    reason = '; '.join(filter(None, lines)).replace('error not set', 'no reason given')
    if os.environ.get('ROS_SECURITY_ENABLE', '').lower() == 'true':
        advice = ('ROS_SECURITY_ENABLE=true needs keys in ROS_SECURITY_KEYSTORE and a Fast DDS '
                  'with its security libraries, which ROS 2 by apt has and its wheels have not: '
                  'see docs/integration.md, Security')
    else:
        advice = ('mend what follows --ros-args, ROS_DOMAIN_ID (0 to 101) or the other ROS_ '
                  'variables')
    return f'RCLError: {reason}: {advice}'
