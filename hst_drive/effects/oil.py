# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Kinematic viscosity of mineral hydraulic oils.

Walther's equation as standardised in ASTM D341: ``log10(log10(nu + 0.7)) = a - b*log10(T)``
with nu in mm^2/s and T in K. The two constants follow from the viscosities at 40 and 100 degC;
the grade of ISO 3448 is the viscosity at 40 degC, and 100 degC values are those of mineral oils
with a viscosity index of about 95 to 100 (ASTM D2270).
"""
from __future__ import annotations

from functools import lru_cache

import numpy as np

_LOG_40_DEGC = np.log10(313.15)
# Mineral oil, where the rig file of a part tells nothing of its own: Pa, kg/m^3, grade.
BULK_MODULUS, DENSITY, GRADE = 1.4e9, 870.0, 'ISO VG 46'
# Grade: mm^2/s at 40 degC, mm^2/s at 100 degC; the same stand in config/oil_grades.yaml.
GRADES: dict[str, tuple[float, float]] = {
    'ISO VG 10': (10.0, 2.6), 'ISO VG 15': (15.0, 3.3), 'ISO VG 22': (22.0, 4.3),
    'ISO VG 32': (32.0, 5.4), 'ISO VG 46': (46.0, 6.8), 'ISO VG 68': (68.0, 8.7),
    'ISO VG 100': (100.0, 11.4), 'ISO VG 150': (150.0, 15.0), 'SAE 10W': (41.0, 6.6),
    'SAE 30': (93.0, 10.8), 'HVLP 46': (46.0, 8.1),
}


def viscosity(temperature, grade: str):
    """
    Return the kinematic viscosity in m^2/s.

    Parameters
    ----------
    temperature : float or ndarray
        K.
    grade : str
        Key of ``GRADES``.

    Raises
    ------
    KeyError
        If the grade is not known.

    """
    return walther(temperature, *GRADES[grade])


def walther(temperature, at_40_degc: float, at_100_degc: float):
    """
    Return the kinematic viscosity in m^2/s of an oil known at two temperatures.

    Parameters
    ----------
    temperature : float or ndarray
        K.
    at_40_degc, at_100_degc : float
        mm^2/s, above 0.3.

    """
    at_40, slope = _constants(at_40_degc, at_100_degc)
    temperature = np.clip(temperature, 233.15, 473.15)
    double_log = at_40 - slope * (np.log10(temperature) - _LOG_40_DEGC)
    return (10.0**(10.0**double_log) - 0.7) * 1e-6


def viscosity_ratio(temperature, reference: float, grade: str):
    """
    Return the viscosity over that at a reference temperature.

    Parameters
    ----------
    temperature : float or ndarray
        K.
    reference : float
        K.
    grade : str
        Key of ``GRADES``.

    """
    now = _at if np.ndim(temperature) == 0 else viscosity
    return now(temperature, grade) / _at(reference, grade)


@lru_cache(64)
def _at(temperature: float, grade: str) -> float:
    """Return the viscosity at a single temperature; a plant asks in each step."""
    return float(viscosity(temperature, grade))


def _constants(at_40_degc: float, at_100_degc: float) -> tuple[float, float]:
    """Return Walther's a (at 40 degC) and b."""
    at_40, at_100 = (np.log10(np.log10(value + 0.7)) for value in (at_40_degc, at_100_degc))
    return at_40, (at_40 - at_100) / (np.log10(373.15) - _LOG_40_DEGC)
