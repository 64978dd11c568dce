"""The Zenoh session with a router: opened as soon as a router answers; Zenoh itself restores a lost connection.

The link counts as connected once a router is there and every part has made its declarations: from then on no message
passes the service by.
"""

import json
import os
import threading
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack

import structlog
import zenoh
from zenoh.handlers import Callback

from voa_msgs.links import session_config
from voa_service.runtime.metrics import Metrics
from voa_service.settings import ZenohSettings
from voa_service.usecases.health import Link

Part = Callable[[zenoh.Session], AbstractContextManager[object]]
"""Context manager that makes its declarations on a session, and undoes them at the end of the `with` block."""

_AGAIN_SECONDS = 0.25
_END_SECONDS = 1.8
_OPEN_SECONDS = 0.5
_LOGGED_EVERY = 240  # tries, which take a minute


class ZenohLink:
    """Holds the session, in a thread that waits for a router, and enters the parts when the session is open.

    Args:
        settings: endpoints of routers, and credentials.
        link: state of the link, kept up to date for health checks.
        metrics: counts connections to routers made and lost.
        parts: entered in this order, left in reverse.
        left: returns the seconds that leaving them may take.
    """

    def __init__(
        self,
        settings: ZenohSettings,
        link: Link,
        metrics: Metrics,
        parts: Sequence[Part],
        left: Callable[[], float] = lambda: _END_SECONDS,
    ) -> None:
        self._settings = settings
        self._link = link
        self._metrics = metrics
        self._parts = parts
        self._left = left
        self._transports = 0
        self._is_declared = False
        self._changing = threading.Lock()
        self._has_tried = threading.Event()
        metrics.gauge("voa_zenoh_connected", "1 if a Zenoh router is connected, else 0.", self._is_connected)
        self._ended = threading.Event()
        link.state = "connecting"
        self._thread = threading.Thread(target=self._run, name="voa-zenoh", daemon=True)
        self._thread.start()

    def wait_for_first_try(self, seconds: float) -> None:
        """Wait until the link is connected for the first time, or no router answered; at most so many seconds."""
        self._has_tried.wait(seconds)

    def close(self) -> None:
        """Leave the parts and the router."""
        self._ended.set()
        # An endpoint that accepts connections and stays silent is not waited for.
        self._thread.join(self._left() if self._link.state == "connected" else _OPEN_SECONDS)
        self._link.state = "off"

    def _is_connected(self) -> float:
        return float(self._link.state == "connected")

    def _run(self) -> None:
        while (session := self._open()) is not None:
            try:
                self._serve(session)
            except Exception as error:  # any error: a service that has lost Zenoh must connect again
                structlog.get_logger("voa").exception("the Zenoh session failed, opening it again", exc_info=error)
                self._metrics.zenoh("link failed")
                self._note(transports=0)
                self._ended.wait(_AGAIN_SECONDS)

    def _serve(self, session: zenoh.Session) -> None:
        """Serve the parts on a session until `close` is called."""
        with ExitStack() as stack:
            stack.callback(session.close)
            events = session.info.declare_transport_events_listener(Callback(self._moved, indirect=False), history=True)
            stack.callback(events.undeclare)
            stack.callback(self._note, is_declared=False)
            for part in self._parts:
                stack.enter_context(part(session))
            self._note(is_declared=True)
            structlog.get_logger("voa").info(
                "connected to Zenoh", routers=[str(zid) for zid in session.info.routers_zid()]
            )
            self._ended.wait()

    def _open(self) -> zenoh.Session | None:
        """Open a session, trying until a router answers; None where `close` is called first."""
        tries = 0
        while not self._ended.is_set():
            try:
                return zenoh.open(configuration(self._settings))
            except zenoh.ZError as error:
                if tries % _LOGGED_EVERY == 0:
                    structlog.get_logger("voa").warning(
                        "no Zenoh router answers",
                        endpoints=self._settings.connect,
                        error=str(error).partition(" at /")[0],
                        hint="the router is down, or refuses the credentials; `voa doctor` shows which",
                    )
                tries += 1
                self._has_tried.set()
                self._ended.wait(_AGAIN_SECONDS)
        return None

    def _moved(self, event: zenoh.TransportEvent) -> None:
        """Note that a connection to a router was made or lost."""
        is_up = event.kind == zenoh.SampleKind.PUT
        self._note(transports=max(0, self._transports + (1 if is_up else -1)))
        self._metrics.zenoh("link up" if is_up else "link down")

    def _note(self, transports: int | None = None, is_declared: bool | None = None) -> None:
        """Note the number of connections to routers, and whether all parts have made their declarations."""
        with self._changing:
            self._transports = self._transports if transports is None else transports
            self._is_declared = self._is_declared if is_declared is None else is_declared
            self._link.state = "connected" if self._transports and self._is_declared else "connecting"
        if self._link.state == "connected":
            self._has_tried.set()


def configuration(settings: ZenohSettings) -> zenoh.Config:
    """Return the configuration of a session: the operator's file, if there is one, with the settings added."""
    if "RUST_LOG" in os.environ:  # Zenoh logs to stdout, and only after this call
        zenoh.init_log_from_env_or("error")
    config = zenoh.Config() if settings.config is None else zenoh.Config.from_file(settings.config)
    password = None if settings.password is None else settings.password.get_secret_value()
    for path, value in session_config(settings.connect, settings.user, password).items():
        config.insert_json5(path, json.dumps(value))
    return config
