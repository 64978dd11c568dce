"""Which processes of the service are there, and which of them takes a sample that all of them hear.

Zenoh has no shared subscriptions: every replica hears every sample. One of them, found by rendezvous hashing over
the liveliness tokens, works at once; the others wait, and work only if that one did not. Which of them has the
effect is up to the database, not to this.
"""

import hashlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import zenoh
from zenoh.handlers import Callback

from voa_msgs.keys import Keys


class Replicas:
    """The replicas that are alive, this one among them."""

    def __init__(self, own: str, keys: Keys) -> None:
        self._own = own
        self._keys = keys
        self._alive = {own}
        self._on_leave: list[Callable[[], None]] = []
        self._lock = threading.Lock()

    def when_one_leaves(self, call: Callable[[], None]) -> None:
        """Call something, in a Zenoh thread, whenever another replica is gone: it must return at once."""
        self._on_leave.append(call)

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Be seen, and see the others, for the length of a `with`."""
        with self._lock:
            self._alive = {self._own}  # who left while this replica was away told nobody here
        alive = session.liveliness()
        moved = Callback(self._moved, indirect=False)
        with (
            alive.declare_subscriber(self._keys.replica("*"), moved, history=True),
            alive.declare_token(self._keys.replica(self._own)),
        ):
            yield

    def owns(self, name: str) -> bool:
        """Whether this process is the one that works on what is called `name`."""
        with self._lock:
            alive = list(self._alive)
        return max(alive, key=lambda id_: _rank(id_, name)) == self._own

    def _moved(self, sample: zenoh.Sample) -> None:
        id_ = self._keys.last(str(sample.key_expr))
        with self._lock:
            if sample.kind == zenoh.SampleKind.PUT:
                self._alive.add(id_)
                return
            if id_ == self._own or id_ not in self._alive:
                return
            self._alive.discard(id_)
        for call in self._on_leave:
            call()


def _rank(id_: str, name: str) -> bytes:
    return hashlib.blake2b(f"{id_}/{name}".encode(), digest_size=8).digest()
