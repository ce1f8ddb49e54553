# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Saving what is readable of a bag whose recorder was killed, or whose file was cut or damaged."""
from __future__ import annotations

from operator import itemgetter
import os
from pathlib import Path
from typing import NamedTuple

from hst_drive.bag.kinds import by_number, is_mcap
from hst_drive.bag.mcap_bag import salvage_streams
from hst_drive.bag.mcap_sink import McapSink
from hst_drive.bag.stream import Stream
from hst_drive.bag.writer import BagWriter
from hst_drive.errors import InputError
import yaml

_NAMES = {
    'history': ('system_default', 'keep_last', 'keep_all', 'unknown'),
    'reliability': ('system_default', 'reliable', 'best_effort', 'unknown'),
    'durability': ('system_default', 'transient_local', 'volatile', 'unknown'),
    'liveliness': ('system_default', 'automatic', 'unknown', 'manual_by_topic', 'unknown'),
}


class Recovered(NamedTuple):
    """What was saved: messages, seconds of data, topics, and records that were beyond repair."""

    messages: int
    seconds: float
    topics: int
    damaged: int


def recover(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> Recovered:
    """
    Write all readable messages of a bag to a new rosbag2 folder.

    Parameters
    ----------
    path : path
        A rosbag2 folder, whole or not, or an .mcap file.
    folder : path
        The folder to create.

    Raises
    ------
    InputError
        If there is no MCAP file, nothing can be read, or the folder exists.

    """
    path = Path(path)
    files = sorted(path.glob('*.mcap'), key=by_number) if path.is_dir() else [path]
    if not path.exists():
        raise InputError(f'{path}: no such file or folder')
    if not files or not all(map(is_mcap, files)):
        raise InputError(f'{path}: no MCAP file in it; only MCAP bags can be recovered')
    rows: list[tuple[tuple[int, int], int, int, str, bytes]] = []
    streams: dict[str, Stream] = {}
    damaged = 0
    for number, file in enumerate(files):
        found, bad = salvage_streams(file)
        damaged += bad
        for stream in found:
            streams.setdefault(stream.topic, stream)
            rows += [((number, place), log, sent, stream.topic, data)
                     for place, log, sent, data in zip(stream.order, stream.log_time,
                                                       stream.publish_time, stream.data)]
    if not rows:
        raise InputError(f'{path}: not a single message can be read')
    rows.sort(key=itemgetter(0))    # as written: stamps say less if the clock was set back
    with BagWriter(folder, sink=McapSink) as bag:   # keeps definitions that are nowhere else
        for stream in streams.values():
            bag.add_topic(stream.topic, stream.type, stream.definition,
                          stream.metadata.get('topic_type_hash', ''),
                          _with_names(stream.metadata.get('offered_qos_profiles', '')),
                          stream.schema_encoding, stream.encoding)
        for _, log, sent, topic, data in rows:
            bag.write(topic, data, log, sent)
    times = [log for _, log, *_ in rows]
    return Recovered(len(rows), (max(times) - min(times)) / 1e9, len(streams), damaged)


def _with_names(text: str) -> str:
    """Return QoS profiles of older bags, which hold numbers, as the current ones with names."""
    try:
        profiles = yaml.safe_load(text) or []
        numbered = any(isinstance(profile.get(key), int) for profile in profiles for key in _NAMES)
    except (yaml.YAMLError, AttributeError, TypeError):     # no list of mappings
        return '[]'
    if not numbered:
        return text or '[]'
    for profile in profiles:
        for key, names in _NAMES.items():
            if isinstance(profile.get(key), int):
                number = profile[key]
                profile[key] = names[number] if number < len(names) else 'unknown'
    return yaml.safe_dump(profiles, sort_keys=False)
