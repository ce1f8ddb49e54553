# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorder: topics as they come, undecoded, into a rosbag2 folder."""
from __future__ import annotations

from bisect import bisect_right
import math
import shutil
import sys
import time
from typing import TYPE_CHECKING

from hst_drive import bag
from hst_drive.bag.cdr import Codec
from hst_drive.bag.definitions import find_definition
from hst_drive.bag.topics import Qos
from hst_drive.errors import InputError
from hst_drive.nodes import sync, wiring
from hst_drive.nodes.base import DriveNode, GATHER, main as run_node
from hst_drive.nodes.endpoints import message_class, qos_profile, stamp_of, topic_named
from hst_drive.nodes.mapped import CHANNELS, map_of, topics_of
from hst_drive.nodes.parameters import Parameter

if TYPE_CHECKING:
    from hst_drive.bag import BagWriter

_DEPTH = 2000
_LATE = 1_000_000_000   # ns: an estimate carries the time that it holds for, so comes later
_QUIET = 0.3   # s without a message after which nothing is under way any more


class Recorder(DriveNode):
    """
    Writes every message of the chosen topics.

    In real time a message is logged when it comes. In lockstep it is logged at its own stamp,
    and the messages up to a second before the plant's last question are written, in the order
    of stamp and topic, once all that their publishers have sent are here.
    """

    role = 'recorder'
    _bag: BagWriter | None = None
    parameters = (
        Parameter('output', '', 'folder to create', form='path that does not exist'),
        Parameter('topics', [], 'full names of topics to record; empty: those of the table that '
                  'the partners publish', form='names that begin with /'),
        CHANNELS._replace(description='channel map whose topics are recorded besides'),
        Parameter('extra_topics', [], 'readings of the plant that are off by default',
                  choices=wiring.SENSORS),
        Parameter('truth', False, 'record the values without noise as well'),
        Parameter('notes', [], "to keep in the bag's metadata", form='name=value pairs'),
    )

    def configure(self) -> None:
        """Make out what to record and create the folder."""
        settings = self.settings
        if not settings['output']:
            raise InputError('recorder: parameter output is empty; name the folder to create')
        wrong = [name for name in settings['topics'] if not name.startswith('/')]
        if wrong:
            raise InputError(f"recorder: parameter topics holds '{wrong[0]}', expected full names "
                             f"of topics; write '/{wrong[0]}'")
        nodes = self.partners or wiring.NODES
        self.taken = wiring.recorded(nodes, settings['extra_topics'], settings['truth'],
                                     settings['circuit'])
        names = [*(settings['topics'] or (
            self.resolve_topic_name(topic_named(name).name) for name in self.taken)),
            *map(self.resolve_topic_name, topics_of(map_of(self)))]
        self._order = {name: place for place, name in enumerate(names)}
        self._subscriptions_by_name: dict[str, object] = {}
        self._received = dict.fromkeys(names, 0)
        self._measured = {self.resolve_topic_name(topic_named(name).name) for name in self.taken
                          if topic_named(name).publisher == 'plant'}
        self._reached = 0
        self._buffer: list[tuple[int, int, str, bytes]] = []
        self._expected: dict[int, dict[str, int]] = {}
        self._told: dict[int, set[str]] = {}
        self._asked: int | None = None
        self.gather = GATHER if self.lockstep else 0.0
        self._last_message = time.monotonic()
        notes = dict(note.split('=', 1) for note in settings['notes'] if '=' in note)
        self._bag = bag.BagWriter(settings['output'], custom_data=notes)

    def activate(self) -> None:
        """Begin to look for publishers."""
        if self._bag is None:
            raise InputError('recorder: its bag is closed; configure it anew')
        super().activate()
        self._search = self.create_timer(0.05, self._subscribe_found, clock=self.wall)
        self.create_timer(1.0, self._flush, clock=self.wall)

    def not_connected(self) -> list[str]:
        """Return the topics that have no publisher yet."""
        return super().not_connected() + [
            name for name in self._order if name not in self._subscriptions_by_name]

    def said(self, name: str, word: str, stamp: int, counts: dict[str, int]) -> None:
        """Take the plant's question and the partners' counts."""
        if word in (sync.ASK, sync.LAST):
            self._asked = stamp
        elif word != sync.DONE:
            return
        # An answer may overtake the question: they come from different nodes.
        self._told.setdefault(stamp, set()).add(name)
        self._expected.setdefault(stamp, {}).update(counts)
        self._complete()

    def drain(self) -> bool:
        """Return whether messages may still be under way."""
        return time.monotonic() - self._last_message < _QUIET

    def deactivate(self) -> None:
        """Write what is left and close the bag."""
        if self._bag is None:
            return
        # In lockstep, commands may be there for steps that never came.
        self._write(self._reached if self.lockstep else math.inf)
        written, self._bag = self._bag, None
        if written is None:
            return
        try:
            written.close()
            if not written.message_count:
                # Nothing came, as when another node could not start: the name stays free.
                shutil.rmtree(self.settings['output'])
        except OSError as error:
            self._lost(error)
            return
        print(f'recorded {written.message_count}', flush=True)

    def _flush(self) -> None:
        try:
            if self._bag:
                self._bag.flush()
        except OSError as error:
            self._lost(error)

    def _store(self, name: str, data: bytes, at: int, stamp: int) -> None:
        """Write a message; if that fails (a full disk), say so once and end."""
        try:
            if self._bag:
                self._bag.write(name, data, at, stamp)
        except OSError as error:
            self._lost(error)

    def _lost(self, error: OSError) -> None:
        # Nothing more is written: the chunks on the disk are whole and can be saved from there.
        self._bag = None
        self.stop(1, f"OSError: {self.settings['output']} cannot be written: {error.strerror}")

    def _subscribe_found(self) -> None:
        for name in self._order:
            if name in self._subscriptions_by_name:
                continue
            found = self.get_publishers_info_by_topic(name)
            if found:
                self._subscribe(name, found)
            elif self.lockstep:
                break   # one order of topics in the bag, whoever came up first
        if len(self._subscriptions_by_name) == len(self._order):
            self.destroy_timer(self._search)

    def _subscribe(self, name: str, publishers) -> None:
        """Subscribe with what all publishers offer, else the middleware would not match them."""
        profiles = [entry.qos_profile for entry in publishers]
        offered = Qos(
            'best_effort' if any(p.reliability.name == 'BEST_EFFORT' for p in profiles)
            else 'reliable',
            'volatile' if any(p.durability.name == 'VOLATILE' for p in profiles)
            else 'transient_local')
        first = publishers[0]
        self._bag.add_topic(name, first.topic_type, type_hash=str(first.topic_type_hash),
                            qos=offered)
        kind = first.topic_type
        stamped = Codec(kind, find_definition(kind)).has_stamp
        self._subscriptions_by_name[name] = self.create_subscription(
            message_class(kind), name, lambda data: self._take(
                name, data, stamp_of(data) if stamped else self.now()),
            qos_profile(offered, _DEPTH), raw=True)

    def _take(self, name: str, data: bytes, stamp: int) -> None:
        self._last_message = time.monotonic()
        if not self.lockstep:
            self._store(name, data, self.now(), stamp)
            return
        self._received[name] += 1
        if name in self._measured:
            self._reached = max(self._reached, stamp)
        self._buffer.append((stamp, self._order[name], name, data))
        self._complete()

    def _complete(self) -> None:
        """Answer the plant once every message up to the step it asked for is written."""
        asked = self._asked
        if asked is None or len(self._told.get(asked, ())) < len(self.partners) - 1:
            return
        # A topic's messages come in their order, so the count alone says that all are here.
        expected = self._expected[asked]
        if any(self._received[name] < expected.get(name, 0) for name in self._order):
            return
        self._write(asked - _LATE)
        self.sync.say(sync.DONE, asked)
        self._asked = None
        for known in [stamp for stamp in self._told if stamp <= asked]:
            del self._told[known], self._expected[known]

    def _write(self, end: float) -> None:
        """Write what is held up to this stamp."""
        self._buffer.sort(key=lambda entry: entry[:2])
        count = bisect_right(self._buffer, end, key=lambda entry: entry[0])
        for stamp, _, name, data in self._buffer[:count]:
            self._store(name, data, stamp, stamp)
        del self._buffer[:count]


def main() -> int:
    """Run the node."""
    return run_node(Recorder)


if __name__ == '__main__':
    sys.exit(main())
