# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Play between the command and the swash plate.

Hard, as of a worn joint, or soft, as of a magnet and a spool with friction; ``played``
in the kernel. Several plays in a row act as a bundle of plays of unlike widths: here two, of which
the plate follows the mean.
"""
from hst_drive.effects.base import Effect, Parameter


def play(width):
    """Return the width of the play, V."""
    return width


def soft(width, softness):
    """Return how softly the play takes hold."""
    return softness if width > 0.0 else 0.0


def spread(width, spread):
    """Return by which share of the width two plays differ from it."""
    return spread if width > 0.0 else 0.0


EFFECT = Effect(
    id='pump_hysteresis',
    title='play between command and swash plate',
    slot='pump_play',
    function=play,
    also=(('pump_play_softness', soft), ('pump_play_spread', spread)),
    equation='u_eff = min(max(u_eff, u - width/2), u + width/2); softer: Bouc and Wen, '
             'd(u - u_eff)/du = 1 - |2*(u - u_eff)/width|^(1/softness) on the way out; with '
             'spread the mean of two plays, of width*(1 - spread) and width*(1 + spread) (Prandtl '
             'and Ishlinskii)',
    parameters=(
        Parameter('width', 'V', 0.0, 3.0, 0.35,
                  'full width of the play'),
        Parameter('softness', '1', 0.0, 1.5, 0.2,
                  '0: hard play; 0.5: the square of Bouc and Wen; a bundle of plays of many '
                  'widths is softer still'),
        Parameter('spread', '1', 0.0, 0.9, 0.1,
                  '0: one play; else two that differ from it by this share of the width'),
    ),
    telltale='The same command gives less flow on the way up than on the way down, and small '
             'corrections do nothing.',
    source='Play operator: M. A. Krasnoselskii and A. V. Pokrovskii, Systems with Hysteresis, '
           'Springer 1989; soft: Y.-K. Wen, Method for random vibration of hysteretic systems, '
           'J. Eng. Mech. Div. ASCE 102 (1976); hysteresis of proportional controls: M. Jelali '
           'and A. Kroll, Hydraulic Servo-systems, Springer 2003; bundles of plays: M. Brokate '
           'and J. Sprekels, Hysteresis and Phase Transitions, Springer 1996.',
    shows_in=('motor_speed', 'motor_inlet_flow', 'pump_displacement'),
    starts=({'softness': 0.0, 'spread': 0.5},),
)
