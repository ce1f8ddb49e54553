# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A real pump with labelled leaks, by the commands of its life: from files to files."""
import json

import pytest
import yaml

from .verbs import calls_of
from ..diagnose.test_real_pump import AT, LEAK, LOGS, MAKE

pytestmark = pytest.mark.skipif(not LOGS.is_dir(), reason='the recordings are not here')
commission, _ = calls_of('commission')
diagnose, _ = calls_of('diagnose')
adopt, _ = calls_of('adopt')


def test_commission_diagnose_adopt_and_diagnose_again(tmp_path, capsys):
    make, unit, leaky = (tmp_path / f'{name}.yaml' for name in ('make', 'unit', 'leaky'))
    answer = tmp_path / 'd.json'
    make.write_text(yaml.safe_dump(MAKE))

    def judged(name, rig):
        code, out, _ = diagnose(capsys, LOGS / f'{name}.csv', '--rig', rig, '--json', answer)
        assert code == 0
        return json.loads(answer.read_text()), out

    assert commission(capsys, LOGS / 'healthy_a.csv', '--rig', make, '-o', unit)[0] == 0
    assert judged('healthy_b', unit)[0]['verdict'] == 'none'
    warm, told = judged('warm', unit)
    assert not warm['effects'] and 'oil temperature' in told
    found, told = judged('leak_1', unit)
    assert 'Since it was commissioned the machine has got pump_leakage' in told
    size = found['effects'][0]['parameters']['conductance']['value']
    assert size * AT == pytest.approx(LEAK, rel=0.05)
    assert adopt(capsys, answer, '--rig', unit, '-o', leaky)[0] == 0
    for name in ('leak_1', 'leak_1_holdout'):
        again, told = judged(name, leaky)
        assert again['verdict'] == 'none' and not again['effects']
