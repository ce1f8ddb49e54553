# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reading MCAP files, whole ones and what is left of cut ones.

The records are split by hand: that is several times faster than one object per message, and it
lets a file be read up to the byte where it was cut. Format: mcap.dev/spec.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
import os
from pathlib import Path
import struct
from typing import BinaryIO, NamedTuple
import zlib

from hst_drive.bag.kinds import is_mcap, MCAP_MAGIC as MAGIC
from hst_drive.errors import InputError
import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.summary import Summary
import zstandard

_RECORD = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_CHUNK = struct.Struct('<QQQII')
_CHUNK_LIMIT = 1 << 32


class DamagedError(Exception):
    """A record whose content does not match its checksum or its format."""


_DAMAGE = (DamagedError, McapError, struct.error, UnicodeDecodeError, MemoryError, OverflowError,
           OSError)     # what spoilt bytes may lead to


@dataclass
class Stream:
    """The messages of one topic: bytes, receive and publish times (ns), in file order."""

    topic: str
    type: str
    definition: str
    schema_encoding: str
    encoding: str
    metadata: dict[str, str]
    data: list[bytes] = field(default_factory=list)
    log_time: list[int] = field(default_factory=list)
    publish_time: list[int] = field(default_factory=list)


class Extent(NamedTuple):
    """What can be read of a cut file."""

    messages: int
    seconds: float


def is_finished(path: Path) -> bool:
    """Tell whether a file ends as a finished MCAP file does."""
    size = os.path.getsize(path)
    with open(path, 'rb') as file:
        file.seek(max(size - len(MAGIC), 0))
        return size >= 2 * len(MAGIC) and file.read() == MAGIC


def read_streams(path: Path, wanted: Callable[[str], bool] = lambda topic: True) -> list[Stream]:
    """
    Read the messages of the wanted topics from a finished file.

    Topics that are not wanted come back without messages.

    Raises
    ------
    InputError
        If the file was cut, is damaged, or is no MCAP file.

    """
    if not is_mcap(path):
        raise InputError(f'{path}: not an MCAP file (it does not begin with the MCAP mark)')
    if not is_finished(path):
        raise cut_error(path)
    collector = _Collector(wanted)
    try:
        with open(path, 'rb') as file:
            summary = _summary(file)
            offsets = _offsets(summary, wanted)
            if summary is not None and offsets is not None:
                collector.know(summary)
            for opcode, body in _records(file, offsets):
                collector.take(opcode, body)
    except _DAMAGE as error:
        raise InputError(f'{path}: damaged ({error or "wrong lengths"}); what is readable can be '
                         f'saved with: {recover_command(path)}') from None
    return list(collector.streams.values())


def salvage_streams(path: Path) -> tuple[list[Stream], int]:
    """
    Read all that can be read from a file, cut or damaged as it may be.

    Returns
    -------
    streams : list of Stream
    damaged : int
        Records that had to be left out.

    """
    collector = _Collector(lambda topic: True)
    damaged = 0
    with open(path, 'rb') as file:
        for opcode, body in _records(file, None, partial=True):
            try:
                collector.take(opcode, body, partial=True)
            except _DAMAGE:
                damaged += 1
    return list(collector.streams.values()), damaged


def extent(path: Path) -> Extent:
    """Return how much of a cut file can be read, from its chunks' headers and indexes alone."""
    messages, first, last = 0, None, None
    with open(path, 'rb') as file:
        for opcode, body in _records(file, None, heads=True):
            if opcode == Opcode.CHUNK:
                start, end = struct.unpack_from('<QQ', body)
            elif opcode == Opcode.MESSAGE:
                start = end = _MESSAGE.unpack_from(body)[2]
                messages += 1
            elif opcode == Opcode.MESSAGE_INDEX:
                messages += struct.unpack_from('<HI', body)[1] // 16
                continue
            else:
                continue
            first = start if first is None else min(first, start)
            last = end if last is None else max(last, end)
    return Extent(messages, 0.0 if first is None else (last - first) / 1e9)


def recover_command(path: Path) -> str:
    """Return the command that saves what is readable."""
    return f'hst-drive recover {path} -o {path.with_suffix("")}_recovered'


def cut_error(path: Path, shown: Path | None = None) -> InputError:
    """Return the error that tells of a file that was cut, and how to save it."""
    found = extent(path)
    shown = shown or path
    if not found.messages:
        return InputError(f'{shown}: the bag was cut off (its end is missing) before the first '
                          'block of messages: nothing can be read; record it again')
    return InputError(f'{shown}: the bag was cut off (its end is missing): {found.seconds:.1f} s '
                      f'with {found.messages} messages can be read; save them with: '
                      f'{recover_command(shown)}')


def _summary(file: BinaryIO) -> Summary | None:
    try:
        return make_reader(file).get_summary()
    except (McapError, struct.error, ValueError, MemoryError, OverflowError, OSError):
        return None     # lengths in it may be anything; the records are then read one by one


