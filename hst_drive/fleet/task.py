# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done with one campaign, wherever it runs; its answer is a row, also if it fails."""
from __future__ import annotations

from pathlib import Path
import time
from typing import Callable, Mapping

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import Campaign
from hst_drive.plain import plain

SCHEMA = 'hst_drive/fleet_row/1'


def row_of(campaign: Campaign, **rest: object) -> dict:
    """Return a row: what is known of a campaign, and how it ended."""
    return {'schema': SCHEMA, 'campaign': campaign.name, 'machine': campaign.machine,
            'date': campaign.date or None, 'logs': list(campaign.logs),
            'holdout': list(campaign.holdout), 'rig': campaign.rig or None, **rest}


def failed(campaign: Campaign, reason: str) -> dict:
    """Return the row of a campaign without an answer."""
    return row_of(campaign, status='failed', reason=' '.join(reason.split()), diagnosis=None)


def diagnose_campaign(campaign: Campaign) -> dict:
    """
    Read a campaign's logs, diagnose, and return the row.

    The files are read by whoever runs this: on a cluster all need the same folders.
    """
    return _row(campaign, lambda: {'diagnosis': _diagnosis(campaign)})


def commission_machine(campaign: Campaign) -> dict:
    """
    Return the row of a machine's first days: its own rig file as a mapping under 'unit'.

    Where something is missing in the logs of later ones, the first day alone counts.
    """
    return _row(campaign, lambda: _commissioned(campaign))


def track_campaign(campaign: Campaign,
                   effects: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict:
    """Return the row of a campaign with the sizes of its machine's ``effects`` (``track``)."""
    return _row(campaign, lambda: _tracked(campaign, effects[campaign.machine]))


def _row(campaign: Campaign, answer: Callable[[], dict]) -> dict:
    began, used = time.monotonic(), time.process_time()
    try:
        found = answer()
    except InputError as problem:
        return failed(campaign, str(problem))
    except Exception as problem:    # one campaign must not end all others
        return failed(campaign, f'{type(problem).__name__}: {problem} (not your input)')
    return row_of(campaign, status='done', reason=None, seconds=time.monotonic() - began,
                  cpu_seconds=time.process_time() - used, **found)


def _commissioned(campaign: Campaign) -> dict:
    from hst_drive.bag.campaign import read_logs
    from hst_drive.diagnose.commission import commission
    from hst_drive.rig import default_rig_file
    from hst_drive.rig.yaml_file import read_yaml

    source = campaign.rig or str(default_rig_file())
    rig = read_yaml(source)
    runs = read_logs(campaign.logs, campaign.channels or None)
    first = Path(campaign.logs[0]).parent
    alone = [run for run, path in zip(runs, campaign.logs) if Path(path).parent == first]
    refused = ''
    try:
        unit = commission(rig, source, runs).rig
    except InputError as problem:
        if len(alone) == len(runs):
            raise
        unit, refused = commission(rig, source, alone).rig, str(problem)
    return {'unit': plain(unit), 'refused': refused}


def _tracked(campaign: Campaign, effects: Mapping[str, Mapping[str, float]]) -> dict:
    from hst_drive.bag.campaign import read_logs
    from hst_drive.fleet.track import track
    from hst_drive.rig import load_rig

    return track(load_rig(campaign.rig), read_logs(
        (*campaign.logs, *campaign.holdout), campaign.channels or None), effects)._asdict()


def _diagnosis(campaign: Campaign) -> object:
    from hst_drive.bag.campaign import read_logs
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.diagnose.result import as_json
    from hst_drive.rig import load_rig

    rig = load_rig(campaign.rig)
    if not campaign.logs:
        raise InputError(f'{campaign.name}: all its logs are held out; at least one must not have '
                         "'holdout' in its name")
    runs = read_logs((*campaign.logs, *campaign.holdout), campaign.channels or None)
    return as_json(diagnose(rig, runs[:len(campaign.logs)], runs[len(campaign.logs):]))
