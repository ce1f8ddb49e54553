# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Campaigns on disk: a folder with logs is one; what lies beside them says how to read them.

The folder above a campaign is the machine; of a campaign in the fleet's own folder its name less
the day is, or that folder where nothing is left::

    fleet/rig_07/2026-03-14/drilling.csv, sweep.csv, drilling_holdout.csv
    fleet/rig_07/rig.yaml               (or beside the logs, or above; channels.yaml likewise)

A log with 'holdout' in its name is judged on. The date is that in the name of the folder, of a log
or of a folder above, or else when a bag began to record.
"""
from __future__ import annotations

from datetime import date, datetime, timezone
import hashlib
import os
from pathlib import Path
import re
from typing import NamedTuple, Sequence

import hst_drive
from hst_drive.errors import InputError
from hst_drive.rig import default_rig_file
from hst_drive.rig.yaml_file import read_yaml

_DATE = re.compile(r'(?<!\d)((?:19|20)\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])(?!\d)')
_HOLDOUT = re.compile('hold[-_ ]?out', re.IGNORECASE)
_CHUNK = 1 << 20


class Campaign(NamedTuple):
    """Logs of one drive: paths, the machine, and the day ('YYYY-MM-DD', '' if not known)."""

    name: str
    machine: str
    date: str
    logs: tuple[str, ...]
    holdout: tuple[str, ...]
    rig: str = ''
    channels: str = ''

    @property
    def files(self) -> tuple[str, ...]:
        """All that the diagnosis reads."""
        return (*self.logs, *self.holdout, *(path for path in (self.rig, self.channels) if path))


def find_campaigns(place: str | os.PathLike[str]) -> list[Campaign]:
    """
    Return the campaigns below a folder, or those that a list names.

    A list is a text file with a folder per line (relative to the file; # begins a remark). Raise
    InputError if there are no campaigns.
    """
    place = Path(place)
    if place.is_file():
        if place.suffix in ('.csv', '.mcap'):
            raise InputError(f'{place}: is a log; give the folder that it lies in, or a list of '
                             'folders')
        folders = [place.parent / line for line in _lines(place)]
        absent = [folder for folder in folders if not folder.is_dir()]
        if absent:
            raise InputError(f'{place}: names {absent[0]}, which is no folder')
        root, tops = os.path.abspath(place.parent), [os.path.abspath(top) for top in folders]
        if os.path.commonpath([root, *tops]) != root:
            # So that two machines of one name at two places stay two.
            root = os.path.commonpath([os.path.dirname(top) for top in tops])
    else:
        root, folders = os.path.abspath(place), [place]
    if not os.path.isdir(root):
        raise InputError(f'{place}: not found; expected a folder with campaigns, or a list of '
                         'them')
    found: dict[Path, Campaign] = {}
    for folder in folders:
        for below in _folders(folder):
            campaign = _campaign(below, Path(root))
            if campaign:
                found[below.resolve()] = campaign
    if not found:
        raise InputError(f'{place}: no logs (.csv, .mcap or rosbag2 folders) in it or below')
    return sorted(found.values())


def _lines(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f'{path}: cannot be read as a list of folders ({error})') from None
    return [line for raw in text.splitlines() if (line := raw.partition('#')[0].strip())]


def _folders(folder: Path) -> list[Path]:
    """Return a folder and all below it, but not what is inside of bags, hidden or ours."""
    found = [folder]
    for entry in sorted(folder.iterdir()):
        if entry.is_dir() and not entry.name.startswith('.') and not _is_bag(entry):
            found += _folders(entry)
    return found


def _is_bag(folder: Path) -> bool:
    return (folder / 'metadata.yaml').is_file()


def _campaign(folder: Path, root: Path) -> Campaign | None:
    logs = [str(entry) for entry in sorted(folder.iterdir())
            if entry.suffix.lower() in ('.csv', '.mcap') and entry.is_file()
            or entry.is_dir() and _is_bag(entry)]
    if not logs:
        return None
    held = tuple(path for path in logs if _HOLDOUT.search(Path(path).name))
    parts = Path(os.path.abspath(folder)).relative_to(root).parts
    name = '/'.join(parts) or folder.resolve().name
    machine = '/'.join(parts[:-1]) or _DATE.sub('', name).strip('-_. ') or root.resolve().name
    return Campaign(name, machine, _date(name, logs),
                    tuple(path for path in logs if path not in held), held,
                    _beside(folder, root, 'rig.yaml'), _beside(folder, root, 'channels.yaml'))


def _beside(folder: Path, root: Path, name: str) -> str:
    """Return a file beside the logs, or in the nearest folder above up to the fleet's."""
    for place in (folder, *folder.parents):
        if (place / name).is_file():
            return str(place / name)
        if os.path.abspath(place) == str(root):
            return ''
    return ''


def _date(name: str, logs: Sequence[str]) -> str:
    """Return the day in the name of the campaign or of a log, or that on which a bag began."""
    folder, *above = reversed(name.split('/'))
    # A folder further above may have a serial number that reads like a day.
    for text in (folder, *(Path(log).name for log in logs), *above):
        match = _DATE.search(text)
        if match and _is_day(day := '-'.join(match.groups())):
            return day
    for log in logs:
        stamp = _began(Path(log) / 'metadata.yaml') if os.path.isdir(log) else 0
        if stamp > 0:
            return datetime.fromtimestamp(stamp / 1e9, timezone.utc).strftime('%Y-%m-%d')
    return ''


def _is_day(text: str) -> bool:
    """Say whether the calendar has a day: it has no 30th of February."""
    try:
        date.fromisoformat(text)
    except ValueError:
        return False
    return True


def history_dates(diagnosis: object) -> dict[str, str]:
    """Return when the logs of a diagnosis were recorded, if that is told, and the day of today."""
    logs = diagnosis.get('logs') if isinstance(diagnosis, dict) else None
    paths = [Path(str(log)) for log in logs] if isinstance(logs, list) else []
    recorded = _date(paths[0].parent.as_posix(), list(map(str, paths))) if paths else ''
    return {**({'recorded': recorded} if recorded else {}),
            'adopted': datetime.now(timezone.utc).strftime('%Y-%m-%d')}


def _began(path: Path) -> int:
    """Return when a bag began, ns; 0 where that is not told, or simulated time."""
    try:
        stamp = read_yaml(str(path))['rosbag2_bagfile_information']['starting_time'][
            'nanoseconds_since_epoch']
        return int(stamp) if int(stamp) > 631_152_000_000_000_000 else 0    # 1990
    except (InputError, KeyError, TypeError, ValueError):
        return 0


def key_of(campaign: Campaign, asked: str = '') -> str:
    """
    Return what a result hangs on, as a digest: what the files hold, and this program's version.

    The same logs under another name are the same; a changed rig file is another campaign, and so
    is another question (``asked``).
    """
    digest = hashlib.sha256(f'{hst_drive.__version__}{asked}'.encode())
    rig = campaign.rig or str(default_rig_file())
    for role, paths in (('log', campaign.logs), ('holdout', campaign.holdout), ('rig', (rig,)),
                        ('channels', (campaign.channels,) if campaign.channels else ())):
        for path in paths:
            digest.update(f'\0{role}\0{Path(path).name}\0'.encode())
            _add(digest, Path(path))
    return digest.hexdigest()[:24]


def _add(digest, path: Path) -> None:
    for entry in [path] if path.is_file() else sorted(path.rglob('*')):
        if entry.is_file():
            with open(entry, 'rb') as file:
                while chunk := file.read(_CHUNK):
                    digest.update(chunk)
