# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether stated probabilities hold: the arithmetic, on answers made to be right so often."""
import json
import math

from bench.reliability import answer, calibration_error, log_score, main
import pytest


def row(share, right, kind='single'):
    """Return a row with the truth (or, if not ``right``, something else) told with a share."""
    truth = {'none': [], 'single': ['leak'], 'unlisted': ['drag']}[kind]
    told = {'none': 0.0, 'unknown': 0.0, 'sets': [{'effects': ['lag'], 'probability': 1 - share}]}
    if not right:
        told['sets'] += [{'effects': ['air'], 'probability': share}]
    elif kind == 'single':
        told['sets'] += [{'effects': truth, 'probability': share}]
    else:
        told['none' if kind == 'none' else 'unknown'] = share
    return {'truth': {'kind': kind, 'effects': truth}, 'probability': told}


def test_answers_that_are_right_as_often_as_told_have_no_error():
    rows = [row(0.9, True, kind) for kind in ('none', 'single', 'unlisted')] * 3 + [
        row(0.9, False)]
    assert calibration_error([answer(entry) for entry in rows]) == pytest.approx(0.0)
    assert calibration_error([answer(row(0.9, False))]) == pytest.approx(0.9)


def test_the_log_score_is_that_of_the_truth():
    answers = [answer(row(0.8, True)), answer(row(0.6, True, 'none'))]
    assert log_score(answers) == pytest.approx(math.log(0.8 * 0.6) / 2)


def test_a_file_becomes_a_table_and_a_picture(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    path = tmp_path / 'rows.jsonl'
    path.write_text('\n'.join(json.dumps(row(0.97, right)) for right in (True, True, False)))
    main([str(path), '--plot', str(tmp_path / 'plot.png')])
    assert '0.97' in capsys.readouterr().out and (tmp_path / 'plot.png').stat().st_size > 1000
