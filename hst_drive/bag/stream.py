# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of a topic as a bag holds them, whatever its storage."""
from __future__ import annotations

from dataclasses import dataclass, field, replace

BLOCK = 20_000      # messages at a time


@dataclass
class Stream:
    """
    The messages of one topic: bytes, receive and publish times (ns), as they were written.

    ``order`` counts through all topics that are read. Where a bag comes in blocks those of the
    last block; ``count`` is how many came so far.
    """

    topic: str
    type: str
    definition: str
    schema_encoding: str
    encoding: str
    metadata: dict[str, str]
    data: list[bytes] = field(default_factory=list)
    log_time: list[int] = field(default_factory=list)
    publish_time: list[int] = field(default_factory=list)
    order: list[int] = field(default_factory=list)
    count: int = 0

    def extend(self, other: Stream) -> None:
        """Add the messages of another part of the bag."""
        self.data += other.data
        self.log_time += other.log_time
        self.publish_time += other.publish_time
        self.order += other.order
        self.count += len(other.data)

    def emptied(self) -> Stream:
        """Return the same without the messages; the count stays."""
        return replace(self, data=[], log_time=[], publish_time=[], order=[])
