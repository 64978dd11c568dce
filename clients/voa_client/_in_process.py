"""Transports to a service in the same process, for tests and for a laptop without a network."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any, Protocol

from voa_client._api_key import ApiKey, attachment
from voa_client._call import Call
from voa_client._errors import TimedOutError
from voa_client._responses import Response
from voa_client._transport import Receive

_POLL_S = 0.05


class DispatcherResponse(Protocol):
    """The response of a dispatcher to an rpc."""

    @property
    def body(self) -> bytes:
        """Message or problem document, as JSON."""

    @property
    def is_problem(self) -> bool:
        """True if the body is a problem document."""


class Dispatcher(Protocol):
    """A service in this process, which answers the rpcs of Zenoh by direct calls."""

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> DispatcherResponse:
        """Answer an rpc: return the response when it is ready; may be called from any thread."""


class InProcessTransport:
    """Transport to a dispatcher in this process; an attempt takes as long as the dispatcher does.

    Args:
        service: the dispatcher; the caller closes it.
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = _POLL_S

    def __init__(self, service: Dispatcher, key: ApiKey | None = None) -> None:
        self._service = service
        self._key = ApiKey.given() if key is None else key

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:  # noqa: ARG002 - of the protocol
        """Call the dispatcher, and return its response."""
        return _send(self._service, call, attachment(key, self._key))

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
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = _POLL_S

    def __init__(self, service: Dispatcher, key: ApiKey | None = None) -> None:
        self._service = service
        self._key = ApiKey.given() if key is None else key

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Call the dispatcher; raises TimedOutError if it takes too long, and then the call continues in its thread."""
        try:
            async with asyncio.timeout(seconds):
                return await asyncio.to_thread(_send, self._service, call, attachment(key, self._key))
        except TimeoutError as error:
            raise TimedOutError(f"{call.rpc}: no answer within {seconds:.3g} s") from error

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, receive: Receive) -> AsyncIterator[None]:  # noqa: ARG002 - of the protocol
        """Pass on no news: followers poll, which is cheap within a process."""
        yield

    async def close(self) -> None:
        """Do nothing: the caller closes the dispatcher."""


def _send(service: Dispatcher, call: Call[Any], beside: str) -> Response:
    call.check_has_rpc()
    response = service.answer(call.rpc, call.payload(), beside.encode())
    return Response(response.body, refused=response.is_problem)
