# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The records of an MCAP file, and the messages in them.

They are split by hand: that is several times faster than one object per message, and it lets a
file be read up to the byte where it was cut. Format: mcap.dev/spec.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator
from io import BytesIO
import os
import struct
from typing import BinaryIO
import zlib

from hst_drive.bag.kinds import MCAP_MAGIC as MAGIC
from hst_drive.bag.stream import Stream
import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from mcap.summary import Summary
import zstandard

_RECORD = struct.Struct('<BQ')
MESSAGE = struct.Struct('<HIQQ')
_CHUNK = struct.Struct('<QQQII')
_CHUNK_LIMIT = 1 << 32


class DamagedError(Exception):
    """A record whose content does not match its checksum or its format."""


DAMAGE = (DamagedError, McapError, struct.error, UnicodeDecodeError, MemoryError, OverflowError,
          OSError)      # what spoilt bytes may lead to


def records(file: BinaryIO, offsets: list[int] | None, partial: bool = False,
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


class Collector:
    """
    Sorts records into streams.

    Parameters
    ----------
    wanted : callable
        Says of a topic whether its messages are kept.

    Attributes
    ----------
    messages : int
        How many are held.

    """

    def __init__(self, wanted: Callable[[str], bool]):
        self._wanted = wanted
        self._schemas: dict[int, Schema] = {}
        self._streams: dict[int, Stream] = {}
        self._targets: dict[int, Stream] = {}
        self.messages = self._taken = 0

    def block(self) -> list[Stream]:
        """Return the streams with what came since the last block."""
        self.messages = 0
        block = list(self._streams.values())
        self._streams = {number: stream.emptied() for number, stream in self._streams.items()}
        self._targets = {number: self._streams[number] for number in self._targets}
        return block

    def know(self, summary: Summary) -> None:
        """Take the topics that the summary of a file names."""
        self._schemas.update(summary.schemas)
        for channel in summary.channels.values():
            self._channel(channel)

    def take(self, opcode: int, body: bytes, partial: bool = False) -> None:
        """Take a record, a chunk with all that is in it; of a cut one (``partial``) what is."""
        if opcode == Opcode.CHUNK:
            self._split(_unpack(body, partial), partial)
        elif opcode == Opcode.MESSAGE:
            self._message(body, 0, len(body))
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(BytesIO(body)))
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._channel(Channel.read(ReadDataStream(BytesIO(body))))

    def _channel(self, channel: Channel) -> None:
        if channel.id in self._streams:
            return
        schema = self._schemas.get(channel.schema_id)
        stream = Stream(channel.topic, schema.name if schema else '',
                        schema.data.decode('utf-8', 'surrogateescape') if schema else '',
                        schema.encoding if schema else '', channel.message_encoding,
                        channel.metadata)
        self._streams[channel.id] = stream
        if self._wanted(channel.topic):
            self._targets[channel.id] = stream

    def _message(self, body: bytes, start: int, end: int) -> None:
        number, _, log_time, publish_time = MESSAGE.unpack_from(body, start)
        stream = self._targets.get(number)
        if stream is not None:
            stream.data.append(body[start + MESSAGE.size:end])
            stream.log_time.append(log_time)
            stream.publish_time.append(publish_time)
            stream.order.append(self._taken)
            self.messages += 1
            self._taken += 1

    def _split(self, data: bytes, partial: bool) -> None:
        at, size = 0, len(data)
        while at + _RECORD.size <= size:
            opcode, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            if at + length > size:
                if partial:
                    return
                raise DamagedError('a record goes beyond its chunk')
            if opcode == Opcode.MESSAGE:
                self._message(data, at, at + length)
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
