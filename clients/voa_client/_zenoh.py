"""Transports over Zenoh: calls are queries, news are samples that the service puts on a session's key.

A transport can be made while no router is there: it connects in the background as soon as one answers, and reconnects.
A call waits for the connection within its own time limit. Zenoh runs callbacks on its network threads, so they only
pass on what they receive.
"""

import asyncio
import json
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Any

from voa_client._api_key import ApiKey, attachment
from voa_client._call import Call
from voa_client._errors import TimedOutError, UnreachableError
from voa_client._responses import Response
from voa_client._transport import Hint, Lost, Receive
from voa_client._zenoh_address import ZenohAddress
from voa_client._zenoh_link import CHECK_S, Links, joined, zenoh_library
from voa_msgs.keys import CHUNK, Keys

if TYPE_CHECKING:
    import zenoh

_POLL_S = 3.0  # samples are lost without notice while a link is down
_GRACE_S = 1.0  # Zenoh ends a query by itself when its time is over, and may report it a little late
_JOIN_S = 0.2  # a watch that cannot start now is restarted
_MOST_DIGITS = 18
_MOST_BODY_BYTES = 8_000_000
"""Largest body of a hint that is kept; of larger ones, only the version is."""


def _silence(target: str, seconds: float) -> str:
    return f"no response at {target} within {seconds:.3g} s: is the service joined to this router? (`voa doctor`)"


class ZenohTransport:
    """Transport to a service behind a Zenoh router.

    Args:
        address: of the router.
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = _POLL_S

    def __init__(self, address: ZenohAddress, key: ApiKey | None = None) -> None:
        self._key = ApiKey.given() if key is None else key
        self._keys = Keys(address.root)
        self._links = Links(address)

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Send a call as a query, and return the response; raises UnreachableError, TimedOutError or UsageError."""
        call.check_has_rpc()
        target = self._keys.rpc(call.rpc)
        until = time.monotonic() + seconds
        session = self._links.calls.wait(seconds)
        replies: list[zenoh.Reply] = []
        complete = threading.Event()
        left = max(CHECK_S, until - time.monotonic())
        beside = attachment(key, self._key)
        _query(session, target, call, beside, left, replies.append, complete.set)
        if not complete.wait(left + _GRACE_S):
            raise TimedOutError(_silence(target, seconds))
        return _response(target, replies)

    @contextmanager
    def watch(self, session_id: str, seen: int | None, receive: Receive) -> Iterator[None]:  # noqa: ARG002 - of the protocol
        """Pass hints of a session's versions on to `receive`, for the length of a `with`."""
        try:
            session = self._links.news().wait(_JOIN_S)
        except UnreachableError as error:
            receive(Lost(error))
            yield
            return
        subscriber = _subscribe(session, self._keys, session_id, receive)
        try:
            yield
        finally:
            _undeclare(subscriber)

    def close(self) -> None:
        """Close the connections to the router."""
        self._links.close()


class AsyncZenohTransport:
    """Transport to a service behind a Zenoh router, for asyncio.

    Args:
        address: of the router.
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = _POLL_S

    def __init__(self, address: ZenohAddress, key: ApiKey | None = None) -> None:
        self._key = ApiKey.given() if key is None else key
        self._keys = Keys(address.root)
        self._links = Links(address)

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Send a call as a query, and return the response; raises UnreachableError, TimedOutError or UsageError."""
        call.check_has_rpc()
        target = self._keys.rpc(call.rpc)
        until = time.monotonic() + seconds
        session = await joined(self._links.calls, seconds)
        loop = asyncio.get_running_loop()
        replies: list[zenoh.Reply] = []
        complete = asyncio.Event()
        left = max(CHECK_S, until - time.monotonic())
        beside = attachment(key, self._key)
        _query(session, target, call, beside, left, _into(loop, replies.append), _into(loop, complete.set))
        try:
            async with asyncio.timeout(left + _GRACE_S):
                await complete.wait()
        except TimeoutError as error:
            raise TimedOutError(_silence(target, seconds)) from error
        return _response(target, replies)

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, receive: Receive) -> AsyncIterator[None]:  # noqa: ARG002 - of the protocol
        """Pass hints of a session's versions on to `receive`, for the length of a `with`."""
        try:
            session = await joined(self._links.news(), _JOIN_S)
        except UnreachableError as error:
            receive(Lost(error))
            yield
            return
        subscriber = await asyncio.to_thread(_subscribe, session, self._keys, session_id, receive)
        try:
            yield
        finally:
            await asyncio.to_thread(_undeclare, subscriber)

    async def close(self) -> None:
        """Close the connections to the router."""
        await asyncio.to_thread(self._links.close)


