"""Detection of samples that arrive twice: at a plain subscriber, and at one that fetches what publishers keep."""

import threading
from collections import deque
from dataclasses import dataclass, field

import zenoh

from voa_ros.messages import NANOSECONDS

_AHEAD = 64
"""Samples of one publisher that the fetching subscriber may receive before the plain one does."""
_MOST_PUBLISHERS = 100_000

_Source = tuple[str, str]


@dataclass
class _Seen:
    """Sequence numbers of the samples received from one publisher; they grow from sample to sample."""

    newest: int = -1
    fetched: deque[int] = field(default_factory=lambda: deque(maxlen=_AHEAD))


class Copies:
    """Detector of samples that the other of two subscribers has received already; usable from any thread.

    A sample is identified by its publisher and sequence number, or by its Zenoh timestamp; samples that publishers keep
    have one of these. A live sample is new unless it was fetched before. A fetched sample is new if it is newer than
    all samples received from its publisher.
    """

    def __init__(self) -> None:
        self._seen: dict[_Source, _Seen] = {}
        self._lock = threading.Lock()

    def is_new_live(self, sample: zenoh.Sample) -> bool:
        """Register a sample that was received live, not fetched from a publisher's cache; return True if it is new."""
        name = _name(sample)
        return name is None or self.note_live(*name)

    def is_new_fetched(self, sample: zenoh.Sample) -> bool:
        """Register a sample of the fetching subscriber; return True if it is new."""
        name = _name(sample)
        return name is not None and self.note_fetched(*name)

    def note_live(self, source: _Source, number: int) -> bool:
        """Register a live sample by publisher and number; return True if it is new."""
        with self._lock:
            seen = self._of(source)
            seen.newest = max(seen.newest, number)
            if number in seen.fetched:
                seen.fetched.remove(number)
                return False
            return True

    def note_fetched(self, source: _Source, number: int) -> bool:
        """Register a fetched sample by publisher and number; return True if it is new."""
        with self._lock:
            seen = self._of(source)
            if number <= seen.newest:
                return False
            seen.newest = number
            seen.fetched.append(number)
            return True

    def _of(self, source: _Source) -> _Seen:
        if source not in self._seen and len(self._seen) >= _MOST_PUBLISHERS:
            del self._seen[next(iter(self._seen))]
        return self._seen.setdefault(source, _Seen())


def _name(sample: zenoh.Sample) -> tuple[_Source, int] | None:
    """Identify a sample by its publisher on its key, and its number there; None: it has no number or timestamp."""
    key, source, stamp = str(sample.key_expr), sample.source_info, sample.timestamp
    if source is not None:
        return (key, f"{source.source_id.zid}:{source.source_id.eid}"), source.source_sn
    if stamp is not None:
        time = stamp.get_time_as_ntp64()
        return (key, str(stamp.get_id())), time.as_secs() * NANOSECONDS + time.subsec_nanos()
    return None
