# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as a terminal and the page show it."""
from hst_drive.diagnose.result import as_json, Diagnosis, Found, Step, Value
from hst_drive.identify.evidence import Probability
from hst_drive.report.diagnosis import text
from hst_drive.report.found_sections import effect_card
import pytest


@pytest.mark.parametrize('name, key, unit, said', [
    ('pressure_sensor_bias', 'bias', 'Pa', True),
    ('elastic_leakage', 'stretch', '1/Pa', False)])
def test_of_a_gauge_that_is_off_it_says_where_its_class_is_stated(name, key, unit, said):
    found = Diagnosis(
        verdict='missing_effect', sentence='Something is missing.',
        effects=(Found(name, {key: Value(12.0, 10.0, 14.0, unit)}, 0.9, ()),), ranking=(),
        ladder=(Step('datasheet', {}, {}),), not_observable={}, smallest={}, calibration=(),
        probability=Probability(0.0, 0.1, (((name,), 0.9),)), zeros=())
    assert ('zero_std_bar' in text(found)) is said
    assert ('zero_std_bar' in effect_card(as_json(found)['effects'][0])) is said
