"""Links to a Zenoh router: opened in the background as soon as it answers, and reopened whenever it comes back.

Zenoh's library is imported when a link is made, not before, because robots that use HTTP do not need it.
"""

import asyncio
import json
import threading
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from voa_client._errors import TimedOutError, UsageError, VoaClientError
from voa_client._zenoh_address import ZenohAddress
from voa_client.installing import install_hint
from voa_msgs.links import session_config

if TYPE_CHECKING:
    import zenoh

CHECK_S = 0.02
"""Interval at which a coroutine checks that a link is connected, seconds."""
_AGAIN_S = 0.2
_CLOSE_S = 2.0


class MissingLibraryError(VoaClientError, ImportError):
    """Zenoh's library is not installed; the error's text has the command that installs it."""


async def joined(link: "Link", seconds: float) -> "zenoh.Session":
    """Wait for a link's session to be connected; raises TimedOutError after `seconds`, UsageError if it is closed."""
    until = time.monotonic() + seconds
    while (session := link.session) is None:
        if time.monotonic() > until:
            raise link.failure(seconds)
        await asyncio.sleep(CHECK_S)
    return session


class Links:
    """Links to a router: one for calls, and a second one for news, so that a flood of samples delays no response."""

    def __init__(self, address: ZenohAddress) -> None:
        self._address = address
        self._news: Link | None = None
        self._making = threading.Lock()
        self.calls = Link(address)

    def news(self) -> "Link":
        """Return the link for news, which is opened at the first call."""
        with self._making:
            if self._news is None and not self.calls.is_closed:
                self._news = Link(self._address)
            return self._news or self.calls

    def close(self) -> None:
        """Close both links."""
        self.calls.close()
        with self._making:
            if self._news is not None:
                self._news.close()


class Link:
    """A link to a router: a thread opens it as soon as the router answers; from then on it reconnects by itself."""

    def __init__(self, address: ZenohAddress) -> None:
        self._address = address
        self._config = config(address)
        self._opened: zenoh.Session | None = None
        self._connected: set[str] = set()
        self._why = ""
        self._ended = threading.Event()
        self._changed = threading.Condition()
        self._opening = threading.Thread(target=self._open, name="voa-zenoh", daemon=True)
        self._opening.start()

    @property
    def is_closed(self) -> bool:
        """True once the link was closed."""
        return self._ended.is_set()

    @property
    def session(self) -> "zenoh.Session | None":
        """Zenoh's session while it is connected, else None; raises UsageError once the link is closed."""
        if self._ended.is_set():
            raise UsageError(f"the client of {self._address.endpoint} is closed")
        return self._opened if self._connected else None

    def wait(self, seconds: float) -> "zenoh.Session":
        """Wait until the session is connected; raises TimedOutError after `seconds`, UsageError if closed."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.session is not None, seconds) or self._opened is None:
                raise self.failure(seconds)
            return self._opened

    def failure(self, seconds: float) -> TimedOutError:
        """Make the error for a wait of `seconds` in which no router was reached."""
        return TimedOutError(f"no Zenoh router at {self._address.endpoint} within {seconds:.3g} s{self._why}")

    def close(self) -> None:
        """Close the session, whose threads would run until the end of the process."""
        self._ended.set()
        with self._changed:
            self._changed.notify_all()
        self._opening.join(_CLOSE_S)
        session: Any = self._opened  # Zenoh's stub leaves the method untyped
        if session is not None:
            session.close()

    def _open(self) -> None:
        library = zenoh_library()
        while not self._ended.is_set():
            try:
                opened = library.open(self._config)
            except library.ZError as error:
                self._why = f" ({str(error).partition(' at /')[0]}); it is not running, or refuses the credentials"
                self._ended.wait(_AGAIN_S)
                continue
            self._opened = opened
            if self._ended.is_set():  # the link was closed while the session was opened
                opened.close()
                return
            on_event = library.handlers.Callback(self._on_event, indirect=False)
            self._listener = opened.info.declare_transport_events_listener(on_event, history=True)
            return

    def _on_event(self, event: "zenoh.TransportEvent") -> None:
        with self._changed:
            gone = event.kind == zenoh_library().SampleKind.DELETE
            change = self._connected.discard if gone else self._connected.add
            change(str(event.transport.zid))
            self._changed.notify_all()


def config(address: ZenohAddress, open_ms: int = 0, more: Mapping[str, Any] | None = None) -> "zenoh.Config":
    """Build the configuration of a session with a router.

    Args:
        address: of the router, with credentials and certificates.
        open_ms: time for which opening waits for the router, milliseconds; 0: one try.
        more: further entries of Zenoh's configuration, by path.

    Raises:
        UsageError: Zenoh refuses an entry.
    """
    secure = {
        "root_ca_certificate": address.ca,
        "connect_certificate": address.cert,
        "connect_private_key": address.key,
    }
    files: dict[str, Any] = {name: file for name, file in secure.items() if file is not None}
    settings = session_config([address.endpoint], address.user, address.password, open_ms)
    if files:
        settings["transport/link/tls"] = files | ({"enable_mtls": True} if address.cert is not None else {})
    built: zenoh.Config = zenoh_library().Config()
    try:
        for name, value in (settings | dict(more or {})).items():
            built.insert_json5(name, json.dumps(value))
    except zenoh_library().ZError as error:
        raise UsageError(f"{address.endpoint}: {error}") from error
    return built


def zenoh_library() -> Any:
    """Import Zenoh's library; raises MissingLibraryError if it is not installed."""
    try:
        import zenoh  # noqa: PLC0415 - optional: only clients over Zenoh need it
    except ModuleNotFoundError as error:
        raise MissingLibraryError(f"Zenoh is not installed; install it with: {install_hint('zenoh')}") from error
    return zenoh
