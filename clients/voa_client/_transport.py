"""Protocols of transports, which carry calls to a service and news of sessions back.

A transport makes single attempts. Retries, the reading of responses, and the order of a session's versions are the
client's part, and so are equal for all transports.
"""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol

from voa_client._call import Call
from voa_client._errors import VoaClientError
from voa_client._responses import Response


@dataclass(frozen=True)
class State:
    """News of a session's version, from the service's own connection: its body, as JSON."""

    body: bytes


@dataclass(frozen=True)
class Deleted:
    """News from the service's own connection that the session was deleted."""


@dataclass(frozen=True)
class Hint:
    """News of a session from a key on which any program may publish: a reason to request its version from the service.

    Attributes:
        version: that the session is claimed to have; None: none, or the session is claimed to be deleted.
        body: the session at that version, if the claim is true; b"" if there is none.
    """

    version: int | None
    body: bytes = b""


@dataclass(frozen=True)
class Lost:
    """News that a watch has ended because of an error, and has to be restarted."""

    error: VoaClientError


News = State | Deleted | Hint | Lost
Receive = Callable[[News], None]
"""Function that takes news of a session; it returns at once, and may be called from any thread."""


class Transport(Protocol):
    """Carrier of calls to a service, and of news of sessions back."""

    @property
    def poll_s(self) -> float | None:
        """Polling interval: a follower requests the session when a watch starts, and after so many seconds of silence.

        None: no polling, because the watch reports the current version by itself, and notices when it is cut off.
        """

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Make one attempt.

        Args:
            call: the request.
            key: idempotency key; None: the call is a read.
            seconds: longest duration of the attempt.

        Raises:
            UnreachableError: no response was received.
            UsageError: the transport cannot carry this call.
        """

    def watch(self, session_id: str, seen: int | None, receive: Receive) -> AbstractContextManager[None]:
        """Pass news of a session's versions on to `receive`, for the length of a `with`.

        Args:
            session_id: of the session.
            seen: newest version that is known; None: none.
            receive: called with each piece of news; versions may be missing, repeated, or late.
        """

    def close(self) -> None:
        """Release connections and threads; may be called twice."""


class AsyncTransport(Protocol):
    """Carrier of calls to a service, and of news of sessions back, for asyncio."""

    @property
    def poll_s(self) -> float | None:
        """Polling interval: a follower requests the session when a watch starts, and after so many seconds of silence.

        None: no polling, because the watch reports the current version by itself, and notices when it is cut off.
        """

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Make one attempt.

        Args:
            call: the request.
            key: idempotency key; None: the call is a read.
            seconds: longest duration of the attempt.

        Raises:
            UnreachableError: no response was received.
            UsageError: the transport cannot carry this call.
        """

    def watch(self, session_id: str, seen: int | None, receive: Receive) -> AbstractAsyncContextManager[None]:
        """Pass news of a session's versions on to `receive`, for the length of a `with`.

        Args:
            session_id: of the session.
            seen: newest version that is known; None: none.
            receive: called with each piece of news; versions may be missing, repeated, or late.
        """

    async def close(self) -> None:
        """Release connections and threads; may be called twice."""
