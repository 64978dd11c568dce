"""The port: what a client needs of a transport, whatever it is made of.

A transport makes one attempt at a time. Trying again, reading answers, and putting a session's versions in order are
the client's; so they are the same everywhere.
"""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol

from voa_client._answers import Reply
from voa_client._calls import Call
from voa_client._errors import VoaClientError


@dataclass(frozen=True)
class State:
    """A session at some version, from the service over a connection of its own: its body, as JSON."""

    body: bytes


@dataclass(frozen=True)
class Deleted:
    """The session has ended, the service says over a connection of its own."""


@dataclass(frozen=True)
class Hint:
    """A reason to ask the service how a session stands, from anybody who may put on the session's key.

    Attributes:
        version: what the session is said to be at; None: nothing sensible is said, or that it has ended.
        body: the session at that version, if it is true; b"" where none is said.
    """

    version: int | None
    body: bytes = b""


@dataclass(frozen=True)
class Lost:
    """This watch hears no more; it must be begun again."""

    error: VoaClientError


News = State | Deleted | Hint | Lost
Tell = Callable[[News], None]
"""Takes news of a session. It only keeps them, and may be called from any thread."""


class Transport(Protocol):
    """Carries calls to a service, and news of sessions back."""

    @property
    def ask_s(self) -> float | None:
        """A watcher asks for the session when it begins, and after so many seconds of silence.

        None: there is no need to. The watch says by itself how things stand, and notices when it is cut off.
        """

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """Make one attempt.

        Args:
            call: what to ask.
            key: idempotency key.
            seconds: how long it may take.

        Raises:
            UnreachableError: there was no answer.
            UsageError: the transport cannot carry this call.
        """

    def watch(self, session_id: str, seen: int | None, tell: Tell) -> AbstractContextManager[None]:
        """Hear of a session's versions for the length of a `with`.

        Args:
            session_id: which.
            seen: the newest version that is known; None: none.
            tell: called with each version; some may be missing, come twice, or too late.
        """

    def close(self) -> None:
        """Release what is held; safe to call twice."""


class AsyncTransport(Protocol):
    """The same for asyncio."""

    @property
    def ask_s(self) -> float | None:
        """As in `Transport`."""

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As in `Transport`."""

    def watch(self, session_id: str, seen: int | None, tell: Tell) -> AbstractAsyncContextManager[None]:
        """As in `Transport`."""

    async def close(self) -> None:
        """As in `Transport`."""
