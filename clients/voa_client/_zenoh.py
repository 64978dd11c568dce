"""Zenoh: calls as queries, news as what the service puts on a session's key.

A transport is made without a router and joins by itself when there is one, again and again; a call waits for the link
within its own time. Zenoh's callbacks run on its network threads, so they only hand over what they got.
"""

import asyncio
import json
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Any

from voa_client._answers import Reply
from voa_client._calls import Call
from voa_client._errors import TimedOutError, UnreachableError
from voa_client._transport import Hint, Lost, Tell
from voa_client._zenoh_address import ZenohAddress
from voa_client._zenoh_link import LOOK_S, Links, joined, zenoh_library
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import CHUNK, Attachment, Keys

if TYPE_CHECKING:
    import zenoh

_ASK_S = 3.0  # puts are lost without a word while a link is down
_GRACE_S = 1.0  # Zenoh ends a query by itself when its time is over; it gets a moment to say so
_JOIN_S = 0.2  # a watch begins again where it cannot begin now
_MOST_DIGITS = 18
_MOST_BODY_BYTES = 8_000_000
"""Of a version that is kept until the service was asked; larger ones are asked for."""


class ZenohTransport:
    """A service behind a router."""

    ask_s = _ASK_S

    def __init__(self, address: ZenohAddress) -> None:
        self._keys = Keys(address.root)
        self._links = Links(address)

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        call.check_has_rpc()
        asked = self._keys.rpc(call.rpc)
        until = time.monotonic() + seconds
        session = self._links.calls.wait(seconds)
        replies: list[zenoh.Reply] = []
        complete = threading.Event()
        left = max(LOOK_S, until - time.monotonic())
        _ask(session, asked, call, key, left, replies.append, complete.set)
        if not complete.wait(left + _GRACE_S):
            raise TimedOutError(f"no answer at {asked} within {seconds:.3g} s")
        return _reply(asked, replies)

    @contextmanager
    def watch(self, session_id: str, seen: int | None, tell: Tell) -> Iterator[None]:  # noqa: ARG002 - the port's
        """As the port says."""
        try:
            session = self._links.news().wait(_JOIN_S)
        except UnreachableError as error:
            tell(Lost(error))
            yield
            return
        subscriber = _subscribe(session, self._keys, session_id, tell)
        try:
            yield
        finally:
            _undeclare(subscriber)

    def close(self) -> None:
        """As the port says."""
        self._links.close()


class AsyncZenohTransport:
    """The same for asyncio."""

    ask_s = _ASK_S

    def __init__(self, address: ZenohAddress) -> None:
        self._keys = Keys(address.root)
        self._links = Links(address)

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        call.check_has_rpc()
        asked = self._keys.rpc(call.rpc)
        until = time.monotonic() + seconds
        session = await joined(self._links.calls, seconds)
        loop = asyncio.get_running_loop()
        replies: list[zenoh.Reply] = []
        complete = asyncio.Event()
        left = max(LOOK_S, until - time.monotonic())
        _ask(session, asked, call, key, left, _into(loop, replies.append), _into(loop, complete.set))
        try:
            async with asyncio.timeout(left + _GRACE_S):
                await complete.wait()
        except TimeoutError as error:
            raise TimedOutError(f"no answer at {asked} within {seconds:.3g} s") from error
        return _reply(asked, replies)

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, tell: Tell) -> AsyncIterator[None]:  # noqa: ARG002 - the port's
        """As the port says."""
        try:
            session = await joined(self._links.news(), _JOIN_S)
        except UnreachableError as error:
            tell(Lost(error))
            yield
            return
        subscriber = await asyncio.to_thread(_subscribe, session, self._keys, session_id, tell)
        try:
            yield
        finally:
            await asyncio.to_thread(_undeclare, subscriber)

    async def close(self) -> None:
        """As the port says."""
        await asyncio.to_thread(self._links.close)


def _ask(
    session: "zenoh.Session",
    asked: str,
    call: Call[Any],
    key: str | None,
    seconds: float,
    reply: "Callable[[zenoh.Reply], object]",
    done: Callable[[], object],
) -> None:
    """Send a query; `reply` and `done` are called on Zenoh's threads."""
    library = zenoh_library()
    try:
        session.get(
            asked,
            library.handlers.Callback(reply, done, indirect=False),
            payload=call.payload(),
            encoding=library.Encoding.APPLICATION_JSON,
            attachment=Attachment(id=key, wire=WIRE_VERSION).model_dump_json(exclude_none=True),
            timeout=seconds,
        )
    except library.ZError as error:
        raise UnreachableError(f"cannot ask at {asked}: {error}") from error


def _reply(asked: str, replies: "list[zenoh.Reply]") -> Reply:
    """What came back of a query.

    Raises:
        UnreachableError: nothing. That is no proof that nobody is there: a link that broke, a router that does not
            let this user ask, and a service that is not running all look the same.
        TimedOutError: somebody had the query and did not answer.
    """
    for reply in replies:
        if reply.ok is not None:
            attached = reply.ok.attachment
            return Reply(reply.ok.payload.to_bytes(), wire=None if attached is None else _wire(attached.to_bytes()))
    for reply in replies:
        if reply.err is not None:
            body = reply.err.payload.to_bytes()
            if str(reply.err.encoding).startswith("application/json"):
                return Reply(body, refused=True)
            kind = TimedOutError if body == b"Timeout" else UnreachableError
            raise kind(f"no answer at {asked}: {body.decode(errors='replace')}")
    raise UnreachableError(f"nobody answers at {asked}: the service is not there, or this user may not ask it")


def _wire(attachment: bytes) -> int | None:
    try:
        told = json.loads(attachment)
    except (ValueError, RecursionError):
        return None
    wire = told.get("wire") if isinstance(told, dict) else None
    return wire if isinstance(wire, int) else None


def _subscribe(session: "zenoh.Session", keys: Keys, session_id: str, tell: Tell) -> "zenoh.Subscriber[None] | None":
    """Hear what is put on a session's key; None for an id that can be no part of a key, so nothing is put there."""
    if not CHUNK.fullmatch(session_id):
        return None
    library = zenoh_library()

    def receive(sample: "zenoh.Sample") -> None:
        tell(_hint(sample))

    try:
        subscriber: zenoh.Subscriber[None] = session.declare_subscriber(
            keys.belief(session_id), library.handlers.Callback(receive, indirect=False)
        )
    except library.ZError as error:
        raise UnreachableError(f"cannot follow {session_id}: {error}") from error
    return subscriber


def _hint(sample: "zenoh.Sample") -> Hint:
    """Content of a sample, be it from the service or from anybody else who may put there.

    A delete, and a put without a version beside it, say that there is something to ask for.
    """
    said = b"" if sample.attachment is None else sample.attachment.to_bytes()
    version = int(said) if said.isdigit() and len(said) <= _MOST_DIGITS else None
    is_kept = version is not None and len(sample.payload) <= _MOST_BODY_BYTES
    return Hint(version, sample.payload.to_bytes() if is_kept else b"")


def _undeclare(subscriber: "zenoh.Subscriber[None] | None") -> None:
    if subscriber is not None:
        declared: Any = subscriber
        with suppress(zenoh_library().ZError):  # the session was closed before
            declared.undeclare()


def _into(loop: asyncio.AbstractEventLoop, function: Callable[..., object]) -> Callable[..., None]:
    """Calls a function in a loop, from any thread; not at all once the loop is closed."""

    def call(*given: object) -> None:
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(function, *given)

    return call
