"""The replicas of the service that are alive, and the choice of the one that is responsible for a sample.

Zenoh has no shared subscriptions: every replica receives every sample. The responsible replica, chosen by rendezvous
hashing over the liveliness tokens, handles it at once; the others wait, and handle it only if that one has not. The
database ensures that a sample takes effect once, whichever replicas handle it.
"""

import hashlib
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import zenoh
from zenoh.handlers import Callback

from voa_msgs.keys import Keys


class Replicas:
    """The replicas that are alive, including this one.

    Args:
        own: id of this replica.
        keys: key expressions of the service.
    """

    def __init__(self, own: str, keys: Keys) -> None:
        self._own = own
        self._keys = keys
        self._alive = {own}
        self._on_leave: list[Callable[[], None]] = []
        self._lock = threading.Lock()

    def when_one_leaves(self, call: Callable[[], None]) -> None:
        """Have a function called, in a Zenoh thread, whenever another replica is gone; it must return at once."""
        self._on_leave.append(call)

    @contextmanager
    def on(self, session: zenoh.Session) -> Iterator[None]:
        """Declare this replica alive, and follow the others, within a `with` block.

        Args:
            session: that has not followed replicas before: Zenoh may then name some that left when it followed no more.
        """
        with self._lock:
            self._alive = {self._own}  # replicas may have left while this one was not connected
        alive = session.liveliness()
        moved = Callback(self._moved, indirect=False)
        with (
            alive.declare_subscriber(self._keys.replica("*"), moved, history=True),
            alive.declare_token(self._keys.replica(self._own)),
        ):
            yield

    def owns(self, name: str) -> bool:
        """Return True if this replica is responsible for samples with a name, such as `<session>/<robot>`."""
        with self._lock:
            alive = list(self._alive)
        return owner_of(name, alive) == self._own

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


def owner_of(name: str, replicas: Iterable[str]) -> str:
    """Return the id of the given replica that is responsible for samples with a name, by rendezvous hashing."""
    return max(replicas, key=lambda id_: _rank(id_, name))


def _rank(id_: str, name: str) -> bytes:
    return hashlib.blake2b(f"{id_}/{name}".encode(), digest_size=8).digest()
