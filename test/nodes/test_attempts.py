# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""How often what was refused is tried again; no ROS here."""
from hst_drive.nodes.attempts import Attempts, LONGEST


def test_the_waits_double_and_end():
    attempts, now, waits = Attempts(7, 2.0), 100.0, []
    assert not attempts.is_due('a', now) and attempts.told('a') == ''
    for count in range(1, 7):
        said = attempts.refused('a', 'no file', now)
        assert said.startswith(f'(attempt {count} of 7 refused: no file), again in ')
        waits.append(float(said.split()[-2]))
        assert not attempts.is_due('a', now + waits[-1] - 1e-6)
        now += waits[-1]
        assert attempts.is_due('a', now) and not attempts.given_up()
    assert waits == [2.0, 4.0, 8.0, 16.0, LONGEST, LONGEST]
    assert attempts.refused('a', 'no file', now) == (
        '(given up: attempt 7 of 7 refused: no file)')
    assert attempts.given_up() and not attempts.is_due('a', now + 1e6)
    assert attempts.refusals == 7


def test_what_went_well_begins_anew_and_others_are_not_touched():
    attempts = Attempts(2, 1.0)
    attempts.refused('a', 'x', 0.0)
    attempts.refused('b', 'y', 0.0)
    attempts.forget('a')
    attempts.forget('never heard of')
    assert not attempts.is_due('a', 10.0) and attempts.is_due('b', 10.0)
    assert '1 of 2' in attempts.refused('a', 'x', 20.0)
    assert attempts.refusals == 3
