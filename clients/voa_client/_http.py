"""Transports over HTTP: calls are requests, news are server-sent events."""

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any

import httpx2

from voa_client._api_key import ApiKey
from voa_client._call import Call
from voa_client._calls import get_session
from voa_client._errors import TimedOutError, UnexpectedResponseError, UnreachableError, UsageError, VoaClientError
from voa_client._responses import Response, check, synthetic_problem
from voa_client._transport import Deleted, Lost, News, Receive, State
from voa_msgs import WIRE_VERSION

_WIRE = "Voa-Wire-Version"
_CONNECT_S = 5.0
_SILENCE_S = 20.0  # the service sends a sign of life every 15 s
_MOST_EVENT_BYTES = 64_000_000
_MOST_DIGITS = 18
_UNTRUSTED = "CERTIFICATE_VERIFY_FAILED"
_JSON = {"Content-Type": "application/json"}


class HttpTransport:
    """Transport to a service at a URL.

    Args:
        url: `http://host:port`, with a path if the service is behind a proxy's path.
        network: carries the requests; None: sockets.
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = None

    def __init__(self, url: str, network: httpx2.BaseTransport | None = None, key: ApiKey | None = None) -> None:
        self._url = url
        self._key = ApiKey.given() if key is None else key
        self._http = httpx2.Client(base_url=checked(url), transport=network)
        self._readers: set[_Reader] = set()

    def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Send a call as one request, and return the response; raises UnreachableError or UsageError."""
        try:
            return _response(self._http.request(timeout=seconds, **_request(call, key, self._key)))
        except httpx2.RequestError as error:
            raise _error(self._url, error) from error

    @contextmanager
    def watch(self, session_id: str, seen: int | None, receive: Receive) -> Iterator[None]:
        """Pass a session's events on to `receive`, for the length of a `with`; a thread reads the stream."""
        reader = _Reader(self._http, self._url, _stream(session_id, seen, self._key), receive)
        self._readers.add(reader)
        reader.start()
        try:
            yield
        finally:
            self._readers.discard(reader)
            reader.stop()

    def close(self) -> None:
        """Close all connections; a session that is still followed raises UsageError there."""
        for stopping in (self._stop_readers, self._http.close, self._stop_readers):  # a reader may start in between
            stopping()

    def _stop_readers(self) -> None:
        # Before sockets are closed, because a thread that reads from a closed socket does not wake up.
        for reader in list(self._readers):
            reader.stop()


class _Reader(threading.Thread):
    """Thread that reads a stream of events."""

    def __init__(self, http: httpx2.Client, url: str, request: dict[str, Any], receive: Receive) -> None:
        super().__init__(name="voa-events", daemon=True)
        self._http, self._url, self._request, self._receive = http, url, request, receive
        self._stopped = False
        self._socket: socket.socket | None = None

    def run(self) -> None:
        """Read events until the stream ends or is stopped."""
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
                    self._pass_on(event)
            self._receive(_ended(self._url))
        except httpx2.RequestError as error:
            self._receive(Lost(_error(self._url, error)))
        except VoaClientError as error:
            self._receive(Lost(error))
        except RuntimeError as error:
            if not self._http.is_closed:
                raise
            self._receive(Lost(UsageError(f"the client of {self._url} is closed: {error}")))

    def stop(self) -> None:
        """Wake the thread while it waits for the network, which only the shutdown of its socket does.

        A thread that is still connecting ends by itself, and is not waited for.
        """
        self._stopped = True
        if self._socket is not None:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self.join(_CONNECT_S)

    def _pass_on(self, event: httpx2.ServerSentEvent) -> None:
        news = _news(event)
        if news is not None:
            self._receive(news)


class AsyncHttpTransport:
    """Transport to a service at a URL, for asyncio.

    Args:
        url: `http://host:port`, with a path if the service is behind a proxy's path.
        network: carries the requests; None: sockets.
        key: of the caller; None: that of the environment, if there is one.
    """

    poll_s = None

    def __init__(self, url: str, network: httpx2.AsyncBaseTransport | None = None, key: ApiKey | None = None) -> None:
        self._url = url
        self._key = ApiKey.given() if key is None else key
        self._http = httpx2.AsyncClient(base_url=checked(url), transport=network)

    async def send(self, call: Call[Any], key: str | None, seconds: float) -> Response:
        """Send a call as one request, and return the response; raises UnreachableError or UsageError."""
        try:
            async with asyncio.timeout(seconds):
                return _response(await self._http.request(timeout=seconds, **_request(call, key, self._key)))
        except httpx2.RequestError as error:
            raise _error(self._url, error) from error
        except TimeoutError as error:
            raise TimedOutError(f"no answer from {self._url} within {seconds:.3g} s") from error

    @asynccontextmanager
    async def watch(self, session_id: str, seen: int | None, receive: Receive) -> AsyncIterator[None]:
        """Pass a session's events on to `receive`, for the length of a `with`; a thread reads the stream."""
        reading = asyncio.create_task(self._read(_stream(session_id, seen, self._key), receive))
        try:
            yield
        finally:
            reading.cancel()
            with suppress(asyncio.CancelledError):
                await reading

    async def _read(self, request: dict[str, Any], receive: Receive) -> None:
        try:
            async with self._http.stream(**request) as response:
                if not response.is_success:
                    await response.aread()
                _check_stream(response)
                async for event in httpx2.EventSource(response, _MOST_EVENT_BYTES):
                    news = _news(event)
                    if news is not None:
                        receive(news)
            receive(_ended(self._url))
        except httpx2.RequestError as error:
            receive(Lost(_error(self._url, error)))
        except VoaClientError as error:
            receive(Lost(error))
        except RuntimeError as error:
            if not self._http.is_closed:
                raise
            receive(Lost(UsageError(f"the client of {self._url} is closed: {error}")))

    async def close(self) -> None:
        """Close all connections; a session that is still followed raises UsageError there."""
        await self._http.aclose()