def _offsets(summary: Summary | None, wanted: Callable[[str], bool]) -> list[int] | None:
    """Return where the chunks with wanted topics are; None if the file has no index."""
    if summary is None or not summary.chunk_indexes:
        return None
    if any(not index.message_index_offsets or not index.message_index_offsets.keys()
           <= summary.channels.keys() for index in summary.chunk_indexes):
        return None
    ids = {number for number, channel in summary.channels.items() if wanted(channel.topic)}
    return [index.chunk_start_offset for index in summary.chunk_indexes
            if ids & index.message_index_offsets.keys()]


def _records(file: BinaryIO, offsets: list[int] | None, partial: bool = False,
             heads: bool = False) -> Iterator[tuple[int, bytes]]:
    """
    Yield opcode and body of the records of the data section.

    ``offsets`` limits them to the records there; ``partial`` yields the cut last one as well;
    ``heads`` yields only the first bytes of each.
    """
    size = file.seek(0, os.SEEK_END)
    if offsets is not None:
        for offset in offsets:
            file.seek(offset)
            opcode, length = _RECORD.unpack(file.read(_RECORD.size))
            if length > size:
                raise DamagedError('a record goes beyond its file')
            yield opcode, file.read(length)
        return
    at = len(MAGIC)
    while at + _RECORD.size <= size:
        file.seek(at)
        opcode, length = _RECORD.unpack(file.read(_RECORD.size))
        at += _RECORD.size + length
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):
            return
        if at > size and not (partial and opcode == Opcode.CHUNK):
            return
        # A damaged length may be anything; more than the file has is not read.
        yield opcode, file.read(min(length, 32 if heads else size))


class _Collector:
    """Sorts records into streams."""

    def __init__(self, wanted: Callable[[str], bool]):
        self.wanted = wanted
        self.schemas: dict[int, Schema] = {}
        self.streams: dict[int, Stream] = {}
        self.targets: dict[int, Stream] = {}

    def know(self, summary: Summary) -> None:
        self.schemas.update(summary.schemas)
        for channel in summary.channels.values():
            self.channel(channel)

    def take(self, opcode: int, body: bytes, partial: bool = False) -> None:
        if opcode == Opcode.CHUNK:
            self.split(_unpack(body, partial), partial)
        elif opcode == Opcode.MESSAGE:
            self.message(body, 0, len(body))
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(BytesIO(body)))
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self.channel(Channel.read(ReadDataStream(BytesIO(body))))

    def channel(self, channel: Channel) -> None:
        if channel.id in self.streams:
            return
        schema = self.schemas.get(channel.schema_id)
        stream = Stream(channel.topic, schema.name if schema else '',
                        schema.data.decode('utf-8') if schema else '',
                        schema.encoding if schema else '', channel.message_encoding,
                        channel.metadata)
        self.streams[channel.id] = stream
        if self.wanted(channel.topic):
            self.targets[channel.id] = stream

    def message(self, body: bytes, start: int, end: int) -> None:
        number, _, log_time, publish_time = _MESSAGE.unpack_from(body, start)
        stream = self.targets.get(number)
        if stream is not None:
            stream.data.append(body[start + _MESSAGE.size:end])
            stream.log_time.append(log_time)
            stream.publish_time.append(publish_time)

    def split(self, data: bytes, partial: bool) -> None:
        at, size = 0, len(data)
        while at + _RECORD.size <= size:
            opcode, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            if at + length > size:
                if partial:
                    return
                raise DamagedError('a record goes beyond its chunk')
            if opcode == Opcode.MESSAGE:
                self.message(data, at, at + length)
            else:
                self.take(opcode, data[at:at + length])
            at += length


def _unpack(body: bytes, partial: bool) -> bytes:
    """Return the content of a chunk, checked; of a cut one (``partial``) the part there is."""
    _, _, size, checksum, name_length = _CHUNK.unpack_from(body)
    at = _CHUNK.size + name_length
    compression = body[_CHUNK.size:at].decode()
    stored = struct.unpack_from('<Q', body, at)[0]
    packed = body[at + 8:]
    cut = len(packed) < stored
    if size > _CHUNK_LIMIT:
        raise DamagedError('a chunk claims more than 4 GiB')
    try:
        if compression == 'zstd':
            data = zstandard.ZstdDecompressor().decompressobj().decompress(packed)
        elif compression == 'lz4':
            data = lz4.frame.LZ4FrameDecompressor().decompress(packed)
        elif compression:
            raise DamagedError(f'unknown compression {compression!r}')
        else:
            data = packed
    except (zstandard.ZstdError, RuntimeError, EOFError, MemoryError):
        raise DamagedError('a chunk cannot be decompressed') from None
    if cut and partial:
        return data
    if len(data) != size or (checksum and zlib.crc32(data) != checksum):
        raise DamagedError('checksum of a chunk does not match')
    return data
