"""Streams of events that something in between has spoilt: no follower ends by them, or hands them out."""

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from tests.voa_client.blocking import blocking
from tests.voa_client.stepping import body
from tests.voa_client.test_attempts import problem
from voa_client import Client

Connect = Callable[..., AbstractContextManager[Client]]
STREAM = "text/event-stream"


def event(data: bytes, name: bytes = b"session") -> bytes:
    return b"event: " + name + b"\ndata: " + data + b"\n\n"


class Proxy:
    """A service whose streams of events are given beforehand, one for each watch; then true ones.

    Attributes:
        streams: headers and bytes of the streams to come.
        version: of the session; None: it is gone.
    """

    def __init__(self, *streams: tuple[dict[str, str], bytes]) -> None:
        self.streams = list(streams)
        self.version: int | None = 1

    def answer(self, handler: BaseHTTPRequestHandler) -> None:
        state = None if self.version is None else body(self.version)
        if handler.path.endswith("/events") and self.streams:
            headers, content = self.streams.pop(0)
        elif handler.path.endswith("/events"):
            last = int(handler.headers["Last-Event-ID"] or 0)
            between = [event(body(version)) for version in range(last + 1, (self.version or 0) + 1)]
            headers, content = {"Content-Type": STREAM}, b"".join(between)
            if self.version is None:
                content = event(b"{}", b"deleted")
        else:
            headers, content = {"Content-Type": "application/json"}, state or problem("not-found", 404).body
        gone = state is None and not handler.path.endswith("/events")
        handler.send_response(404 if gone else 200)
        if gone:
            headers = {"Content-Type": "application/problem+json"}
        for name, value in headers.items():
            handler.send_header(name, value)
        handler.end_headers()
        handler.wfile.write(content)


@contextmanager
def serving(proxy: Proxy) -> Iterator[str]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            proxy.answer(self)

        def log_request(self, code: object = "-", size: object = "-") -> None:
            return

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join()


FIRST = event(body(1))
SPOILT: dict[str, tuple[dict[str, str], bytes]] = {
    "no JSON": ({"Content-Type": STREAM}, FIRST + event(b"<html>")),
    "no text": ({"Content-Type": STREAM}, FIRST + event(b"\xff\xfe\x00")),
    "nested": ({"Content-Type": STREAM}, FIRST + event(b"[" * 100_000)),
    "far ahead": ({"Content-Type": STREAM}, FIRST + event(body(10**12))),
    "another session": ({"Content-Type": STREAM}, FIRST + event(body(2, id="other"))),
    "delete": ({"Content-Type": STREAM}, FIRST + event(b"{}", b"deleted")),
    "cut off": ({"Content-Type": STREAM}, FIRST + b"event: session\ndata: {"),
    "a page": ({"Content-Type": "text/html"}, b"<html>"),
    "no chunks": ({"Content-Type": STREAM, "Transfer-Encoding": "chunked"}, b"no chunk\r\n\0"),
    "no gzip": ({"Content-Type": STREAM, "Content-Encoding": "gzip"}, b"\0" * 100),
    "no charset": ({"Content-Type": f"{STREAM}; charset=nonsense"}, FIRST + event(b"\xff")),
    "no version": ({"Content-Type": STREAM, "Voa-Wire-Version": "9" * 5_000}, FIRST + event(b"\0")),
}


@pytest.mark.parametrize("connect", [Client, blocking])
@pytest.mark.parametrize("what", SPOILT)
def test_a_spoilt_stream_is_restarted(connect: Connect, what: str) -> None:
    proxy = Proxy(({"Content-Type": STREAM}, FIRST), SPOILT[what])
    seen: list[int | None] = []
    with serving(proxy) as url, connect(url) as client, closing(client.follow("s")) as sessions:
        for session in sessions:
            seen.append(session.version)
            if session.version == 1:
                proxy.version = 2
            elif session.version == 2:
                proxy.version = None
    assert proxy.streams == []
    assert seen == [1, 2]
