"""Responses of refused requests, as the server's application wants them to look."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus

from voa_connections.refusals import Refusal


@dataclass(frozen=True)
class RefusalResponse:
    """A whole response: HTTP status, headers and body."""

    status: int
    headers: Mapping[str, str]
    body: bytes


Respond = Callable[[Refusal], RefusalResponse]
"""A function that makes the response of a refusal whose `answer` is not None."""


def http_bytes(response: RefusalResponse) -> bytes:
    """Write a response in HTTP/1.1; the connection ends after it."""
    headers = {**response.headers, "Content-Length": str(len(response.body)), "Connection": "close"}
    lines = [f"HTTP/1.1 {response.status} {HTTPStatus(response.status).phrase}"]
    lines += [f"{name}: {value}" for name, value in headers.items()]
    return "\r\n".join([*lines, "", ""]).encode() + response.body
