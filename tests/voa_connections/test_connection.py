"""A connection answers requests, and refuses what is none, too large or too slow, each with its problem document."""

import pytest

from tests.voa_connections.wires import Host, run, settled
from voa_connections.connection import Stage

GET = b"GET /livez HTTP/1.1\r\nHost: here\r\n\r\n"


def post(length: int, path: str = "/v1/scenarios") -> bytes:
    return f"POST {path} HTTP/1.1\r\nHost: here\r\nContent-Length: {length}\r\n\r\n".encode()


def test_requests_of_one_connection_are_answered_one_after_the_other() -> None:
    async def scenario() -> None:
        connection, wire = Host().connect()
        for piece in (GET, post(3), b"ab", b"c", GET + post(0), GET[:20], GET[20:]):
            connection.data_received(piece)
            await settled()
        assert wire.statuses == [200] * 5
        assert connection.stage is Stage.SILENT
        assert not wire.ended

    run(scenario)


@pytest.mark.parametrize(
    "lines",
    [
        [b"x: " + b"a" * 600 + b"\r\n"] * 3,  # too many bytes, in whole headers
        [b"x: "] + [b"a" * 600] * 4,  # in one header that does not end
        [b"x: " + b"a" * 3_000 + b"\r\n\r\n"],  # in one piece, complete
        [b"x:\r\n" * 12],  # too many headers
        [b"x:\r\n" * 12 + b"\r\n"],
    ],
)
def test_headers_that_are_too_large_are_431(lines: list[bytes]) -> None:
    async def scenario() -> None:
        host = Host(header_bytes=1_000, headers=10)
        connection, wire = host.connect()
        connection.data_received(b"GET /livez HTTP/1.1\r\n")
        for line in lines:
            connection.data_received(line)
        await settled()
        assert wire.statuses == [431]
        assert wire.problem["type"] == "urn:voa:problem:headers-too-large"
        assert "at most 1000 bytes, and at most 10 headers" in wire.problem["detail"]
        assert wire.problem["request_id"]
        assert wire.half_closed
        assert host.application.paths == []
        assert host.refused("headers-too-large") == 1

    run(scenario)


def test_headers_of_the_largest_size_are_taken() -> None:
    async def scenario() -> None:
        connection, wire = Host(header_bytes=1_000, headers=10).connect()
        filler = b"x: " + b"a" * (1_000 - len(b"/livez") - len(b"x"))
        connection.data_received(b"GET /livez HTTP/1.1\r\n" + filler + b"\r\n\r\n")
        await settled()
        assert wire.statuses == [200]

    run(scenario)


