"""Reasons for which connections and requests are refused or ended."""

from dataclasses import dataclass
from typing import Literal

Answer = Literal["malformed-request", "request-timeout", "headers-too-large", "overloaded", "not-ready"]
"""Kinds of responses to refused requests: status 400, 408, 431, 503 and 503."""

_RETRY = {"Retry-After": "5"}


@dataclass(frozen=True)
class Refusal:
    """A reason to refuse requests or to end connections.

    Attributes:
        reason: label of its metric.
        detail: of the response and of the log.
        answer: kind of response; None: nothing can be sent, as there was no request yet or its response has begun.
        headers: of the response.
    """

    reason: str
    detail: str
    answer: Answer | None = None
    headers: tuple[tuple[str, str], ...] = ()


def headers_too_large(most_bytes: int, most: int) -> Refusal:
    """Refuse a request whose headers have more bytes, or are more in number, than allowed."""
    detail = f"expected a request line and headers of at most {most_bytes} bytes, and at most {most} headers"
    return Refusal("headers-too-large", detail, "headers-too-large")


def header_timeout(seconds: float) -> Refusal:
    """Refuse a request whose headers take too long to arrive."""
    return Refusal("header-timeout", f"expected all headers within {seconds:g} s of the first byte", "request-timeout")


def body_timeout(least: int, seconds: float) -> Refusal:
    """Refuse a request whose body arrives too slowly."""
    detail = f"expected the rest of the body, or {least} bytes more of it, within {seconds:g} s"
    return Refusal("body-timeout", detail, "request-timeout")


def too_many_connections(most: int) -> Refusal:
    """Refuse a request on a connection beyond the limit, unless it is a health probe."""
    detail = f"all {most} connections are in use: try again in some seconds, over one connection that is kept open"
    return Refusal("too-many-connections", detail, "overloaded", tuple(_RETRY.items()))


def bytes_in_flight(most: int) -> Refusal:
    """Refuse a large body while other large bodies use all the memory for them."""
    detail = f"the large bodies under way may have {most} bytes together, and have them: try again in some seconds"
    return Refusal("bytes-in-flight", detail, "overloaded", tuple(_RETRY.items()))


MALFORMED = Refusal("malformed-request", "expected an HTTP request, as in RFC 9112", "malformed-request")
PIPELINED = Refusal("pipelined", "a connection sent many requests without waiting for responses: it was closed")
EVICTED = Refusal(
    "idle-closed", "there are as many connections as allowed: the one that was idle the longest was closed"
)
SILENT = Refusal("silent", "a connection was opened and no request sent: it was closed")
HANDSHAKE = Refusal("tls-handshake", "a connection was opened and its TLS handshake not finished: it was closed")
STALLED = Refusal("reader-stalled", "a peer stopped reading its response: its connection was ended")
UNREAD = Refusal("answers-unread", "responses that wait for slow readers take too much memory: the oldest was ended")
STOPPING = Refusal("stopping", "the service is stopping: try again", "not-ready", tuple(_RETRY.items()))
