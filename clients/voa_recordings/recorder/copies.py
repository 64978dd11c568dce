"""Samples that two subscribers of one session receive: the plain one, and the one that fetches what publishers keep."""

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
    """Numbers of the samples that were received of one publisher: they grow from sample to sample."""

    newest: int = -1
    fetched: deque[int] = field(default_factory=lambda: deque(maxlen=_AHEAD))


class Copies:
    """Tells a sample that the other subscriber has received from a new one; from any thread.

    A sample is named by its publisher and number, else by its Zenoh timestamp: what publishers keep has one of them. A
    live sample is always new unless the very same was fetched. A fetched one is new if it is newer than everything
    that was received of its publisher.
    """

    def __init__(self) -> None:
        self._seen: dict[_Source, _Seen] = {}
        self._lock = threading.Lock()

    def is_new_live(self, sample: zenoh.Sample) -> bool:
        """Note a sample of the plain subscriber; returns whether it is new."""
        name = _name(sample)
        return name is None or self.note_live(*name)

    def is_new_fetched(self, sample: zenoh.Sample) -> bool:
        """Note a sample of the subscriber that fetches; returns whether it is new."""
        name = _name(sample)
        return name is not None and self.note_fetched(*name)

    def note_live(self, source: _Source, number: int) -> bool:
        """Note a live sample by its name; returns whether it is new."""
        with self._lock:
            seen = self._of(source)
            seen.newest = max(seen.newest, number)
            if number in seen.fetched:
                seen.fetched.remove(number)
                return False
            return True

    def note_fetched(self, source: _Source, number: int) -> bool:
        """Note a fetched sample by its name; returns whether it is new."""
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
    """Name a sample by its publisher on its key, and its number there; None: nothing tells it from others."""
    key, source, stamp = str(sample.key_expr), sample.source_info, sample.timestamp
    if source is not None:
        return (key, f"{source.source_id.zid}:{source.source_id.eid}"), source.source_sn
    if stamp is not None:
        time = stamp.get_time_as_ntp64()
        return (key, str(stamp.get_id())), time.as_secs() * NANOSECONDS + time.subsec_nanos()
    return None
