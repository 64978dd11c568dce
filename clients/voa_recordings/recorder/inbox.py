"""Queue of samples between Zenoh's threads and the thread that writes them."""

import queue
from dataclasses import dataclass

MOST_WAITING = 16_384


@dataclass(frozen=True)
class ReceivedSample:
    """A sample that was received on Zenoh, before it is written to the recording.

    Attributes:
        key: on which it was published.
        payload: b"" if `deleted`.
        attachment: b"" for none.
        encoding: as Zenoh writes it.
        deleted: True if the sample deletes its key.
        log_ns: time of receipt, nanoseconds since 1970.
        sent_ns: time at which the first router received it; None: it has no timestamp.
    """

    key: str
    payload: bytes
    attachment: bytes
    encoding: str
    deleted: bool
    log_ns: int
    sent_ns: int | None


@dataclass(frozen=True)
class FetchedDocument:
    """A message that was fetched from the service: JSON for one of a session's topics in the recording."""

    session: str
    what: str
    body: bytes
    log_ns: int
    sent_ns: int


@dataclass(frozen=True)
class VersionOfSession:
    """A message that shows a version of a session: CDR for one of the session's topics in the recording."""

    session: str
    what: str
    type_name: str
    data: bytes
    at_ns: int


Item = ReceivedSample | FetchedDocument | VersionOfSession
"""Item of an inbox."""


class Inbox:
    """A bounded queue that never blocks its producers, since a callback that waits stalls the whole Zenoh session.

    Attributes:
        dropped: number of items that were dropped because the queue was full.
    """

    def __init__(self, most: int = MOST_WAITING) -> None:
        self._held: queue.Queue[Item] = queue.Queue(most)
        self.dropped = 0

    def put(self, item: Item) -> None:
        """Append an item, or count it as dropped if the queue is full."""
        try:
            self._held.put_nowait(item)
        except queue.Full:
            self.dropped += 1

    def get(self, seconds: float) -> Item | None:
        """Remove and return the oldest item; None: none arrived within `seconds`."""
        try:
            return self._held.get(timeout=seconds) if seconds > 0.0 else self._held.get_nowait()
        except queue.Empty:
            return None
