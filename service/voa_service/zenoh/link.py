"""One session with a router, opened as soon as there is one; from then on Zenoh joins again by itself."""

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
"""Declares what it needs on a session for the length of a `with`."""

_AGAIN_SECONDS = 0.25
_END_SECONDS = 1.8
_OPEN_SECONDS = 0.5
_TOLD_EVERY = 240  # tries, a minute


class ZenohLink:
    """The session, in a thread that waits for a router; the parts are entered when it is open.

    Args:
        settings: which routers, and as whom.
        link: is told the state.
        metrics: counts links that come and go.
        parts: entered in order, left in reverse.
    """

    def __init__(self, settings: ZenohSettings, link: Link, metrics: Metrics, parts: Sequence[Part]) -> None:
        self._settings = settings
        self._link = link
        self._metrics = metrics
        self._parts = parts
        self._transports = 0
        self._ended = threading.Event()
        link.state = "connecting"
        self._thread = threading.Thread(target=self._run, name="voa-zenoh", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave the parts and the router."""
        self._ended.set()
        # An endpoint that takes connections and is silent is not waited for.
        self._thread.join(_END_SECONDS if self._link.state == "connected" else _OPEN_SECONDS)
        self._link.state = "off"

    def _run(self) -> None:
        while (session := self._open()) is not None:
            try:
                self._serve(session)
            except Exception as error:  # whatever it was: a service that has left the bus must come back
                structlog.get_logger("voa").exception("left zenoh, joining again", exc_info=error)
                self._metrics.zenoh("link failed")
                self._transports = 0
                self._link.state = "connecting"
                self._ended.wait(_AGAIN_SECONDS)

    def _serve(self, session: zenoh.Session) -> None:
        """With everything declared, until it is not wanted any more."""
        with ExitStack() as stack:
            stack.callback(session.close)
            events = session.info.declare_transport_events_listener(Callback(self._moved, indirect=False), history=True)
            stack.callback(events.undeclare)
            for part in self._parts:
                stack.enter_context(part(session))
            structlog.get_logger("voa").info("joined zenoh", routers=[str(zid) for zid in session.info.routers_zid()])
            self._ended.wait()

    def _open(self) -> zenoh.Session | None:
        """Try until a router answers; None: not wanted any more."""
        tries = 0
        while not self._ended.is_set():
            try:
                return zenoh.open(configuration(self._settings))
            except zenoh.ZError as error:
                if tries % _TOLD_EVERY == 0:
                    structlog.get_logger("voa").warning(
                        "no zenoh router yet",
                        endpoints=self._settings.connect,
                        error=str(error).partition(" at /")[0],
                        hint="it is down, or refuses the credentials; `voa doctor` tells which",
                    )
                tries += 1
                self._ended.wait(_AGAIN_SECONDS)
        return None

    def _moved(self, event: zenoh.TransportEvent) -> None:
        """A router came or went."""
        came = event.kind == zenoh.SampleKind.PUT
        self._transports = max(0, self._transports + (1 if came else -1))
        self._link.state = "connected" if self._transports else "connecting"
        self._metrics.zenoh("link up" if came else "link down")


def configuration(settings: ZenohSettings) -> zenoh.Config:
    """The configuration of a session, from a file of the operator's if there is one."""
    if "RUST_LOG" in os.environ:  # Zenoh writes to stdout; without this it is mute
        zenoh.init_log_from_env_or("error")
    config = zenoh.Config() if settings.config is None else zenoh.Config.from_file(settings.config)
    password = None if settings.password is None else settings.password.get_secret_value()
    for path, value in session_config(settings.connect, settings.user, password).items():
        config.insert_json5(path, json.dumps(value))
    return config
