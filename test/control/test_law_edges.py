# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The PI law and the feed-forward at their edges, worked by hand."""
import math

from hst_drive.control import PiController, PumpFeedForward
import pytest

WIDE = (-1e6, 1e6)


def commands(law, *errors, **more):
    """Return the commands for errors, one sample each."""
    return [law.update(error, 0.0, **more) for error in errors]


def test_the_limits_unless_others_are_given():
    assert commands(PiController(1.0, 0.0, 0.1), 10.5, 9.5, -0.5, 0.5) == [10.0, 9.5, 0.0, 0.5]
    assert commands(PiController(1.0, 0.0, 0.1, (2.0, 8.0)), 9.0, 1.0) == [8.0, 2.0]


@pytest.mark.parametrize('what', [
    {'kp': math.inf}, {'ki': math.inf}, {'ki': -1e-9}, {'kp': -1e-9}, {'sample_time': math.inf},
    {'sample_time': -0.1}, {'limits': (5.0, 4.0)}, {'tracking_time_constant': 0.0999},
    {'setpoint_rate_limit': -1.0}, {'tracking_time_constant': math.nan}])
def test_what_is_refused(what):
    with pytest.raises(ValueError, match='expected'):
        PiController(**{'kp': 1.0, 'ki': 1.0, 'sample_time': 0.1, 'limits': (0.0, 10.0), **what})


def test_what_is_just_accepted():
    law = PiController(0.0, 0.0, 1.5, (4.0, 4.1), tracking_time_constant=1.5,
                       setpoint_rate_limit=1e-9)
    assert commands(law, 5.0) == [4.0]
    PiController(0.0, 1.0, 2.0)
    PiController(1.0, 1.0, 2.0, tracking_time_constant=2.0)


def test_gains_that_make_no_sense_leave_the_old_ones():
    law = PiController(1.0, 1.0, 0.1, WIDE)
    for kp, ki in ((-1e-9, 1.0), (1.0, -1e-9), (math.inf, 1.0), (1.0, math.nan)):
        with pytest.raises(ValueError, match='not negative'):
            law.retune(kp, ki)
        assert (law.kp, law.ki) == (1.0, 1.0)
    law.retune(0.0, 0.0)
    assert (law.kp, law.ki) == (0.0, 0.0)


def test_new_gains_take_up_what_the_last_error_makes_and_act_from_then_on():
    law = PiController(1.0, 1.0, 0.5, WIDE)
    law.retune(4.0, 1.0)                                    # nothing was read yet
    assert commands(law, 2.0) == [8.0]                      # integral 1
    law.retune(1.0, 3.0)                                    # integral 1 + (4 - 1) * 2 = 7
    assert commands(law, 2.0, 2.0) == [9.0, 12.0]           # 2 + 7, 2 + 7 + 3 * 2 * 0.5
    law.reset()
    law.retune(2.0, 0.0)
    assert commands(law, 5.0) == [10.0], 'a reset forgets the last error'


@pytest.mark.parametrize('strategy, tracking, after', [
    ('none', None, 0.6), ('conditional_integration', None, 0.0),
    ('back_calculation', None, 0.2),        # (2 * 3 - 2 / 0.5) * 0.1, time constant kp / ki
    ('back_calculation', 1.0, 0.4),         # (2 * 3 - 2 / 1.0) * 0.1
    ('back_calculation', 0.8, 0.35)])       # (2 * 3 - 2 / 0.8) * 0.1
def test_what_is_clipped_off_and_the_integral(strategy, tracking, after):
    law = PiController(1.0, 2.0, 0.1, (0.0, 1.0), antiwindup_strategy=strategy,
                       tracking_time_constant=tracking)
    assert commands(law, 3.0, 0.0) == [1.0, pytest.approx(after)]


def test_drawing_back_without_a_proportional_part_takes_a_sample():
    law = PiController(0.0, 2.0, 0.5, (0.0, 1.0), antiwindup_strategy='back_calculation')
    # Integral 0, 3 (clipped to 1: 2 too much, drawn back within a sample), 1.
    assert commands(law, 3.0, 0.0, 0.0, -0.25, 0.0) == [0.0, 1.0, 1.0, 1.0, 0.75]
    still = PiController(1.0, 0.0, 0.5, (0.0, 1.0), antiwindup_strategy='back_calculation')
    assert commands(still, 3.0, 0.5) == [1.0, 0.5]
    given = PiController(1.0, 0.0, 0.5, (0.0, 1.0), antiwindup_strategy='back_calculation',
                         tracking_time_constant=2.0)
    assert commands(given, 3.0, 1.0) == [1.0, 0.5]          # drawn back by 2 / 2 * 0.5


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_clipped_command_integrates_what_leads_back_inside(sign):
    law = PiController(1.0, 1.0, 0.5, (-1.0, 1.0))
    law.reset(sign)
    law.update(0.0, 0.0)                                    # integral 1
    assert commands(law, 4.0 * sign) == [sign]              # clipped, held
    assert commands(law, -0.5 * sign) == [0.5 * sign]
    law.integral = 2.0 * sign
    assert commands(law, -0.5 * sign) == [sign]             # clipped, but comes back: 1.75
    assert law.integral == 1.75 * sign


