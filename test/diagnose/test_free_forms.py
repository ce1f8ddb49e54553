# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""When something that is not listed is the better answer: made-up odds and noise ratios."""
from types import SimpleNamespace

from hst_drive.diagnose import free_forms, unlisted
from hst_drive.diagnose.free_forms import better, how_much_better, Trial
import pytest


class Best(SimpleNamespace):
    """A set with the noise ratio that it leaves, held out and fitted."""

    def _replace(self, fit):
        return Best(fit=fit)


def made_up(monkeypatch, odds):
    """Return a search that calls what lies above 1.25 unexplained; a fit is a noise ratio."""
    monkeypatch.setattr(free_forms, 'log_odds_of', lambda *_: odds)
    campaign = SimpleNamespace(
        commissioned_unit=False,
        ratios=lambda errors, part: {'motor_speed': 0.95 if part else errors})
    return SimpleNamespace(campaign=campaign, unexplained=lambda entry: {
        name: ratio for name, ratio in campaign.ratios(entry.fit.errors, False).items()
        if ratio > 1.25})


@pytest.mark.parametrize('odds, simpler, before, after, expected', [
    (8.0, False, 1.0, 1.0, True),       # far likelier
    (6.0, False, 1.0, 1.0, False),      # likelier, but not far
    (-6.0, True, 1.0, 1.0, True),       # one cause for several
    (-8.0, True, 1.0, 1.0, False),
    (0.0, False, 3.0, 1.1, True),       # something was left, and nothing is now
    (-3.0, False, 3.0, 1.1, False),
    (20.0, False, 6.0, 1.5, True),      # or less than a tenth of it
    (20.0, False, 3.0, 2.5, False),
    (-1.0, True, 1.5, 1.5, False)])     # what changes nothing is no answer: held-out rows are fine
def test_it_is_likely_and_leaves_little(monkeypatch, odds, simpler, before, after, expected):
    best, trial = (Best(fit=SimpleNamespace(errors=ratio)) for ratio in (before, after))
    search = made_up(monkeypatch, odds)
    left = search.unexplained(best)
    assert better(search, best, trial.fit, search.campaign, left, simpler) is expected


@pytest.mark.parametrize('shares, told', [
    ({'motor_speed': 0.62}, 'leaves 62 % less squared error of hydromotor speed'),
    ({'motor_speed': 0.02}, 'explains as much alone'), ({}, 'explains as much alone')])
def test_the_share_is_told_where_there_is_one(shares, told):
    search = SimpleNamespace(
        campaign=SimpleNamespace(commissioned_unit=False),
        taken=lambda *_: shares)
    assert how_much_better(search, Best(fit=None), None) == told


def test_of_what_passes_the_best_is_told_and_all_is_remembered(monkeypatch):
    monkeypatch.setattr(unlisted, 'better', lambda search, best, fit, *_: fit.passes)
    search = SimpleNamespace(campaign='logs', unlisted=[], score=lambda fit: fit.score)
    trials = [Trial(what, SimpleNamespace(score=score, passes=passes, light=lambda: 'fit'), None)
              for what, score, passes in (('fair', 3.0, True), ('best', 2.0, True),
                                          ('no answer', 1.0, False))]
    assert unlisted._best(search, None, trials, {}).what == 'best'
    assert search.unlisted == 3 * [('logs', 'fit')]
    assert unlisted._best(search, None, [], {}) is None
