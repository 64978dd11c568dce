"""The supervisor keeps connections below the file limit, answers health probes always, and logs what begins once."""

import pytest
from structlog.testing import capture_logs

from tests.voa_connections.wires import Host, run, settled
from voa_connections.settings import ConnectionSettings
from voa_connections.supervisor import SPARE, most_connections

GET = b"GET /livez HTTP/1.1\r\nHost: here\r\n\r\n"
HELD = GET.replace(b"/livez", b"/held")


@pytest.mark.parametrize(("files", "most"), [(1_024, 768), (300, 150), (100_000, 1_000)])
def test_the_most_connections_follow_from_the_files(files: int, most: int) -> None:
    assert most_connections(ConnectionSettings(), files) == most


def test_the_connection_idle_the_longest_makes_place() -> None:
    async def scenario() -> None:
        host = Host(most=3)
        (first, one), (_, two), (_, three) = (host.connect() for _ in range(3))
        first.data_received(GET)
        await settled()
        assert one.statuses == [200]
        _, four = host.connect()
        assert [wire.ended for wire in (one, two, three, four)] == [False, True, False, False]
        assert host.refused("idle-closed") == 1

    run(scenario)


def test_a_request_under_way_makes_no_place_but_probes_are_answered() -> None:
    async def scenario() -> None:
        host = Host(most=2)
        held = [host.connect() for _ in range(2)]
        for connection, _ in held:
            connection.data_received(HELD)
        probe, probed = host.connect()
        probe.data_received(GET)
        other, refused = host.connect()
        other.data_received(GET.replace(b"/livez", b"/v1/lidars"))
        await settled()
        assert probed.statuses == [200]
        assert probed.ended
        assert refused.statuses == [503]
        assert refused.problem["retry_after_s"] == 5
        assert host.refused("too-many-connections") == 1
        assert not any(wire.ended for _, wire in held)
        host.application.go.set()
        await settled()
        assert [wire.statuses for _, wire in held] == [[200], [200]]

    run(scenario)


def test_connections_above_the_most_are_bounded_too() -> None:
    async def scenario() -> None:
        host = Host(most=1)
        connection, _ = host.connect()
        connection.data_received(HELD)
        wires = [host.connect()[1] for _ in range(SPARE + 5)]
        assert sum(not wire.ended for wire in wires) == SPARE
        assert all(wire.ended for wire in wires[:5])

    run(scenario)


def test_a_connection_that_is_gone_makes_place() -> None:
    async def scenario() -> None:
        host = Host(most=1)
        first, _ = host.connect()
        first.data_received(HELD)
        first.connection_lost(None)
        second, wire = host.connect()
        second.data_received(GET.replace(b"/livez", b"/v1/lidars"))
        await settled()
        assert wire.statuses == [200]

    run(scenario)


def test_of_too_many_answers_that_are_not_read_the_oldest_ends() -> None:
    async def scenario() -> None:
        host = Host(in_flight_mebibytes=1)
        opened = [host.connect() for _ in range(3)]
        for connection, wire in opened:
            connection.data_received(HELD)
            wire.unsent = 500_000
        for number, (connection, _) in enumerate(opened):
            connection.sent_at += number
        host.supervisor.check(opened[0][0].loop)
        assert [wire.aborted for _, wire in opened] == [True, False, False]
        assert host.refused("answers-unread") == 1

    run(scenario)


def test_what_begins_is_logged_once() -> None:
    async def scenario() -> None:
        host = Host(headers=1)
        for _ in range(5):
            connection, _ = host.connect()
            connection.data_received(b"GET / HTTP/1.1\r\n" + b"x:\r\n" * 5)
        assert host.refused("headers-too-large") == 5

    with capture_logs() as lines:
        run(scenario)
    assert [(line["log_level"], line["reason"]) for line in lines] == [("warning", "headers-too-large")]


def test_waiting_connections_are_answered_when_the_service_stops() -> None:
    async def scenario() -> None:
        host = Host()
        (working, one), (_, idle), (unfinished, three) = (host.connect() for _ in range(3))
        working.data_received(HELD)
        unfinished.data_received(GET[:10])
        await settled()
        host.supervisor.end()
        assert one.statuses == [503]
        assert one.problem["type"] == "urn:voa:problem:not-ready"
        assert (idle.written, idle.ended) == (b"", True)
        assert three.statuses == [503]

    run(scenario)
