# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Oils by name: the viscosity grades of ``config/oil_grades.yaml`` or of a file of the user."""
from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches

from hst_drive.errors import InputError


def oil_of(grade: str, path: str | None = None) -> Callable:
    """
    Return the kinematic viscosity (m^2/s) over temperature (K) of a grade.

    Raises
    ------
    InputError
        If the grade or its numbers are not understood.

    """
    from hst_drive.effects.oil import walther
    from hst_drive.resources import share
    from hst_drive.rig.yaml_file import read_yaml

    source = str(path or share('config', 'oil_grades.yaml'))
    grades = read_yaml(source)
    names = {str(name).lower().replace(' ', ''): name for name in grades}
    name = names.get(grade.lower().replace(' ', ''))
    if name is None:
        near = get_close_matches(grade, map(str, grades), n=1)
        raise InputError(f'oil {grade}: not in {source}; '
                         + (f"did you mean '{near[0]}'?" if near else
                            f'known: {", ".join(map(str, grades))}'))
    pair = grades[name]
    if not (isinstance(pair, list) and len(pair) == 2 and all(
            isinstance(value, (int, float)) and not isinstance(value, bool) for value in pair)
            and 0.5 < pair[1] < pair[0] < 1e6):
        raise InputError(f"{source}: '{name}' is {pair!r}, expected [viscosity at 40 degC, at "
                         '100 degC] in mm^2/s, the second smaller')
    return lambda temperature: walther(temperature, float(pair[0]), float(pair[1]))
