# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of one topic, taken out of its messages block by block."""
from __future__ import annotations

from collections.abc import Sequence

from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.column import Column
from hst_drive.bag.diagnostic_values import read_values
from hst_drive.bag.joints import JointChoice
from hst_drive.bag.stream import Stream
from hst_drive.bag.topics import DIAGNOSTIC_ARRAY, JOINT_STATE
from hst_drive.errors import InputError
import numpy as np

_SEC, _NANOSEC = 'header.stamp.sec', 'header.stamp.nanosec'
_FIRST = 200
_UNSET = 1_000_000_000
"""A stamp of 0 is none where the first other one is later than this (ns)."""
_PUBLISHED = 'published'
_ORDER = 'order'


class TopicNumbers:
    """
    What was read of a topic.

    Parameters
    ----------
    stream : Stream
        The topic; its messages are not taken yet.
    paths : sequence of str
        Where the wanted numbers are in a message.
    on_disk : bool
        Whether the numbers are kept in files instead of the memory.

    Attributes
    ----------
    topic, type : str
    codec : Codec
    first : list of bytes
        The first messages.
    unclear : str
        Why a JointState does not tell which joint is ours; '' if all messages hold the same one.
    seen : set of str
        Paths that held a number at least once.
    stamped : bool
        Whether the messages carry stamps of their own.

    """

    def __init__(self, stream: Stream, paths: Sequence[str], on_disk: bool = False):
        self.topic, self.type = stream.topic, stream.type
        self.codec = Codec(stream.type, stream.definition)
        self.first: list[bytes] = []
        self.unclear = ''
        self._choice = JointChoice()
        self.seen: set[str] = set()
        self._paths = list(dict.fromkeys(paths))
        self.stamped = self.codec.has_stamp
        self._on_disk = on_disk
        self._columns: dict[str, Column] = {}

    def take(self, stream: Stream, source: str) -> None:
        """
        Take the messages of a block.

        Raises
        ------
        InputError
            If one does not fit its definition.

        """
        if not stream.data:
            return
        self.first += stream.data[:_FIRST - len(self.first)]
        stamp = [_SEC, _NANOSEC] if self.stamped else []
        try:
            if self.type == DIAGNOSTIC_ARRAY:
                found = {**read_values(stream.data, self._paths),
                         **self.codec.extract(stream.data, stamp)}
            else:
                arrays: list[dict] = []
                found = self.codec.extract(stream.data, [*self._paths, *stamp], arrays)
                for layout in arrays if self.type == JOINT_STATE else ():
                    self.unclear = self.unclear or self._choice.place(layout)[1]
        except MalformedError as error:
            raise InputError(f'{source}: {stream.topic}: a message does not fit its definition '
                             f'{stream.type} ({error})') from None
        found[_PUBLISHED] = np.array(stream.publish_time if any(stream.publish_time)
                                     else stream.log_time, dtype=np.int64)
        found[_ORDER] = np.array(stream.order, dtype=np.int64)
        if self.stamped:
            found[_SEC] = (found[_SEC].astype(np.int64) * 1_000_000_000
                           + found.pop(_NANOSEC).astype(np.int64))
        self.seen.update(path for path in self._paths if not np.isnan(found[path]).all())
        for key, values in found.items():
            if key not in self._columns:
                self._columns[key] = Column(self._on_disk)
            self._columns[key].append(values)

    @property
    def stamps(self) -> np.ndarray | None:
        """The messages' own times, ns, as publishing tells where one is unset; None: no times."""
        if not self.stamped:
            return None
        stamps = self._columns[_SEC].whole()
        unset = self.unset
        if unset.any():
            # As late after its publishing as the messages around it.
            published = self.published
            age = np.interp(published[unset], published[~unset],
                            (published - stamps)[~unset].astype(float))
            stamps = stamps.copy()
            stamps[unset] = published[unset] - age.astype(np.int64)
        return stamps

    @property
    def unset(self) -> np.ndarray:
        """Which messages carry the stamp 0 though others do not: nobody has set it."""
        stamps = self._columns[_SEC].whole()
        zero = stamps == 0
        others = stamps[~zero]
        return zero & (len(others) > 0 and others.min() > _UNSET)

    @property
    def published(self) -> np.ndarray:
        """When the messages were sent, ns."""
        return self._columns[_PUBLISHED].whole()

    @property
    def order(self) -> np.ndarray:
        """The messages' places among all that were read, as they were written."""
        return self._columns[_ORDER].whole()

    def numbers(self, path: str) -> np.ndarray:
        """Return the numbers, NaN where a message holds none."""
        return self._columns[path].whole()

    def some_numbers(self, path: str, places: np.ndarray) -> np.ndarray:
        """Return the numbers of some messages that lie near each other."""
        if not len(places):
            return np.zeros(0)
        first = int(places.min())
        return self._columns[path].part(first, int(places.max()) + 1)[places - first]
