"""HTTP: calls as requests, news as server-sent events."""

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any

import httpx2

from voa_client._answers import Reply, check, made_up
from voa_client._calls import Call, get_session
from voa_client._errors import TimedOutError, UnexpectedAnswerError, UnreachableError, UsageError, VoaClientError
from voa_client._transport import Deleted, Lost, News, State, Tell
from voa_msgs import WIRE_VERSION

_WIRE = "Voa-Wire-Version"
_CONNECT_S = 5.0
_SILENCE_S = 20.0  # the service says that it is alive every 15
_MOST_EVENT_BYTES = 64_000_000
_MOST_DIGITS = 18
_JSON = {"Content-Type": "application/json"}


class HttpTransport:
    """A service at a URL.

    Args:
        url: `http://host:port`, perhaps with a path before the service's own.
        network: what carries the bytes; None: sockets.
    """

    ask_s = None

    def __init__(self, url: str, network: httpx2.BaseTransport | None = None) -> None:
        self._url = url
        self._http = httpx2.Client(base_url=checked(url), transport=network)
        self._readers: set[_Reader] = set()

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        try:
            return _reply(self._http.request(timeout=seconds, **_request(call, key)))
        except httpx2.RequestError as error:
            raise _error(self._url, error) from error

    @contextmanager
    def watch(self, session_id: str, seen: int | None, tell: Tell) -> Iterator[None]:
        """As the port says: a thread reads the stream, so that whoever waits for news can wait as long as they like."""
        reader = _Reader(self._http, self._url, _stream(session_id, seen), tell)
        self._readers.add(reader)
        reader.start()
        try:
            yield
        finally:
            self._readers.discard(reader)
            reader.stop()

    def close(self) -> None:
        """Close, as the port says; whoever still follows raises UsageError."""
        for stopping in (self._stop_readers, self._http.close, self._stop_readers):  # one may begin in between
            stopping()

    def _stop_readers(self) -> None:
        # Before their sockets are closed: a thread that reads from a closed one is not woken.
        for reader in list(self._readers):
            reader.stop()


class _Reader(threading.Thread):
    """Reads one stream of events."""

    def __init__(self, http: httpx2.Client, url: str, request: dict[str, Any], tell: Tell) -> None:
        super().__init__(name="voa-events", daemon=True)
        self._http, self._url, self._request, self._tell = http, url, request, tell
        self._stopped = False
        self._socket: socket.socket | None = None

    def run(self) -> None:
        """Until the stream ends, or is stopped."""
        try:
            with self._http.stream(**self._request) as response:
                stream = response.extensions.get("network_stream")
                self._socket = None if stream is None else stream.get_extra_info("socket")
                if self._stopped:
                    return
                if not response.is_success:
                    response.read()
                _check_stream(response)
                for event in httpx2.EventSource(response, _MOST_EVENT_BYTES):
                    self._tell_of(event)
            self._tell(_ended(self._url))
        except httpx2.RequestError as error:
            self._tell(Lost(_error(self._url, error)))
        except VoaClientError as error:
            self._tell(Lost(error))
        except RuntimeError as error:
            if not self._http.is_closed:
                raise
            self._tell(Lost(UsageError(f"the client of {self._url} is closed: {error}")))

    def stop(self) -> None:
        """Wake the thread where it waits for the network; only shutting a socket down does that.

        One that is still connecting is left to find out by itself: nobody should wait for that.
        """
        self._stopped = True
        if self._socket is not None:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self.join(_CONNECT_S)

    def _tell_of(self, event: httpx2.ServerSentEvent) -> None:
        news = _news(event)
        if news is not None:
            self._tell(news)


