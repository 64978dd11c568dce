"""Headers of ASGI messages: read by name, and set in place of earlier ones."""

from typing import Any

from voa_connections.asgi import header, set_header


def test_the_first_header_of_a_name_is_returned() -> None:
    scope = {"headers": [(b"host", b"a"), (b"if-match", b'"v1"'), (b"if-match", b'"v2"'), (b"x", b"\xe9")]}
    assert header(scope, b"if-match") == '"v1"'
    assert header(scope, b"x") == "é"
    assert header(scope, b"accept") is None


def test_a_header_replaces_those_of_its_name() -> None:
    message: dict[str, Any] = {"headers": [(b"etag", b'"v1"'), (b"x-request-id", b"a"), (b"x-request-id", b"b")]}
    set_header(message, b"x-request-id", b"c")
    assert message["headers"] == [(b"etag", b'"v1"'), (b"x-request-id", b"c")]


def test_a_response_without_headers_gets_its_first() -> None:
    message: dict[str, Any] = {"type": "http.response.start"}
    set_header(message, b"x-request-id", b"c")
    assert message["headers"] == [(b"x-request-id", b"c")]
