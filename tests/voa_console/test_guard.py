"""Requests and WebSockets from pages of other sites are refused."""

import asyncio
from collections.abc import MutableMapping
from typing import Any

import pytest

from voa_console.guard import SameOrigin, is_same_origin

HOST = (b"host", b"127.0.0.1:8080")


@pytest.mark.parametrize(
    ("headers", "same"),
    [
        ([HOST], True),
        ([HOST, (b"origin", b"http://127.0.0.1:8080")], True),
        ([HOST, (b"origin", b"http://127.0.0.1:8000")], False),
        ([HOST, (b"origin", b"http://evil.example")], False),
        ([HOST, (b"origin", b"null")], False),
        ([(b"host", b"LAB:8080"), (b"origin", b"http://lab:8080")], True),
    ],
)
def test_an_origin_must_be_the_host(headers: list[tuple[bytes, bytes]], same: bool) -> None:
    assert is_same_origin(dict(headers)) is same


def exchanged(kind: str, headers: list[tuple[bytes, bytes]]) -> list[MutableMapping[str, Any]]:
    """Messages that a client receives from an application behind the guard, which answers "served"."""
    sent: list[MutableMapping[str, Any]] = []

    async def receive() -> MutableMapping[str, Any]:
        return {"type": f"{kind}.connect"}

    async def send(message: MutableMapping[str, Any]) -> None:
        sent.append(message)

    async def served(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "served"})

    asyncio.run(SameOrigin(served)({"type": kind, "headers": headers}, receive, send))
    return sent


def test_a_page_of_another_site_gets_403_and_no_connection() -> None:
    foreign = [HOST, (b"origin", b"http://evil.example")]
    assert exchanged("http", foreign)[0]["status"] == 403
    assert exchanged("websocket", foreign)[0]["type"] == "websocket.close"
    assert [message["type"] for message in exchanged("websocket", [HOST])] == ["served"]