class AsyncHttpTransport:
    """The same for asyncio."""

    ask_s = None

    def __init__(self, url: str, network: httpx2.AsyncBaseTransport | None = None) -> None:
        self._url = url
        self._http = httpx2.AsyncClient(base_url=checked(url), transport=network)

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Reply:
        """As the port says."""
        try:
            async with asyncio.timeout(seconds):
                return _reply(await self._http.request(timeout=seconds, **_request(call, key)))
        except httpx2.RequestError as error:
            raise _error(self._url, error) from error
        except TimeoutError as error:
            raise TimedOutError(f"no answer from {self._url} within {seconds:.3g} s") from error

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, tell: Tell) -> AsyncIterator[None]:
        """As the port says."""
        reading = asyncio.create_task(self._read(_stream(session_id, seen), tell))
        try:
            yield
        finally:
            reading.cancel()
            with suppress(asyncio.CancelledError):
                await reading

    async def _read(self, request: dict[str, Any], tell: Tell) -> None:
        try:
            async with self._http.stream(**request) as response:
                if not response.is_success:
                    await response.aread()
                _check_stream(response)
                async for event in httpx2.EventSource(response, _MOST_EVENT_BYTES):
                    news = _news(event)
                    if news is not None:
                        tell(news)
            tell(_ended(self._url))
        except httpx2.RequestError as error:
            tell(Lost(_error(self._url, error)))
        except VoaClientError as error:
            tell(Lost(error))
        except RuntimeError as error:
            if not self._http.is_closed:
                raise
            tell(Lost(UsageError(f"the client of {self._url} is closed: {error}")))

    async def close(self) -> None:
        """As the port says."""
        await self._http.aclose()


def checked(url: str) -> str:
    """The URL itself; raises UsageError if it names no host."""
    try:
        host = httpx2.URL(url).host
    except httpx2.InvalidURL as error:
        raise UsageError(f"expected a URL like http://127.0.0.1:8000, got {url!r}: {error}") from error
    if not host:
        raise UsageError(f"expected a URL like http://127.0.0.1:8000, got {url!r}")
    return url


def _request(call: Call[Any], key: str | None) -> dict[str, Any]:
    """A call as the arguments of `request`."""
    headers = {_WIRE: str(WIRE_VERSION)}
    if key is not None:
        headers["Idempotency-Key"] = key
    if call.if_match is not None:
        headers["If-Match"] = f'"v{call.if_match}"'
    asked: dict[str, Any] = {"method": call.method, "url": call.url, "params": call.asked, "headers": headers}
    if call.upload is not None:
        files = {"file": (call.upload.filename, call.upload.content)}
        return asked | {"files": files, "data": call.upload.form()}
    content = call.content()
    return asked if content is None else asked | {"content": content, "headers": headers | _JSON}


def _stream(session_id: str, seen: int | None) -> dict[str, Any]:
    """The request for a session's events, as the arguments of `stream`."""
    headers = {_WIRE: str(WIRE_VERSION), "Accept": "text/event-stream", "Cache-Control": "no-store"}
    last = {} if seen is None else {"Last-Event-ID": str(seen)}
    url = f"{get_session(session_id).url}/events"
    timeout = httpx2.Timeout(_CONNECT_S, read=_SILENCE_S)
    return {"method": "GET", "url": url, "headers": headers | last, "timeout": timeout}


def _reply(response: httpx2.Response) -> Reply:
    told = response.headers
    wire, pause = _number(told, _WIRE), _number(told, "Retry-After")
    if response.is_success:
        return Reply(response.content, wire=wire)
    document = told.get("content-type", "").startswith("application/problem+json")
    body = response.content if document else made_up(response.status_code, str(response.url), response.text)
    return Reply(body, refused=True, wire=wire, retry_after_s=pause)


def _number(headers: Mapping[str, str], name: str) -> int | None:
    value = headers.get(name, "").strip()
    return int(value) if value.isascii() and value.isdigit() and len(value) <= _MOST_DIGITS else None


def _check_stream(response: httpx2.Response) -> None:
    """Raise what a response is, unless it is a stream of events."""
    kind = response.headers.get("content-type", "")
    if not response.is_success:
        check(_reply(response))
    if not kind.startswith("text/event-stream"):
        raise UnexpectedAnswerError(f"expected a stream of events from {response.url}, got {kind!r}")
    check(Reply(b"", wire=_number(response.headers, _WIRE)))


def _news(event: httpx2.ServerSentEvent) -> News | None:
    match event.event:
        case "session":
            return State(event.data.encode())
        case "deleted":
            return Deleted()
        case _:  # of a newer service
            return None


def _ended(url: str) -> Lost:
    return Lost(UnreachableError(f"{url} ended the stream of events"))


def _error(url: str, error: httpx2.RequestError) -> VoaClientError:
    told = f"no answer from {url}: {error or type(error).__name__}"
    if isinstance(error, httpx2.TimeoutException):
        return TimedOutError(told)
    if isinstance(error, httpx2.UnsupportedProtocol | httpx2.LocalProtocolError):
        return UsageError(f"{url}: {error}")
    return UnreachableError(told)