def test_trailers_without_end_are_refused() -> None:
    async def scenario() -> None:
        connection, wire = Host(header_bytes=1_000).connect()
        connection.data_received(b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n0\r\nx: ")
        for _ in range(4):
            connection.data_received(b"a" * 500)
        assert wire.statuses == [431]

    run(scenario)


def test_a_body_in_the_smallest_chunks_is_taken() -> None:
    async def scenario() -> None:
        connection, wire = Host(header_bytes=200).connect()
        connection.data_received(b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n")
        for _ in range(300):
            connection.data_received(b"1\r\na\r\n")
        connection.data_received(b"0\r\n\r\n")
        await settled()
        assert wire.statuses == [200]

    run(scenario)


@pytest.mark.parametrize("bytes_", [b"\x16\x03\x01\x02\x00\x01\x00", b"GET\r\n\r\n", b"GET / SMTP/1.1\r\n\r\n"])
def test_what_is_no_request_is_400(bytes_: bytes) -> None:
    async def scenario() -> None:
        host = Host()
        connection, wire = host.connect()
        connection.data_received(bytes_)
        connection.data_received(GET)
        await settled()
        assert wire.statuses == [400]
        assert wire.problem["type"] == "urn:voa:problem:malformed-request"
        assert host.refused("malformed-request") == 1

    run(scenario)


def test_a_request_for_another_protocol_is_answered_and_what_follows_is_not_read() -> None:
    async def scenario() -> None:
        host = Host()
        connection, wire = host.connect()
        connection.data_received(GET[:-2] + b"Connection: Upgrade\r\nUpgrade: websocket\r\n\r\n")
        connection.data_received(b"\x81\x05hello")
        await settled()
        assert wire.statuses == [200]
        assert wire.ended

    run(scenario)


def test_many_requests_at_once_end_their_connection() -> None:
    async def scenario() -> None:
        host = Host()
        connection, wire = host.connect()
        connection.data_received(GET.replace(b"/livez", b"/held") + GET * 16)
        assert not wire.ended
        connection.data_received(GET)
        assert wire.aborted
        assert host.refused("pipelined") == 1

    run(scenario)


def test_headers_that_do_not_end_in_time_are_408() -> None:
    async def scenario() -> None:
        host = Host(header_seconds=10)
        connection, wire = host.connect()
        connection.data_received(GET[:10])
        began = connection.since
        connection.data_received(GET[10:20])  # no byte buys more time
        assert connection.overdue(began + 9.9) is None
        late = connection.overdue(began + 10.1)
        assert late is not None
        connection.refuse(late)
        assert wire.statuses == [408]
        assert wire.problem["type"] == "urn:voa:problem:request-timeout"
        assert host.refused("header-timeout") == 1

    run(scenario)


def test_a_body_must_come_on() -> None:
    async def scenario() -> None:
        host = Host(progress_seconds=20, progress_bytes=100)
        connection, wire = host.connect()
        connection.data_received(post(1_000))
        began = connection.since
        connection.data_received(b"a" * 100)
        assert connection.overdue(began + 20.1) is None
        connection.data_received(b"a" * 99)
        assert connection.overdue(began + 40.0) is None
        late = connection.overdue(began + 40.3)
        assert late is not None
        await settled()
        connection.refuse(late)
        assert wire.statuses == [408]
        assert "100 bytes more" in wire.problem["detail"]
        await settled()
        assert host.application.ended == ["/v1/scenarios"]

    run(scenario)


def test_a_body_that_the_application_does_not_read_is_not_late() -> None:
    async def scenario() -> None:
        host = Host(progress_seconds=20)
        connection, wire = host.connect()
        connection.data_received(post(1_000_000, "/held") + b"a")
        await settled()
        connection.data_received(b"a" * 100_000)
        assert not wire.is_read()
        began = connection.since
        assert connection.overdue(began + 20.1) is None
        assert connection.overdue(began + 40.2) is None
        host.application.go.set()
        await settled()
        assert wire.is_read()
        assert connection.overdue(began + 60.3) is None  # it may have been resumed a moment ago
        assert connection.overdue(began + 80.4) is not None

    run(scenario)


def test_work_and_streams_may_last() -> None:
    async def scenario() -> None:
        connection, wire = Host().connect()
        connection.data_received(GET.replace(b"/livez", b"/held"))
        await settled()
        assert connection.stage is Stage.WORKING
        assert connection.overdue(connection.since + 1e6) is None
        assert not wire.ended

    run(scenario)


def test_an_answer_must_be_read_on() -> None:
    async def scenario() -> None:
        connection, wire = Host(progress_seconds=20, progress_bytes=100).connect()
        connection.data_received(GET.replace(b"/livez", b"/held"))
        now = connection.since
        wire.unsent = 1_000
        assert connection.overdue(now) is None
        assert connection.overdue(now + 19) is None
        wire.unsent = 900
        assert connection.overdue(now + 19.5) is None
        wire.unsent = 850
        assert connection.overdue(now + 39) is None
        late = connection.overdue(now + 40)
        assert late is not None
        assert late.reason == "reader-stalled"
        connection.refuse(late)
        assert wire.aborted

    run(scenario)


def test_a_refusal_is_read_by_a_peer_that_still_sends_and_then_the_connection_ends() -> None:
    async def scenario() -> None:
        connection, wire = Host(headers=1).connect()
        connection.data_received(b"GET / HTTP/1.1\r\n" + b"x:\r\n" * 5)
        connection.data_received(b"x:\r\n" * 5_000)
        assert wire.statuses == [431]
        assert not wire.ended
        late = connection.overdue(connection.since + 2.1)
        assert late is not None
        connection.refuse(late)
        assert wire.statuses == [431]
        assert wire.aborted

    run(scenario)


def test_nothing_is_written_into_an_answer_that_has_begun() -> None:
    async def scenario() -> None:
        connection, wire = Host().connect()
        connection.data_received(GET.replace(b"/livez", b"/held") + GET[:10])
        await settled()
        late = connection.overdue(connection.since + 11)
        assert late is not None
        connection.refuse(late)
        assert wire.written == b""
        assert wire.aborted

    run(scenario)
