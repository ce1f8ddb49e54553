# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The model of the page, effects and factors of the unit, and the rig file that it makes."""
from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field
import json
import math

from hst_drive.errors import InputError
from hst_drive.rig import parse_rig, Rig
from hst_drive.rig.schema import TOLERANCES


@dataclass(frozen=True)
class PageModel:
    """
    What is switched on.

    Attributes
    ----------
    effects : dict of str to dict of str to float
        Id to parameters, SI.
    factors : dict of str to float
        Factor on each quantity by which the unit differs from the rig that was given.

    """

    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Tell models apart."""
        return json.dumps([self.effects, self.factors], sort_keys=True)

    def as_json(self) -> dict:
        """Return it as the page knows it."""
        return {'effects': self.effects, 'factors': self.factors}


def read_model(content: object) -> PageModel:
    """
    Read a model that a page sent; bounds are for ``Base.rig`` to check.

    Raises
    ------
    InputError
        If it has another form.

    """
    if not isinstance(content, dict):
        raise InputError("model: expected a mapping with 'effects' and 'factors'")
    effects, factors = content.get('effects', {}), content.get('factors', {})
    if not isinstance(effects, dict) or not isinstance(factors, dict) or not all(
            isinstance(values, dict) for values in effects.values()):
        raise InputError("model: expected 'effects' and 'factors' as mappings")
    for key, value in factors.items():
        if key not in TOLERANCES:
            raise InputError(f"model: unknown factor '{key}'; known: {', '.join(TOLERANCES)}")
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not (
                0.2 <= value <= 5.0):
            raise InputError(f"model: the factor on '{key}' is {value!r}, expected a number from "
                             '0.2 to 5')
    return PageModel({str(name): dict(values) for name, values in effects.items()},
                     {str(key): float(value) for key, value in factors.items()})


class Base:
    """
    The rig that was given, without effects: what models are built on.

    Parameters
    ----------
    content : dict
        Mapping of the rig file.
    source : str
        Its file, for messages.

    """

    def __init__(self, content: dict, source: str):
        self.content = content
        self.source = source
        given = parse_rig(content, source)
        self.start = PageModel({name: dict(values) for name, values in given.effects.items()})
        bare = deepcopy(content)
        bare.pop('effects', None)
        self.bare = parse_rig(bare, source)

    def mapping(self, model: PageModel) -> dict:
        """Return the rig file of a model."""
        made = deepcopy(self.content)
        made['effects'] = {name: dict(values) for name, values in model.effects.items()}
        calibration = dict(made.get('calibration') or {})
        for key, factor in model.factors.items():
            if factor != 1.0 or key in calibration:
                calibration[key] = calibration.get(key, 1.0) * factor
        made['calibration'] = calibration
        return {key: value for key, value in made.items() if value or key not in (
            'effects', 'calibration')}

    def rig(self, model: PageModel) -> Rig:
        """
        Return the rig of a model.

        Raises
        ------
        InputError
            If an effect or a parameter is not known, or a value is outside its bounds.

        """
        source = self.source or 'rig'
        try:
            return parse_rig(self.mapping(model), source)
        except InputError as error:
            # Nobody wrote that into the file.
            raise InputError(str(error).replace(source, 'this page', 1)) from None

    def model_of(self, mapping: dict) -> PageModel:
        """Return the model that a rig file made of this base stands for."""
        before = self.content.get('calibration') or {}
        factors = {key: value / before.get(key, 1.0)
                   for key, value in (mapping.get('calibration') or {}).items()}
        effects = parse_rig(mapping, self.source).effects
        return PageModel({name: dict(values) for name, values in effects.items()},
                         {key: value for key, value in factors.items()
                          if not math.isclose(value, 1.0, rel_tol=1e-12)})