def test_time_beyond_a_sample_counts_in_the_next_command():
    law = PiController(0.0, 1.0, 0.25, WIDE)
    assert commands(law, 2.0) == [0.0]
    assert law.update(2.0, 0.0, 1.0) == 2.0                 # 2 rad/s for 1 s
    assert law.update(2.0, 0.0) == 2.5                      # and for a sample more
    assert law.update(0.0, 0.0, 0.125) == 2.75              # half a sample: 2 * 0.125
    for strategy, more in (('none', 1.0), ('conditional_integration', 0.0)):
        law = PiController(1.0, 1.0, 0.25, (0.0, 1.0), antiwindup_strategy=strategy)
        assert commands(law, 3.0) == [1.0]
        law.update(0.0, 0.0, 0.5)
        assert law.integral == more * 3.0 * 0.5, strategy
    law.reset()
    assert law.update(0.25, 0.0, 9.0) == 0.25, 'what was before the reset does not count'
    # Clipped, but it comes back: all of the time counts.
    law = PiController(1.0, 1.0, 0.25, (0.0, 1.0))
    law.integral = 4.0
    assert law.update(-1.0, 0.0) == 1.0
    law.update(0.0, 0.0, 0.5)
    assert law.integral == 3.5


def test_the_set_point_goes_at_its_rate_both_ways_from_the_speed_that_is():
    law = PiController(1.0, 0.0, 0.5, WIDE, setpoint_rate_limit=2.0)
    assert law.update(10.0, 4.0) == 1.0                     # 4 rad/s and 2 * 0.5
    assert law.update(10.0, 0.0) == 6.0
    assert law.update(10.0, 0.0, 1.0) == 8.0                # twice the time
    assert law.update(0.0, 0.0) == 7.0
    assert law.update(7.25, 0.0) == 7.25
    law.reset()
    assert law.update(0.0, 3.0) == -1.0, 'a reset starts from the speed'


@pytest.mark.parametrize('lost', [(math.nan, 1.0), (1.0, math.nan), (math.inf, 1.0)])
def test_what_is_no_number_holds_the_command(lost):
    law = PiController(1.0, 1.0, 0.5, (2.0, 8.0))
    assert law.update(*lost) == 2.0, 'the smallest, before the first'
    assert law.update(5.0, 0.0) == 5.0 and law.update(*lost) == 5.0
    assert law.update(0.5, 0.0) == 3.0                      # 0.5 and 1 * 5 * 0.5


def test_a_start_from_a_command_is_once_and_within_the_limits():
    law = PiController(1.0, 1.0, 0.5, (2.0, 8.0))
    law.reset(9.0)
    assert law.command == 8.0 and commands(law, 1.0, 1.0, 0.0) == [8.0, 8.0, 7.5]
    law.reset(1.0)
    assert law.command == 2.0
    law.reset(0.0)
    assert commands(law, 1.0) == [2.0], '0 V is a command to start from'
    law.reset()
    assert law.command == 2.0 and commands(law, 3.0) == [3.0]
    forward = PiController(1.0, 1.0, 0.5, (0.0, 8.0), feed_forward=lambda setpoint: 3.0 * setpoint)
    assert forward.update(2.0, 1.0) == 7.0                  # 1 and 3 * 2
    forward.reset(4.0)
    assert forward.update(1.0, 1.0) == 4.0 and forward.update(1.5, 1.5) == 5.5


def test_the_feed_forward_at_the_ends_and_flats_of_its_table():
    # The pump must displace 2 / 10 of the set point.
    forward = PumpFeedForward([0.0, 1.0, 2.0, 4.0, 5.0, 6.0], [0.0, 0.0, 1.0, 1.0, 3.0, 3.0],
                              pump_speed=10.0, motor_displacement=2.0)
    assert [forward(speed) for speed in (-1.0, 0.0)] == [0.0, 0.0]
    assert forward(1e-12) == pytest.approx(1.0)             # the upper end of the dead band
    assert forward(2.5) == pytest.approx(1.5)
    assert forward(5.0) == 4.0, 'of a flat part the upper end'
    assert forward(10.0) == pytest.approx(4.5)
    assert forward(15.0) == 5.0, 'at full stroke the smallest command that gives it'
    assert forward(100.0) == 5.0
    offset = PumpFeedForward([1.0, 3.0], [0.5, 1.0], 10.0, 2.0)
    assert offset(1.0) == 1.0 and offset(2.5) == 1.0 and offset(3.75) == pytest.approx(2.0)
    assert offset(5.0) == 3.0 and offset(50.0) == 3.0
