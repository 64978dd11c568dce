"""Health: liveness and readiness of this process."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Literal

from voa_msgs import WIRE_VERSION
from voa_msgs.problems import Health, Memory
from voa_service.failures import NotReady
from voa_service.guard import failure_of
from voa_service.ports import Clock, Store
from voa_service.runtime.stopping import Drain
from voa_store.errors import StoreError

Joined = Literal["off", "connecting", "connected"]

_FRESH_SECONDS = 1.0
_WAIT_SECONDS = 0.25
_PATIENCE_SECONDS = 5.0
"""Longest time that a test write may take before the store counts as not working."""
_RETRY_SOON = {"Retry-After": "1"}


@dataclass
class Link:
    """State of this process's connection to Zenoh, set by the entrypoint that connects it."""

    state: Joined = "off"


class StoreCheck:
    """Test that the store can be read and written, made at most once a second while it works.

    Callers wait only briefly: while a test is under way (the writer may be busy), the result before it counts for a
    few seconds. After a failed test, or a failure of any other call to the store, the next caller starts a new test.

    Args:
        store: whose `ping` is the test.
        clock: returns the time in seconds.
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
        """Return if the last test succeeded.

        Raises:
            Failure: it failed, or it has not ended for five seconds.
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
            raise NotReady(f"a write to the store has not ended for {late:.0f} s", _RETRY_SOON)
        if isinstance(error, StoreError):
            raise failure_of(error) from error
        if error is not None:
            raise NotReady(f"the store does not answer: {type(error).__name__}") from error

    def _is_fresh(self) -> bool:
        well = self._error is None and self._store.troubles == self._troubles
        return well and self._clock() - self._began < _FRESH_SECONDS

    def _run(self, running: threading.Event) -> None:
        error: Exception | None = None
        try:
            self._store.ping()
        except Exception as caught:  # any error is kept for the callers of `check`
            error = caught
        with self._lock:
            self._error, self._running = error, None
        running.set()


@dataclass(frozen=True)
class HealthCheck:
    """Use case that reports the health of this process, to supervisors, load balancers and people.

    Attributes:
        store: of the service.
        now: clock.
        replica: name of this process.
        memory: bounds of the memory that its parts may hold.
        link: connection to Zenoh.
        drain: begun by the entrypoint that receives the signal to stop.
        checked: test of the store.
    """

    store: Store
    now: Clock
    replica: str
    memory: Memory | None = None
    link: Link = field(default_factory=Link)
    drain: Drain = field(default_factory=Drain)
    checked: StoreCheck = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "checked", StoreCheck(self.store))

    def ready(self) -> Health:
        """Report that the service can work. The state of `zenoh` is shown only: the service works without a router.

        Raises:
            Failure: the service is stopping, or the store cannot be read or written.
        """
        if self.drain.has_begun:
            raise NotReady("the service is stopping: send requests to another replica", _RETRY_SOON)
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
