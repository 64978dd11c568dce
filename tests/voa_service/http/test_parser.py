"""What is no HTTP gets a problem document too, and a service that was handed a socket knows where it listens."""

import json
import socket
from urllib.parse import urlsplit

import pytest

from voa_service.serve import listening_at
from voa_service.settings import Settings


@pytest.mark.parametrize("junk", [b"\x16\x03\x01\x00\xa5\x01\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"nonsense\r\n\r\n"])
def test_what_is_no_http_gets_a_problem(process: str, junk: bytes) -> None:
    parts = urlsplit(process)
    with socket.create_connection((str(parts.hostname), int(parts.port or 0)), 30) as connection:
        connection.sendall(junk)
        answer = b""
        while chunk := connection.recv(65_536):
            answer += chunk
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 400 ")
    assert b"content-type: application/problem+json" in head
    assert json.loads(body)["type"] == "urn:voa:problem:malformed-request"


def test_a_socket_that_is_handed_over_says_whether_others_reach_it() -> None:
    for host, loopback in (("127.0.0.1", True), ("0.0.0.0", False)):  # noqa: S104 - not listened on
        with socket.create_server((host, 0)) as listening:
            assert listening_at(Settings(), listening).is_loopback is loopback
    with socket.socket(socket.AF_UNIX) as listening:
        assert listening_at(Settings(), listening) == Settings()
