"""ASGI middleware: request ids, the access log, the version of the messages, and limits on bodies."""

import codecs
import re
import secrets
import time

import structlog
from starlette.exceptions import HTTPException

from voa_connections.asgi import Asgi, Message, Receive, Scope, Send, header, set_header
from voa_msgs import WIRE_VERSION
from voa_service.failures import TooLarge, wire_failure
from voa_service.http.access import HEALTH
from voa_service.http.problems import problem_response
from voa_service.runtime.logs import is_wanted
from voa_service.runtime.metrics import Metrics
from voa_service.settings import Limits

_SANE_ID = re.compile(r"[A-Za-z0-9_.:-]{1,64}")
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
_FORM_OVERHEAD = 65_536
_WIRE_HEADER = b"voa-wire-version"
_VERSION = str(WIRE_VERSION)


class RequestLog:
    """Middleware that gives every request an id, and logs and counts the request when it ends.

    The id is the caller's `X-Request-Id` where that has at most 64 letters, digits and `_.:-`, else a random one.
    """

    def __init__(self, app: Asgi, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        offered = header(scope, b"x-request-id") or ""
        request_id = offered if _SANE_ID.fullmatch(offered) else secrets.token_hex(8)
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(request_id=request_id)
        status = 0
        began = time.perf_counter()

        async def send_with_id(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                set_header(message, b"x-request-id", request_id.encode())
            await send(message)

        try:
            await self._app(scope, receive, send_with_id)
        except Exception:
            if status == 0:
                status = 500
                raise  # there was no response yet: the server sends one
        finally:
            seconds = time.perf_counter() - began
            route = getattr(scope.get("route"), "path", "none")
            method = scope["method"] if scope["method"] in _METHODS else "other"
            self._metrics.request(method, route, status, seconds)
            if scope["path"] not in HEALTH and is_wanted("INFO"):
                structlog.get_logger().info(
                    "request",
                    method=scope["method"],
                    path=scope["path"],
                    status=status,
                    milliseconds=round(1e3 * seconds, 3),
                )


class WireVersion:
    """Middleware that states the version of the messages, and refuses a caller that states another version."""

    def __init__(self, app: Asgi) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_with_version(message: Message) -> None:
            if message["type"] == "http.response.start":
                set_header(message, _WIRE_HEADER, _VERSION.encode())
            await send(message)

        theirs = header(scope, _WIRE_HEADER)
        if theirs not in (None, _VERSION):
            await problem_response(wire_failure(str(theirs)[:40]))(scope, receive, send_with_version)
            return
        await self._app(scope, receive, send_with_version)


class BodyLimit:
    """Middleware that refuses bodies with too many bytes or values, or not in UTF-8, before they are parsed."""

    def __init__(self, app: Asgi, limits: Limits) -> None:
        self._app = app
        self._limits = limits

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        form = (header(scope, b"content-type") or "").startswith("multipart/")
        most = self._limits.upload_bytes + _FORM_OVERHEAD if form else self._limits.body_bytes
        declared = header(scope, b"content-length") or ""
        if declared.isdigit() and int(declared) > most:
            failure = TooLarge(f"expected a body of at most {most} bytes, got {declared}")
            await problem_response(failure)(scope, receive, send)
            return
        size = values = 0
        text = codecs.getincrementaldecoder("utf-8")()

        async def limited() -> Message:
            nonlocal size, values
            message = await receive()
            chunk = message.get("body", b"")
            size += len(chunk)
            values += 0 if form else chunk.count(b",")
            if size > most:
                raise HTTPException(413, f"expected a body of at most {most} bytes")
            if values > self._limits.numbers:
                raise HTTPException(413, f"expected a body of at most {self._limits.numbers} values")
            if not form and message["type"] == "http.request":
                _check_text(text, chunk, last=not message.get("more_body", False))
            return message

        await self._app(scope, limited, send)


def _check_text(text: codecs.IncrementalDecoder, chunk: bytes, *, last: bool) -> None:
    """Refuse a part of a body that is not UTF-8; the parser accepts UTF-16 and lone surrogates, the history cannot."""
    try:
        text.decode(chunk, last)
    except UnicodeDecodeError as error:
        raise HTTPException(400, str(error)) from error
    if b"\0" in chunk:
        raise HTTPException(400, "a NUL byte")
