# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for a diagnosis: quick, countable, and deadly where asked."""
import os
from pathlib import Path
import signal
import time

from hst_drive.fleet.task import failed, row_of

HEAD = 'time[s],pump_command[V]\n'


def make(root, machines, dates, text='0,1\n'):
    """Make small campaigns: a folder per machine and date."""
    for machine in range(machines):
        for day in range(dates):
            date = f'2026-{1 + day // 28:02}-{1 + day % 28:02}'
            folder = Path(root) / f'rig_{machine:02}' / date
            folder.mkdir(parents=True)
            (folder / 'drilling.csv').write_text(f'{HEAD}{machine},{day}\n{text}')
    return Path(root)


def answer(size=1e-12, effect='motor_leakage'):
    """Return a diagnosis with one effect."""
    value = {'value': size, 'low': 0.9 * size, 'high': 1.1 * size, 'unit': 'm^3/(s.Pa)'}
    return {'schema': 'hst_drive/diagnosis/1', 'verdict': 'missing_effect',
            'sentence': f'The model lacks {effect}.',
            'effects': [{'id': effect, 'parameters': {'conductance': value},
                         'error_removed': 1.0, 'indistinguishable_from': []}]}


def note(campaign):
    """Leave a mark that a campaign was worked on, and return how often it was so far."""
    folder = Path(campaign.logs[0]).parent
    marks = list(folder.glob('.mark*'))
    (folder / f'.mark{len(marks)}_{os.getpid()}').touch()
    return len(marks) + 1


def quick(campaign):
    """Answer at once."""
    note(campaign)
    time.sleep(0.005)
    return row_of(campaign, status='done', reason=None, diagnosis=answer())


def endless(campaign):
    """Work on it for longer than anybody waits."""
    note(campaign)
    time.sleep(3600.0)


def faulty(campaign):
    """Fail on a part of the campaigns, in two ways."""
    if campaign.name.endswith('-02'):
        return failed(campaign, 'no data')
    if campaign.name.endswith('-03'):
        raise ValueError('a slip')
    return quick(campaign)


def deadly(campaign):
    """Die of one campaign, always; and once of another."""
    times = note(campaign)
    if campaign.name == 'rig_01/2026-01-03' or times == 1 and campaign.name.endswith(
            'rig_00/2026-01-02'):
        os.kill(os.getpid(), signal.SIGKILL)
    return row_of(campaign, status='done', reason=None, diagnosis=answer())
