"""Why a connection is refused or ended, and the answer that it gets."""

import secrets
from dataclasses import dataclass
from http import HTTPStatus

import structlog

from voa_msgs import WIRE_VERSION
from voa_service.failures import (
    Failure,
    HeadersTooLarge,
    MalformedRequest,
    NotReady,
    Overloaded,
    RequestTimeout,
    document,
)

MEDIA_TYPE = "application/problem+json"

_RETRY = {"Retry-After": "5"}


@dataclass(frozen=True)
class Refusal:
    """One reason to refuse requests or to end connections.

    Attributes:
        reason: the label of its metric.
        detail: of the problem document, and what the log says when it begins.
        kind: of failure; None: nothing is answered, as nothing was asked or an answer has begun.
        headers: of the answer.
    """

    reason: str
    detail: str
    kind: type[Failure] | None = None
    headers: tuple[tuple[str, str], ...] = ()

    def failure(self) -> Failure:
        """Make the failure that the caller is answered.

        Raises:
            ValueError: there is no answer.
        """
        if self.kind is None:
            raise ValueError(f"{self.reason}: expected a refusal with an answer")
        return self.kind(self.detail, dict(self.headers))


def headers_too_large(most_bytes: int, most: int) -> Refusal:
    """Refuse more bytes before a body, or more headers, than a request may have."""
    detail = f"expected a request line and headers of at most {most_bytes} bytes, and at most {most} headers"
    return Refusal("headers-too-large", detail, HeadersTooLarge)


def header_timeout(seconds: float) -> Refusal:
    """Refuse headers that do not end."""
    return Refusal("header-timeout", f"expected all headers within {seconds:g} s of the first byte", RequestTimeout)


def body_timeout(least: int, seconds: float) -> Refusal:
    """Refuse a body that does not come on."""
    detail = f"expected the rest of the body, or {least} bytes more of it, within {seconds:g} s"
    return Refusal("body-timeout", detail, RequestTimeout)


def too_many_connections(most: int) -> Refusal:
    """Refuse another connection than for a health probe."""
    detail = f"all {most} connections are at work: try again in some seconds, over one connection that is kept open"
    return Refusal("too-many-connections", detail, Overloaded, tuple(_RETRY.items()))


def bytes_in_flight(most: int) -> Refusal:
    """Refuse more of a large body while other bodies take the memory that there is for them."""
    detail = f"large bodies under way have {most} bytes together, all that are taken at once: try again in some seconds"
    return Refusal("bytes-in-flight", detail, Overloaded, tuple(_RETRY.items()))


MALFORMED = Refusal("malformed-request", "expected an HTTP request, as in RFC 9112", MalformedRequest)
PIPELINED = Refusal("pipelined", "a connection sent many requests without waiting for answers: it was closed")
EVICTED = Refusal("idle-closed", "there are as many connections as there may be: the one idle the longest was closed")
SILENT = Refusal("silent", "a connection was opened and nothing sent: it was closed")
STALLED = Refusal("reader-stalled", "an answer was not read on: its connection was ended")
UNREAD = Refusal("answers-unread", "answers that wait for slow readers take too much memory: the oldest was ended")
STOPPING = Refusal("stopping", "the service is stopping: try again", NotReady, tuple(_RETRY.items()))


def response(refusal: Refusal) -> bytes:
    """Write the whole HTTP/1.1 response of a refusal that has an answer; the connection ends after it."""
    request_id = secrets.token_hex(8)
    failure = refusal.failure()
    with structlog.contextvars.bound_contextvars(request_id=request_id):
        body = document(failure)
    headers = {
        "Content-Type": MEDIA_TYPE,
        "Content-Length": str(len(body)),
        "Connection": "close",
        "X-Request-Id": request_id,
        "Voa-Wire-Version": str(WIRE_VERSION),
    } | failure.headers
    lines = [f"HTTP/1.1 {failure.status} {HTTPStatus(failure.status).phrase}"]
    lines += [f"{name}: {value}" for name, value in headers.items()]
    return "\r\n".join([*lines, "", ""]).encode() + body
