"""Transports to a service in the same process, for tests and for a laptop without a network."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any, Protocol

from voa_client._answers import Reply
from voa_client._calls import Call
from voa_client._errors import TimedOutError
from voa_client._transport import Receive
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment

_POLL_S = 0.05


class Answered(Protocol):
    """An answer of a dispatcher."""

    @property
    def body(self) -> bytes:
        """Message or problem document, as JSON."""

    @property
    def is_problem(self) -> bool:
        """True if the body is a problem document."""


class Dispatcher(Protocol):
    """A service that is called directly: it answers the rpcs that it answers over Zenoh."""

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> Answered:
        """Answer an rpc; blocks until the answer is there, and may be called from any thread."""


class InProcessTransport:
    """Transport to a dispatcher in this process; an attempt takes as long as the dispatcher does.

    Args:
        service: the dispatcher; the caller closes it.
    """

    poll_s = _POLL_S

    def __init__(self, service: Dispatcher) -> None:
        self._service = service

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:  # noqa: ARG002 - of the protocol
        """Call the dispatcher, and return its answer."""
        return _send(self._service, call, key)

    @contextmanager
    def watch(self, session_id: str, seen: int | None, receive: Receive) -> Iterator[None]:  # noqa: ARG002 - of the protocol
        """Pass on no news: followers poll, which is cheap within a process."""
        yield

    def close(self) -> None:
        """Do nothing: the caller closes the dispatcher."""


class AsyncInProcessTransport:
    """Transport to a dispatcher in this process, for asyncio; calls run in worker threads.

    Args:
        service: the dispatcher; the caller closes it.
    """

    poll_s = _POLL_S

    def __init__(self, service: Dispatcher) -> None:
        self._service = service

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """Call the dispatcher; raises TimedOutError if it takes too long, and then the call continues in its thread."""
        try:
            async with asyncio.timeout(seconds):
                return await asyncio.to_thread(_send, self._service, call, key)
        except TimeoutError as error:
            raise TimedOutError(f"{call.rpc}: no answer within {seconds:.3g} s") from error

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, receive: Receive) -> AsyncIterator[None]:  # noqa: ARG002 - of the protocol
        """Pass on no news: followers poll, which is cheap within a process."""
        yield

    async def close(self) -> None:
        """Do nothing: the caller closes the dispatcher."""


def _send(service: Dispatcher, call: Call[Any], key: str | None) -> Reply:
    call.check_has_rpc()
    attachment = Attachment(id=key, wire=WIRE_VERSION).model_dump_json(exclude_none=True).encode()
    answered = service.answer(call.rpc, call.payload(), attachment)
    return Reply(answered.body, refused=answered.is_problem)
