# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading MCAP files, whole ones block by block, and what is left of cut ones."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
import struct
from typing import BinaryIO, NamedTuple

from hst_drive.bag.kinds import is_finished, is_mcap
from hst_drive.bag.mcap_records import Collector, DAMAGE, MESSAGE, records
from hst_drive.bag.stream import BLOCK, Stream
from hst_drive.errors import InputError
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.summary import Summary


class Extent(NamedTuple):
    """What can be read of a cut file."""

    messages: int
    seconds: float


def read_streams(path: Path, wanted: Callable[[str], bool]) -> Iterator[list[Stream]]:
    """
    Yield the messages of the wanted topics of a finished file, block by block.

    All topics come each time, with new messages or without.

    Raises
    ------
    InputError
        If the file was cut, is damaged, or is no MCAP file.

    """
    if not is_mcap(path):
        raise InputError(f'{path}: not an MCAP file (it does not begin with the MCAP '
                         'mark); record it again, or leave the log out')
    if not is_finished(path):
        raise cut_error(path)
    collector = Collector(wanted)
    try:
        with open(path, 'rb') as file:
            summary = _summary(file)
            offsets = _offsets(summary, wanted)
            if summary is not None and offsets is not None:
                collector.know(summary)
            for opcode, body in records(file, offsets):
                collector.take(opcode, body)
                if collector.messages >= BLOCK:
                    yield collector.block()
            yield collector.block()
    except DAMAGE as error:
        raise InputError(f'{path}: damaged ({error or "wrong lengths"}); what is readable can be '
                         f'saved with: {recover_command(path)}') from None


def salvage_streams(path: Path) -> tuple[list[Stream], int]:
    """
    Read all that can be read from a file, cut or damaged as it may be.

    Returns
    -------
    streams : list of Stream
    damaged : int
        Records that had to be left out.

    """
    collector = Collector(lambda topic: True)
    damaged = 0
    with open(path, 'rb') as file:
        for opcode, body in records(file, None, partial=True):
            try:
                collector.take(opcode, body, partial=True)
            except DAMAGE:
                damaged += 1
    return collector.block(), damaged


def extent(path: Path) -> Extent:
    """Return how much of a cut file can be read, from its chunks' headers and indexes alone."""
    messages, first, last = 0, None, None
    with open(path, 'rb') as file, suppress(struct.error):      # up to a record that is too short
        for opcode, body in records(file, None, heads=True):
            if opcode == Opcode.CHUNK:
                start, end = struct.unpack_from('<QQ', body)
            elif opcode == Opcode.MESSAGE:
                start = end = MESSAGE.unpack_from(body)[2]
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
    return InputError(f'{shown}: the bag was cut off (its end is missing): at least '
                      f'{found.seconds:.1f} s with {found.messages} messages can be read; save '
                      f'them with: {recover_command(shown)}')


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
