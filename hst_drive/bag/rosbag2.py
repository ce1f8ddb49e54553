# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Finding what a rosbag2 folder holds: its metadata.yaml, its MCAP or sqlite3 files."""
from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
import sqlite3
from typing import Any

from hst_drive.bag.definitions import find_definition
from hst_drive.bag.kinds import is_mcap
from hst_drive.bag.mcap_bag import cut_error, is_finished, read_streams, Stream
from hst_drive.errors import InputError
import yaml

_TOP = 'rosbag2_bagfile_information'


def bag_files(path: Path, notes: list[str]) -> list[Path]:
    """
    Return the files of a bag, given as folder or as a single file.

    Raises
    ------
    InputError
        If the folder is no bag, or a file that its metadata names is missing.

    """
    if path.is_file():
        return [path]
    metadata = path / 'metadata.yaml'
    if metadata.is_file():
        return _listed_files(path, _read_metadata(metadata))
    for pattern in ('*.mcap', '*.db3'):
        found = sorted(path.glob(pattern))
        if found:
            notes.append('metadata.yaml is missing; read the files in the folder')
            return found
    packed = sorted(path.glob('*.zstd'))
    if packed:
        raise _packed_error(packed[0])
    raise InputError(f'{path}: this directory is no bag (neither metadata.yaml nor a .mcap file '
                     'in it); give a rosbag2 folder, an .mcap file or a CSV file')


def read_bag_streams(path: Path, wanted: Callable[[str], bool],
                     notes: list[str]) -> list[Stream]:
    """
    Read the messages of the wanted topics of a bag, those of split bags joined.

    Raises
    ------
    InputError
        If a file was cut, is damaged or is in an unknown format.

    """
    joined: dict[tuple[str, str], Stream] = {}
    for file in bag_files(path, notes):
        if file.suffix == '.db3':
            streams = _read_sqlite(file, wanted)
        else:
            if is_mcap(file) and not is_finished(file):
                raise cut_error(file, path)
            streams = read_streams(file, wanted)
        for stream in streams:
            known = joined.setdefault((stream.topic, stream.type), stream)
            if known is not stream:
                known.data += stream.data
                known.log_time += stream.log_time
                known.publish_time += stream.publish_time
    return list(joined.values())


def _read_metadata(metadata: Path) -> dict[str, Any]:
    try:
        data = yaml.safe_load(metadata.read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f'{metadata}: cannot be read as YAML ({error}); remove it to read the '
                         'files without it') from None
    if not isinstance(data, dict) or not isinstance(data.get(_TOP), dict):
        raise InputError(f'{metadata}: not the metadata of a bag (no {_TOP})')
    return data[_TOP]


def _listed_files(path: Path, information: dict[str, Any]) -> list[Path]:
    names = information.get('relative_file_paths') or []
    if not isinstance(names, list) or not names:
        raise InputError(f'{path}/metadata.yaml: lists no files')
    files = [path / str(name) for name in names]
    for file in files:
        if file.suffix == '.zstd':
            raise _packed_error(file)
        if not file.is_file():
            raise InputError(f'{path}: metadata.yaml names {file.name}, which is not there')
    return files


def _packed_error(file: Path) -> InputError:
    return InputError(f'{file}: compressed as a whole; unpack it first: zstd -d {file} and remove '
                      '.zstd from its name in metadata.yaml')


def _read_sqlite(path: Path, wanted: Callable[[str], bool]) -> list[Stream]:
    try:
        with closing(sqlite3.connect(f'file:{path}?mode=ro', uri=True)) as base:
            return _query(base, wanted)
    except sqlite3.Error as error:
        raise InputError(f'{path}: damaged or no sqlite3 bag ({error})') from None


def _query(base: sqlite3.Connection, wanted: Callable[[str], bool]) -> list[Stream]:
    tables = {row[0] for row in base.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    texts = {}
    if 'message_definitions' in tables:
        texts = {row[0]: (row[1], row[2]) for row in base.execute(
            'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions')}
    streams = []
    for number, topic, kind, encoding in base.execute(
            'SELECT id, name, type, serialization_format FROM topics').fetchall():
        schema, text = texts.get(kind, ('ros2msg', ''))
        stream = Stream(topic, kind, text, schema, encoding, {})
        if wanted(topic):
            if not text:
                stream.definition = find_definition(kind)
            rows = base.execute('SELECT timestamp, data FROM messages WHERE topic_id=? '
                                'ORDER BY id', (number,))
            for at, data in rows:
                stream.data.append(data)
                stream.log_time.append(at)
                stream.publish_time.append(at)
        streams.append(stream)
    return streams
