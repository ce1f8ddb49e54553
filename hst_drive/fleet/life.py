# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A fleet from its logs to what is known of each machine.

Three rounds, each kept and none done twice: each machine's own file from its first days, a
diagnosis of every later campaign by that file, and the sizes of what was found on every date.
"""
from __future__ import annotations

from functools import partial
import hashlib
import json
import os
import re
from typing import Callable, Collection, Mapping, NamedTuple, Sequence

from hst_drive.errors import InputError
from hst_drive.fleet.campaigns import Campaign
from hst_drive.fleet.run import Progress, run_fleet
from hst_drive.fleet.store import Store
from hst_drive.fleet.task import (
    commission_machine, diagnose_campaign, row_of, track_campaign)
from hst_drive.fleet.track import to_follow
from hst_drive.report.files import write_yaml
from hst_drive.rig import load_rig, Rig

HEALTHY = 2     # first campaigns of a machine that tell what it is like when healthy


class Lives(NamedTuple):
    """
    What is known of a fleet.

    ``rows``: of each campaign, in order; ``units``: how each machine was commissioned (the file,
    or why not); ``sizes``: rows of ``track_campaign``, those that failed left out.
    """

    rows: list[dict]
    units: dict[str, str]
    sizes: list[dict]


def live(campaigns: Sequence[Campaign], store: Store, *,
         healthy: int = HEALTHY, limited: Collection[str] = (), workers: int = 0,
         scheduler: str = '', again: bool = False,
         progress: Callable[[Progress], None] = lambda progress: None) -> Lives:
    """
    Commission, diagnose and follow all machines.

    Parameters
    ----------
    campaigns : sequence of Campaign
        Of all machines. One whose rig file was commissioned already is judged by that.
    store : Store
        Keeps what is done.
    healthy : int
        So many first campaigns of a machine are taken as healthy; 0: none, all are judged by the
        make.
    limited : collection of str
        Effects with a limit: followed where the logs do not tell them from what was named.
    workers, scheduler, again, progress
        As for ``run_fleet``.

    """
    run = partial(run_fleet, store=store, workers=workers, scheduler=scheduler, again=again,
                  progress=progress)
    machines = _machines(campaigns)
    first = {name: days for name, own in machines.items()
             if (days := _first_days(own, healthy))}
    units = {name: 'none, judged by its make' + ': no dates, or only one' * bool(healthy)
             for name in machines}
    used: set[str] = set()      # names of the campaigns that a machine was commissioned on
    files: dict[str, str] = {}
    rows = run([_together(name, days) for name, days in first.items()], task=commission_machine,
               what='machines commissioned', asked=lambda campaign: 'unit')
    for row in rows:
        name = row['machine']
        units[name] = f"none, judged by its make: {row['reason']}"
        if row['status'] == 'done':
            files[name] = units[name] = written(store, name, row['unit'])
            days = first[name]
            if row.get('refused'):
                units[name] += f", of the first day alone: {row['refused']}"
                days = days[:1]
            used |= {day.name for day in days}
    own = [campaign._replace(rig=files.get(campaign.machine, campaign.rig))
           for campaign in campaigns]
    later = [campaign for campaign in own if campaign.name not in used]
    answers = {row['campaign']: row for row in run(later, task=diagnose_campaign)}
    found = [answers.get(campaign.name) or row_of(
        campaign, status='commissioned', reason=None, diagnosis=None) for campaign in own]
    follow = {}
    commissioned: set[str] = set()
    for name in machines:
        rig, given = _rig(own, name)
        units[name] = units[name] if name in files else given or units[name]
        if rig and rig.fingerprint:
            commissioned.add(name)
        follow[name] = to_follow([row for row in found if row['machine'] == name], rig,
                                 limited) if rig else {}
    done = {row['campaign'] for row in found if row['status'] != 'failed'}
    dated = [campaign for campaign in own if campaign.date and campaign.name in done
             and (follow[campaign.machine] or campaign.machine in commissioned)]
    sizes = run(dated, task=partial(track_campaign, effects=follow), what='campaigns followed',
                asked=lambda campaign: _question(follow[campaign.machine]))
    return Lives(found, units, [row for row in sizes if row['status'] == 'done'])


def _question(effects: Mapping[str, Mapping[str, float]]) -> str:
    return 'sizes of ' + json.dumps(effects, sort_keys=True)


def _machines(campaigns: Sequence[Campaign]) -> dict[str, list[Campaign]]:
    found: dict[str, list[Campaign]] = {}
    for campaign in campaigns:
        found.setdefault(campaign.machine, []).append(campaign)
    return found


def _first_days(own: Sequence[Campaign], healthy: int) -> list[Campaign]:
    """Return the campaigns to commission a machine on; at least one day is left to judge."""
    dated = sorted((campaign for campaign in own if campaign.date and campaign.logs),
                   key=lambda campaign: (campaign.date, campaign.name))
    days = [*dict.fromkeys(campaign.date for campaign in dated)]
    count = min(healthy, len(days) - 1)
    if count < 1 or any(map(_commissioned, {campaign.rig for campaign in own})):
        return []
    return [campaign for campaign in dated if campaign.date in days[:count]]


def _commissioned(rig: str) -> bool:
    try:
        return bool(rig) and load_rig(rig).fingerprint is not None
    except InputError:
        return True     # its campaigns will say what is wrong with it


def _together(name: str, days: Sequence[Campaign]) -> Campaign:
    logs = tuple(log for day in days for log in (*day.logs, *day.holdout))
    return days[0]._replace(name=name, logs=logs, holdout=())


def written(store: Store, name: str, unit: dict) -> str:
    """Write a machine's own rig file and return its path."""
    folder = store.folder / 'units'
    folder.mkdir(exist_ok=True)
    plain = re.sub(r'[^A-Za-z0-9._-]', '_', name)
    if plain != name:
        # Two machines may read alike without what no file system bears.
        plain += '-' + hashlib.sha256(os.fsencode(name)).hexdigest()[:8]
    path = folder / f'{plain}.yaml'
    write_yaml(unit, path)
    return str(path)


def _rig(campaigns: Sequence[Campaign], machine: str) -> tuple[Rig | None, str]:
    """Return the rig of a machine; and its file if that was commissioned before, or why none."""
    path = max(campaign.rig for campaign in campaigns if campaign.machine == machine)
    try:
        rig = load_rig(path)
    except InputError as problem:
        return None, f'none: {problem}'
    return rig, path if rig.fingerprint else ''
