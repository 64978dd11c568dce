"""Zenoh: calls as queries, news as what the service puts on a session's key.

The session opens without a router and joins by itself when there is one, again and again; a call waits for the link
within its own time. Zenoh's library is imported when a transport is made, not before: robots that speak HTTP do
without it. Its callbacks run on its network threads, so they only hand over what they got.
"""

import asyncio
import json
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Any

from voa_client.answers import Reply
from voa_client.calls import Call
from voa_client.errors import TimedOutError, UnreachableError, UsageError, VoaClientError
from voa_client.transport import Deleted, State, Tell
from voa_client.zenoh_address import ZenohAddress
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import CHUNK, Attachment, Keys

if TYPE_CHECKING:
    import zenoh

_ASK_S = 3.0  # puts are lost without a word while a link is down
_GRACE_S = 1.0  # Zenoh ends a query by itself when its time is over; it gets a moment to say so
_LOOK_S = 0.02


class MissingLibraryError(VoaClientError, ImportError):
    """Zenoh's library is not installed; says how to get it."""


class ZenohTransport:
    """A service behind a router."""

    ask_s = _ASK_S

    def __init__(self, address: ZenohAddress) -> None:
        self._address = address
        self._keys = Keys(address.root)
        self._link = _Link(address)

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        _check(call)
        until = time.monotonic() + seconds
        if not self._link.wait(seconds):
            raise _no_link(self._address, seconds)
        replies: list[zenoh.Reply] = []
        complete = threading.Event()
        left = max(_LOOK_S, until - time.monotonic())
        asked = self._keys.rpc(call.rpc)
        _ask(self._link.session, asked, call, key, left, replies.append, complete.set)
        if not complete.wait(left + _GRACE_S):
            raise TimedOutError(f"no answer at {asked} within {seconds:.3g} s")
        return _reply(asked, replies)

    @contextmanager
    def watch(self, session_id: str, seen: int | None, tell: Tell) -> Iterator[None]:  # noqa: ARG002 - the port's
        """As the port says."""
        subscriber = _subscribe(self._link.session, self._keys, session_id, tell)
        try:
            yield
        finally:
            _undeclare(subscriber)

    def close(self) -> None:
        """As the port says."""
        self._link.close()


class AsyncZenohTransport:
    """The same for asyncio; opened by the first call."""

    ask_s = _ASK_S

    def __init__(self, address: ZenohAddress) -> None:
        _library()
        self._address = address
        self._keys = Keys(address.root)
        self._opening = asyncio.Lock()
        self._link: _Link | None = None

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        _check(call)
        asked = self._keys.rpc(call.rpc)
        began = time.monotonic()
        link = await self._opened()
        try:
            async with asyncio.timeout(seconds):
                while not link.is_up:
                    await asyncio.sleep(_LOOK_S)
        except TimeoutError as error:
            raise _no_link(self._address, seconds) from error
        loop = asyncio.get_running_loop()
        replies: list[zenoh.Reply] = []
        complete = asyncio.Event()
        left = max(_LOOK_S, began + seconds - time.monotonic())
        _ask(link.session, asked, call, key, left, _into(loop, replies.append), _into(loop, complete.set))
        try:
            async with asyncio.timeout(left + _GRACE_S):
                await complete.wait()
        except TimeoutError as error:
            raise TimedOutError(f"no answer at {asked} within {seconds:.3g} s") from error
        return _reply(asked, replies)

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, tell: Tell) -> AsyncIterator[None]:  # noqa: ARG002
        """As the port says."""
        link = await self._opened()
        told = _into(asyncio.get_running_loop(), tell)
        subscriber = await asyncio.to_thread(_subscribe, link.session, self._keys, session_id, told)
        try:
            yield
        finally:
            await asyncio.to_thread(_undeclare, subscriber)

    async def close(self) -> None:
        """As the port says."""
        async with self._opening:
            link, self._link = self._link, None
        if link is not None:
            await asyncio.to_thread(link.close)

    async def _opened(self) -> "_Link":
        async with self._opening:
            if self._link is None:
                self._link = await asyncio.to_thread(_Link, self._address)
            return self._link