def checked(url: str) -> str:
    """Return the URL; raises UsageError if it names no host."""
    try:
        host = httpx2.URL(url).host
    except httpx2.InvalidURL as error:
        raise UsageError(f"expected a URL like http://127.0.0.1:8000, got {url!r}: {error}") from error
    if not host:
        raise UsageError(f"expected a URL like http://127.0.0.1:8000, got {url!r}")
    return url


def _request(call: Call[Any], key: str | None, own: ApiKey) -> dict[str, Any]:
    """Make the arguments of `request` for a call."""
    headers = {_WIRE: str(WIRE_VERSION)} | own.headers()
    if key is not None:
        headers["Idempotency-Key"] = key
    if call.if_match is not None:
        headers["If-Match"] = f'"v{call.if_match}"'
    arguments: dict[str, Any] = {"method": call.method, "url": call.url, "params": call.parameters, "headers": headers}
    if call.upload is not None:
        files = {"file": (call.upload.filename, call.upload.content)}
        return arguments | {"files": files, "data": call.upload.form()}
    content = call.content()
    return arguments if content is None else arguments | {"content": content, "headers": headers | _JSON}


def _stream(session_id: str, seen: int | None, own: ApiKey) -> dict[str, Any]:
    """Make the arguments of `stream` for a session's events."""
    headers = {_WIRE: str(WIRE_VERSION), "Accept": "text/event-stream", "Cache-Control": "no-store"} | own.headers()
    last = {} if seen is None else {"Last-Event-ID": str(seen)}
    url = f"{get_session(session_id).url}/events"
    timeout = httpx2.Timeout(_CONNECT_S, read=_SILENCE_S)
    return {"method": "GET", "url": url, "headers": headers | last, "timeout": timeout}


def _response(response: httpx2.Response) -> Response:
    headers = response.headers
    wire, pause = _number(headers, _WIRE), _number(headers, "Retry-After")
    if response.is_success:
        return Response(response.content, wire=wire)
    document = headers.get("content-type", "").startswith("application/problem+json")
    body = response.content if document else synthetic_problem(response.status_code, str(response.url), response.text)
    return Response(body, refused=True, wire=wire, retry_after_s=pause)


def _number(headers: Mapping[str, str], name: str) -> int | None:
    value = headers.get(name, "").strip()
    return int(value) if value.isascii() and value.isdigit() and len(value) <= _MOST_DIGITS else None


def _check_stream(response: httpx2.Response) -> None:
    """Raise an error unless a response is a stream of events."""
    kind = response.headers.get("content-type", "")
    if not response.is_success:
        check(_response(response))
    if not kind.startswith("text/event-stream"):
        raise UnexpectedResponseError(f"expected a stream of events from {response.url}, got {kind!r}")
    check(Response(b"", wire=_number(response.headers, _WIRE)))


def _news(event: httpx2.ServerSentEvent) -> News | None:
    match event.event:
        case "session":
            return State(event.data.encode())
        case "deleted":
            return Deleted()
        case _:  # an event that only newer services send
            return None


def _ended(url: str) -> Lost:
    return Lost(UnreachableError(f"{url} ended the stream of events"))


def _error(url: str, error: httpx2.RequestError) -> VoaClientError:
    text = f"no answer from {url}: {error or type(error).__name__}"
    if isinstance(error, httpx2.TimeoutException):
        return TimedOutError(text)
    if isinstance(error, httpx2.UnsupportedProtocol | httpx2.LocalProtocolError):
        return UsageError(f"{url}: {error}")
    if _UNTRUSTED in text:
        return UnreachableError(f"{text}; for a private authority, name the file of its certificate in SSL_CERT_FILE")
    return UnreachableError(text)
