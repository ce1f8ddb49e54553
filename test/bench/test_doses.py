# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Foreign machines by their own files: air that shows in starts from rest alone, colder oil."""
from bench import doses_frozen
from bench.doses import day
from bench.frozen import campaign
from hst_drive.cli.commission import text
from hst_drive.diagnose.commission import commission
from hst_drive.diagnose.decide import diagnose
from hst_drive.rig import parse_rig
import pytest

MACHINE = 74        # its oil is below 10 bar while it starts, and hardly ever after
A_FIFTH = 0.2       # of the typical share of air


@pytest.fixture(scope='module')
def learnt():
    """Return what two healthy days tell of a machine."""
    sheet, first = day(MACHINE, 0)
    return commission(sheet, 'rig', [*first, *day(MACHINE, 1)[1]])


def test_a_fifth_of_air_is_told_by_the_machines_own_starts(learnt):
    unit = parse_rig(learnt.rig, 'unit')
    # Pressures are read to 0.16 bar; a start is predicted to a few times that.
    assert 0.2e5 < unit.fingerprint.starts['pump_outlet_pressure'] < 3e5
    assert 'starts from rest, the model errs by (rms): pump_outlet_pressure_bar' in text(learnt)
    found = diagnose(unit, day(MACHINE, 24, 'entrained_air', A_FIFTH)[1])
    assert [entry.id for entry in found.effects] == ['entrained_air']
    # Its bubbles are isothermal, the answer's perhaps adiabatic: at 10 bar they yield as much.
    share, absolute = found.effects[0].parameters['fraction'], 10.0
    alike = A_FIFTH * 0.015 * 1.4 * absolute**(1.0 / 1.4 - 1.0)
    assert share.low < alike < share.high


@pytest.mark.parametrize('number, changed', [(12, {'rougher': True}), (11, {'celsius': 38.0})])
def test_another_day_is_no_air(learnt, number, changed):
    unit = parse_rig(learnt.rig, 'unit')
    assert diagnose(unit, day(MACHINE, number, **changed)[1]).verdict == 'none'


def test_one_start_does_not_tell_how_starts_differ():
    sheet, logs = day(MACHINE, 0)
    assert 'start_error' not in commission(sheet, 'rig', logs[:1]).rig['commissioned']


@pytest.mark.parametrize('celsius', [22.0, 75.0])
def test_oil_is_stiffer_in_the_cold(celsius, monkeypatch):
    """Half a percent a kelvin, as mineral oil is; on the frozen generator, learnt at 50 degC."""
    sheet, first = doses_frozen.day(1, 0)
    unit = parse_rig(commission(sheet, 'rig', [*first, *doses_frozen.day(1, 1)[1]]).rig, 'unit')
    simulate, stiffer = campaign.simulate, 1.0 - 0.005 * (celsius - 50.0)
    monkeypatch.setattr(campaign, 'simulate', lambda here, base, *args: simulate(
        here, base._replace(bulk=stiffer * base.bulk), *args))
    assert diagnose(unit, doses_frozen.day(1, 2, celsius=celsius)[1]).verdict == 'none'