class _Link:
    """An open session, and whether it is connected."""

    def __init__(self, address: ZenohAddress) -> None:
        library = _library()
        self._connected: set[str] = set()
        self._changed = threading.Condition()
        try:
            self.session: zenoh.Session = library.open(config(address))
        except library.ZError as error:
            raise UsageError(f"{address.endpoint}: {error}") from error
        heard = library.handlers.Callback(self._heard, indirect=False)
        self._listener = self.session.info.declare_transport_events_listener(heard, history=True)

    @property
    def is_up(self) -> bool:
        """Whether anyone is at the other end."""
        return bool(self._connected)

    def wait(self, seconds: float) -> bool:
        """Whether it came up in time."""
        with self._changed:
            return self._changed.wait_for(lambda: self.is_up, seconds)

    def close(self) -> None:
        """An open session keeps threads and would hear the service for ever."""
        session: Any = self.session  # Zenoh's stub leaves these methods untyped
        session.close()

    def _heard(self, event: "zenoh.TransportEvent") -> None:
        with self._changed:
            change = self._connected.discard if event.kind.name == "DELETE" else self._connected.add
            change(str(event.transport.zid))
            self._changed.notify_all()


def config(address: ZenohAddress) -> "zenoh.Config":
    """The configuration of a session: it reaches the one router, nobody reaches it, and it never gives up.

    Shared memory is off: it gains nothing at our sizes, and under load it loses queries without a word.
    """
    secure = {
        "root_ca_certificate": address.ca,
        "connect_certificate": address.cert,
        "connect_private_key": address.key,
    }
    link = {name: file for name, file in secure.items() if file is not None}
    settings: dict[str, Any] = {
        "mode": "peer",
        "listen/endpoints": [],
        "connect/endpoints": [address.endpoint],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2},
        "open/return_conditions": {"connect_scouted": False, "declares": False},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    if address.user is not None:
        settings["transport/auth/usrpwd"] = {"user": address.user, "password": address.password or ""}
    if link:
        settings["transport/link/tls"] = link | ({"enable_mtls": True} if address.cert is not None else {})
    built: zenoh.Config = _library().Config()
    for name, value in settings.items():
        built.insert_json5(name, json.dumps(value))
    return built


def _library() -> Any:
    try:
        import zenoh  # noqa: PLC0415 - optional: only who speaks Zenoh needs it
    except ModuleNotFoundError as error:
        raise MissingLibraryError("Zenoh is not installed; install it with: pip install 'voa[zenoh]'") from error
    return zenoh


def _check(call: Call[Any]) -> None:
    if call.if_match is not None:
        raise UsageError(f"{call.rpc}: if_match goes over HTTP only; Zenoh has no such condition")


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
    library = _library()
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
    except ValueError:
        return None
    wire = told.get("wire") if isinstance(told, dict) else None
    return wire if isinstance(wire, int) else None


def _subscribe(session: "zenoh.Session", keys: Keys, session_id: str, tell: Tell) -> "zenoh.Subscriber[None] | None":
    """Hear what is put on a session's key; None for an id that can be no part of a key, so nothing is put there."""
    if not CHUNK.fullmatch(session_id):
        return None
    library = _library()

    def heard(sample: "zenoh.Sample") -> None:
        tell(Deleted() if sample.kind == library.SampleKind.DELETE else State(sample.payload.to_bytes()))

    try:
        subscriber: zenoh.Subscriber[None] = session.declare_subscriber(
            keys.belief(session_id), library.handlers.Callback(heard, indirect=False)
        )
    except library.ZError as error:
        raise UnreachableError(f"cannot follow {session_id}: {error}") from error
    return subscriber


def _undeclare(subscriber: "zenoh.Subscriber[None] | None") -> None:
    if subscriber is not None:
        declared: Any = subscriber
        with suppress(_library().ZError):  # the session was closed before
            declared.undeclare()


def _into(loop: asyncio.AbstractEventLoop, function: Callable[..., object]) -> Callable[..., None]:
    """Calls a function in a loop, from any thread; not at all once the loop is closed."""

    def call(*given: object) -> None:
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(function, *given)

    return call


def _no_link(address: ZenohAddress, seconds: float) -> TimedOutError:
    return TimedOutError(f"no link to {address.endpoint} within {seconds:.3g} s")
