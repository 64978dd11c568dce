"""How the service is."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Literal

from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Health, Memory
from voa_service.failures import Failure, NotReady
from voa_service.ports import Clock, Store

Joined = Literal["off", "connecting", "connected"]

_FRESH_SECONDS = 1.0
_WAIT_SECONDS = 0.25
_PATIENCE_SECONDS = 5.0
"""A write that takes longer is one that fails."""
_TRY_AGAIN = {"Retry-After": "1"}


@dataclass
class Link:
    """Whether this process is joined to Zenoh; whoever joins it says so here."""

    state: Joined = "off"


class StoreCheck:
    """Whether the store can be read and written: tried at most once a second while all is well.

    Nobody waits for long: where an attempt is under way (the writer may be busy), the one before it counts for a while.
    A failure of any other call, and a failed attempt, make the next one who asks try anew.

    Args:
        store: whose `ping` is the attempt.
        clock: in seconds.
    """

    def __init__(self, store: Store, clock: Callable[[], float] = time.monotonic) -> None:
        self._store = store
        self._clock = clock
        self._lock = threading.Lock()
        self._running: threading.Event | None = None
        self._began = -math.inf
        self._troubles = 0
        self._error: Exception | None = None

    def check(self) -> None:
        """Return if the store worked at the last attempt.

        Raises:
            Failure: it did not, or the last attempt has not ended for long.
        """
        with self._lock:
            if self._running is None and not self._is_fresh():
                self._running, self._began, self._troubles = threading.Event(), self._clock(), self._store.troubles
                threading.Thread(target=self._run, args=(self._running,), name="voa-ready", daemon=True).start()
            running = self._running
        if running is not None:
            running.wait(_WAIT_SECONDS)
        with self._lock:
            late = self._clock() - self._began if self._running is not None else 0.0
            error = self._error
        if late > _PATIENCE_SECONDS:
            raise NotReady(f"a write to the store has not ended for {late:.0f} s", _TRY_AGAIN)
        if isinstance(error, Failure):
            raise type(error)(error.detail, error.headers) from error
        if error is not None:
            raise NotReady(f"the store does not answer: {type(error).__name__}") from error

    def _is_fresh(self) -> bool:
        well = self._error is None and self._store.troubles == self._troubles
        return well and self._clock() - self._began < _FRESH_SECONDS

    def _run(self, running: threading.Event) -> None:
        error: Exception | None = None
        try:
            self._store.ping()
        except Exception as caught:  # whatever it is, it is told whoever asks
            error = caught
        with self._lock:
            self._error, self._running = error, None
        running.set()


@dataclass(frozen=True)
class HealthCheck:
    """For whoever restarts processes, routes requests, or looks for what is wrong."""

    store: Store
    now: Clock
    replica: str
    """The name of this process."""
    memory: Memory | None = None
    """Memory that its parts may hold."""
    link: Link = field(default_factory=Link)
    checked: StoreCheck = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "checked", StoreCheck(self.store))

    def ready(self) -> Health:
        """The service can work. It can without a router, so `zenoh` only tells.

        Raises:
            Failure: the store cannot be read or written.
        """
        self.checked.check()
        return Health(
            status="ready",
            version=version("voa"),
            wire_version=WIRE_VERSION,
            replica=self.replica,
            zenoh=self.link.state,
            database=self.store.software,
            now=self.now(),
            memory=self.memory,
        )
