"""In-process: the service in the same program, for tests and for a laptop without a network."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any, Protocol

from voa_client._answers import Reply
from voa_client._calls import Call
from voa_client._errors import TimedOutError
from voa_client._transport import Tell
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment

_ASK_S = 0.05


class Answered(Protocol):
    """What a dispatcher answers."""

    @property
    def body(self) -> bytes:
        """JSON."""

    @property
    def is_problem(self) -> bool:
        """Whether the body is a problem document."""


class Dispatcher(Protocol):
    """A service without an entrypoint: it answers rpcs, as over Zenoh."""

    def answer(self, method: str, payload: bytes, attachment: bytes | None = None) -> Answered:
        """Answer one call; blocks, and may be called from any thread."""


class InProcessTransport:
    """Calls a dispatcher; an attempt takes as long as the dispatcher does."""

    ask_s = _ASK_S

    def __init__(self, service: Dispatcher) -> None:
        self._service = service

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:  # noqa: ARG002 - the port's
        """As the port says."""
        return _send(self._service, call, key)

    @contextmanager
    def watch(self, session_id: str, seen: int | None, tell: Tell) -> Iterator[None]:  # noqa: ARG002 - the port's
        """As the port says: asking is cheap here, so nothing is told."""
        yield

    def close(self) -> None:
        """The service belongs to whoever made it."""


class AsyncInProcessTransport:
    """The same for asyncio, in worker threads."""

    ask_s = _ASK_S

    def __init__(self, service: Dispatcher) -> None:
        self._service = service

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says; a call that takes too long goes on behind."""
        try:
            async with asyncio.timeout(seconds):
                return await asyncio.to_thread(_send, self._service, call, key)
        except TimeoutError as error:
            raise TimedOutError(f"{call.rpc}: no answer within {seconds:.3g} s") from error

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, tell: Tell) -> AsyncIterator[None]:  # noqa: ARG002 - the port's
        """As the port says: asking is cheap here, so nothing is told."""
        yield

    async def close(self) -> None:
        """The service belongs to whoever made it."""


def _send(service: Dispatcher, call: Call[Any], key: str | None) -> Reply:
    call.check_has_rpc()
    attachment = Attachment(id=key, wire=WIRE_VERSION).model_dump_json(exclude_none=True).encode()
    answered = service.answer(call.rpc, call.payload(), attachment)
    return Reply(answered.body, refused=answered.is_problem)
