# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Finding what a rosbag2 folder holds: its metadata.yaml, its MCAP or sqlite3 files."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
import sqlite3
from tempfile import TemporaryDirectory
from typing import Any

from hst_drive.bag.definitions import find_definition
from hst_drive.bag.kinds import by_number, is_finished, is_mcap
from hst_drive.bag.packages import MissingPackage, on_use
from hst_drive.bag.storage import find_storage
from hst_drive.bag.stream import BLOCK, Stream
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
    for pattern in ('*.mcap', '*.db3', '*.zstd'):
        found = sorted(path.glob(pattern), key=by_number)
        if found:
            notes.append('metadata.yaml is missing; read the files in the folder')
            return found
    raise InputError(f'{path}: this directory is no bag (neither metadata.yaml nor a .mcap file '
                     'in it); give a rosbag2 folder, an .mcap file or a CSV file')


def bag_blocks(path: Path, wanted: Callable[[str], bool],
               notes: list[str]) -> Iterator[list[Stream]]:
    """
    Yield the messages of the wanted topics of a bag, block by block.

    All topics known so far come each time, those of split bags joined, with the messages of this
    block.

    Raises
    ------
    InputError
        If a file was cut, is damaged or is in an unknown format.

    """
    joined: dict[tuple[str, str], Stream] = {}
    read = 0
    packed = _compressed_messages(path)
    for file in bag_files(path, notes):
        before = read
        with _unpacked(file) as plain:
            blocks = _read_file(plain, wanted, path)
            while True:
                try:
                    streams = next(blocks, None)
                except InputError as error:
                    raise InputError(str(error).replace(str(plain), str(file))) from None
                if streams is None:
                    break
                if packed:
                    _unpack_messages(streams, path)
                joined = {key: stream.emptied() for key, stream in joined.items()}
                for stream in streams:
                    stream.order = [before + place for place in stream.order]
                    read += len(stream.order)
                    joined.setdefault((stream.topic, stream.type),
                                      stream.emptied()).extend(stream)
                yield list(joined.values())


def _read_file(file: Path, wanted: Callable[[str], bool], path: Path) -> Iterator[list[Stream]]:
    if file.suffix == '.db3':
        return _read_sqlite(file, wanted)
    if is_mcap(file) and not is_finished(file):
        try:
            raise on_use('hst_drive.bag.mcap_bag').cut_error(file, path)
        except MissingPackage as error:
            raise InputError(f'{path}: the bag was cut off (its end is missing); to save what '
                             f'can be read of it {error}') from None
    return find_storage().read_streams(file, wanted)


def _read_metadata(metadata: Path) -> dict[str, Any]:
    try:
        data = yaml.safe_load(metadata.read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, RecursionError) as error:
        why = ' '.join(str(error).split())
        raise InputError(f'{metadata}: cannot be read as YAML ({why}); remove it to read the '
                         'files without it') from None
    if not isinstance(data, dict) or not isinstance(data.get(_TOP), dict):
        raise InputError(f'{metadata}: not the metadata of a bag (no {_TOP})')
    return data[_TOP]


def _listed_files(path: Path, information: dict[str, Any]) -> list[Path]:
    names = information.get('relative_file_paths') or []
    if not isinstance(names, list) or not names:
        raise InputError(f'{path}/metadata.yaml: lists no files')
    files = [path / str(name) for name in names]
    for place, file in enumerate(files):
        if not file.is_file() and file.with_suffix('').is_file() and file.suffix == '.zstd':
            files[place] = file = file.with_suffix('')     # unpacked by hand
        if not file.is_file():
            raise InputError(f'{path}: metadata.yaml names {file.name}, which is not there')
        if not file.resolve().is_relative_to(path.resolve()):
            raise InputError(f'{path}: metadata.yaml names {file}, which is outside of the bag')
    return files


@contextmanager
def _unpacked(file: Path) -> Iterator[Path]:
    """Give the file itself, or a copy of what it holds if it is compressed as a whole."""
    if file.suffix != '.zstd':
        yield file
        return
    zstandard = on_use('zstandard')
    with TemporaryDirectory(prefix='hst_drive_') as folder:
        copy = Path(folder) / file.stem
        try:
            with open(file, 'rb') as packed, open(copy, 'wb') as plain:
                zstandard.ZstdDecompressor().copy_stream(packed, plain)
        except zstandard.ZstdError as error:
            raise InputError(f'{file}: damaged: cannot be decompressed ({error})') from None
        except OSError as error:
            raise InputError(f'{file}: cannot be unpacked: {error.strerror}; set TMPDIR to a '
                             'folder with room') from None
        yield copy


def _unpack_messages(streams: Iterable[Stream], path: Path) -> None:
    """Unpack messages that are compressed one by one."""
    zstandard = on_use('zstandard')
    unpack = zstandard.ZstdDecompressor().decompressobj
    try:
        for stream in streams:
            stream.data = [unpack().decompress(data) for data in stream.data]
    except zstandard.ZstdError as error:
        raise InputError(f'{path}: damaged: a message cannot be decompressed ({error})') from None


def _compressed_messages(path: Path) -> bool:
    metadata = path / 'metadata.yaml'
    if not metadata.is_file():
        return False
    information = _read_metadata(metadata)
    if str(information.get('compression_mode') or '').lower() == 'none':
        return False
    form = information.get('compression_format') or 'zstd'
    if form != 'zstd':
        raise InputError(f'{path}: compressed with {form!r}, of which nothing is known; convert '
                         'the bag: ros2 bag convert')
    return str(information.get('compression_mode') or '').lower() == 'message'


def _read_sqlite(path: Path, wanted: Callable[[str], bool]) -> Iterator[list[Stream]]:
    try:
        with closing(sqlite3.connect(f'{path.resolve().as_uri()}?mode=ro', uri=True)) as base:
            yield from _query(base, wanted)
    except (sqlite3.Error, MemoryError, OverflowError, TypeError, UnicodeDecodeError) as error:
        raise InputError(f'{path}: damaged or no sqlite3 bag ({error})') from None


def _query(base: sqlite3.Connection, wanted: Callable[[str], bool]) -> Iterator[list[Stream]]:
    tables = {row[0] for row in base.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    texts = {}
    if 'message_definitions' in tables:
        texts = {row[0]: (row[1], row[2]) for row in base.execute(
            'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions')}
    streams: dict[int, Stream] = {}
    for number, topic, kind, encoding in base.execute(
            'SELECT id, name, type, serialization_format FROM topics').fetchall():
        if not all(isinstance(entry, str) for entry in (topic, kind, encoding)):
            raise sqlite3.DataError('the table of topics holds no texts')
        schema, text = texts.get(kind, ('ros2msg', ''))
        if wanted(topic) and not text:
            text = find_definition(kind)
        streams[number] = Stream(topic, kind, text, schema, encoding, {})
    ids = [number for number, stream in streams.items() if wanted(stream.topic)]
    rows = base.execute('SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN '
                        f'({", ".join("?" * len(ids))}) ORDER BY id', ids)
    taken = 0
    while block := rows.fetchmany(BLOCK):
        streams = {number: stream.emptied() for number, stream in streams.items()}
        for number, at, data in block:
            stream = streams[number]
            if not isinstance(at, int) or not isinstance(data, bytes):
                raise sqlite3.DataError('a message is no bytes, or its time no number')
            stream.data.append(data)
            stream.log_time.append(at)
            stream.publish_time.append(at)
            stream.order.append(taken)
            taken += 1
        yield list(streams.values())
    yield [stream.emptied() for stream in streams.values()]
