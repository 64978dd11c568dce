"""Samples between Zenoh's threads and the one that writes."""

import queue
from dataclasses import dataclass

MOST_WAITING = 16_384


@dataclass(frozen=True)
class Received:
    """A sample as it came.

    Attributes:
        attachment: b"" for none.
        encoding: as Zenoh writes it.
        deleted: it is the end of its key, and has no payload.
        log_ns: when it came, nanoseconds since 1970.
        sent_ns: when a router first saw it; None: it does not say.
    """

    key: str
    payload: bytes
    attachment: bytes
    encoding: str
    deleted: bool
    log_ns: int
    sent_ns: int | None


@dataclass(frozen=True)
class Answer:
    """A message that the service was asked for: JSON for a topic of the recording."""

    session: str
    what: str
    body: bytes
    log_ns: int
    sent_ns: int


class Inbox:
    """A bounded queue. Putting never waits, since a callback that waits stalls the whole Zenoh session.

    Attributes:
        dropped: items that found it full.
    """

    def __init__(self, most: int = MOST_WAITING) -> None:
        self._held: queue.Queue[Received | Answer] = queue.Queue(most)
        self.dropped = 0

    def put(self, item: Received | Answer) -> None:
        """Keep it, or count it as dropped."""
        try:
            self._held.put_nowait(item)
        except queue.Full:
            self.dropped += 1

    def get(self, seconds: float) -> Received | Answer | None:
        """The oldest; None: nothing came within `seconds`."""
        try:
            return self._held.get(timeout=seconds) if seconds > 0.0 else self._held.get_nowait()
        except queue.Empty:
            return None