def _query(
    session: "zenoh.Session",
    target: str,
    call: Call[Any],
    beside: str,
    seconds: float,
    reply: "Callable[[zenoh.Reply], object]",
    done: Callable[[], object],
) -> None:
    """Send a query; `reply` and `done` are called on Zenoh's threads."""
    library = zenoh_library()
    try:
        session.get(
            target,
            library.handlers.Callback(reply, done, indirect=False),
            payload=call.payload(),
            encoding=library.Encoding.APPLICATION_JSON,
            attachment=beside,
            timeout=seconds,
        )
    except library.ZError as error:
        raise UnreachableError(f"cannot send a query to {target}: {error}") from error


def _response(target: str, replies: "list[zenoh.Reply]") -> Response:
    """Return the response among the replies to a query.

    Raises:
        UnreachableError: there is no reply: the link broke, the router does not let this user query the service, or the
            service is not running; Zenoh does not report which.
        TimedOutError: the query was received and not answered in time.
    """
    for reply in replies:
        if reply.ok is not None:
            attached = reply.ok.attachment
            return Response(reply.ok.payload.to_bytes(), wire=None if attached is None else _wire(attached.to_bytes()))
    for reply in replies:
        if reply.err is not None:
            body = reply.err.payload.to_bytes()
            if str(reply.err.encoding).startswith("application/json"):
                return Response(body, refused=True)
            kind = TimedOutError if body == b"Timeout" else UnreachableError
            raise kind(f"no answer at {target}: {body.decode(errors='replace')}")
    raise UnreachableError(
        f"no answer at {target}: no service runs there, or the router does not let this user query it"
    )


def _wire(attachment: bytes) -> int | None:
    try:
        fields = json.loads(attachment)
    except (ValueError, RecursionError):
        return None
    wire = fields.get("wire") if isinstance(fields, dict) else None
    return wire if isinstance(wire, int) else None


def _subscribe(
    session: "zenoh.Session", keys: Keys, session_id: str, receive: Receive
) -> "zenoh.Subscriber[None] | None":
    """Subscribe to a session's key; None if the id cannot be part of a key, so that no sample can exist."""
    if not CHUNK.fullmatch(session_id):
        return None
    library = zenoh_library()

    def on_sample(sample: "zenoh.Sample") -> None:
        receive(_hint(sample))

    try:
        subscriber: zenoh.Subscriber[None] = session.declare_subscriber(
            keys.belief(session_id), library.handlers.Callback(on_sample, indirect=False)
        )
    except library.ZError as error:
        raise UnreachableError(f"cannot follow {session_id}: {error}") from error
    return subscriber


def _hint(sample: "zenoh.Sample") -> Hint:
    """Turn a sample on a session's key, from the service or any other program, into a hint.

    A delete, and a sample without a version in its attachment, give a hint without a version.
    """
    stated = b"" if sample.attachment is None else sample.attachment.to_bytes()
    version = int(stated) if stated.isdigit() and len(stated) <= _MOST_DIGITS else None
    is_kept = version is not None and len(sample.payload) <= _MOST_BODY_BYTES
    return Hint(version, sample.payload.to_bytes() if is_kept else b"")


def _undeclare(subscriber: "zenoh.Subscriber[None] | None") -> None:
    if subscriber is not None:
        declared: Any = subscriber
        with suppress(zenoh_library().ZError):  # the session was closed before
            declared.undeclare()


def _into(loop: asyncio.AbstractEventLoop, function: Callable[..., object]) -> Callable[..., None]:
    """Make a function that calls another in an event loop, from any thread; it does nothing once the loop is closed."""

    def call(*arguments: object) -> None:
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(function, *arguments)

    return call
