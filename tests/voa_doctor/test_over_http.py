"""Answers of a service about itself by HTTP, and the findings they make."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import pytest

from tests.voa_doctor.examinations import examined
from voa_msgs import WIRE_VERSION


@contextmanager
def answering(path: str, status: int, body: bytes) -> Iterator[str]:
    """An HTTP server that lives, and has one more answer."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            content = (status, body) if self.path == path else (200, b'{"status": "alive"}')
            self.send_response(content[0])
            self.send_header("Content-Length", str(len(content[1])))
            self.end_headers()
            self.wfile.write(content[1])

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the base class's name
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


def health(**changes: Any) -> bytes:
    now = datetime.now(UTC) + timedelta(seconds=changes.pop("ahead", 0.0))
    content = {"status": "ready", "wire_version": WIRE_VERSION, "zenoh": "off", "now": now.isoformat()}
    return json.dumps(content | changes).encode()


@pytest.mark.parametrize(
    ("path", "status", "body", "check", "state", "says"),
    [
        ("/livez", 502, b"no upstream", "service", "wrong", "/livez answers 502"),
        ("/livez", 200, b"<html>", "service", "wrong", "not the service's"),
        (
            "/v1/caller",
            401,
            b'{"type": "urn:voa:problem:unauthenticated", "title": "t", "status": 401, "detail": "needs a key"}',
            "key",
            "wrong",
            "needs a key",
        ),
        (
            "/v1/caller",
            200,
            b'{"name": "anna", "role": "arm", "key": "1", "sessions": null, "robots": null, "expires_at": null,'
            b' "calls": []}',
            "key",
            "ok",
            "anna, arm",
        ),
        ("/readyz", 503, b"{}", "ready", "wrong", "/readyz answers 503"),
        (
            "/readyz",
            503,
            b'{"type": "urn:voa:problem:not-ready", "title": "t", "status": 503, "detail": "no store"}',
            "ready",
            "wrong",
            "no store",
        ),
        (
            "/readyz",
            200,
            {"wire_version": WIRE_VERSION + 1},
            "messages",
            "wrong",
            f"version {WIRE_VERSION + 1} of the service",
        ),
        ("/readyz", 200, {"version": "0.0.1"}, "software", "warning", "0.0.1 of the service"),
        ("/readyz", 200, {"ahead": 3600.0}, "clock", "warning", "ahead of ours"),
        ("/readyz", 200, {"ahead": -3600.0}, "clock", "warning", "behind ours"),
    ],
)
def test_what_the_service_says_of_itself(
    capsys: pytest.CaptureFixture[str],
    path: str,
    status: int,
    body: bytes | dict[str, Any],
    check: str,
    state: str,
    says: str,
) -> None:
    with answering(path, status, body if isinstance(body, bytes) else health(**body)) as url:
        _, result = examined(capsys, "--url", url)
    assert result[check]["state"] == state
    assert says in result[check]["seen"]
