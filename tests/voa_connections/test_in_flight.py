"""Large bodies under way are bounded together; small ones are always taken."""

import pytest

from tests.voa_connections.wires import Host, run, settled
from voa_connections.in_flight import FREE_BYTES, ByteBudget

MEBIBYTE = 2**20


def post(length: int) -> bytes:
    return f"POST /v1/scenarios HTTP/1.1\r\nHost: here\r\nContent-Length: {length}\r\n\r\n".encode()


def test_a_budget_gives_what_it_has() -> None:
    refused: list[str] = []
    budget = ByteBudget(10, lambda refusal: refused.append(refusal.reason))
    assert budget.take(7)
    assert not budget.take(4)
    assert refused == ["bytes-in-flight"]
    budget.give(7)
    assert budget.take(10)
    assert budget.held == 10


def test_a_body_without_room_is_503_and_gives_back_what_it_held() -> None:
    async def scenario() -> None:
        host = Host(in_flight_mebibytes=1)
        first, one = host.connect()
        second, two = host.connect()
        first.data_received(post(MEBIBYTE))
        second.data_received(post(MEBIBYTE))
        for _ in range(6):
            for connection in (first, second):
                connection.data_received(b"a" * 100_000)
                await settled()
        assert one.statuses == []
        assert two.statuses == [503]
        assert two.problem["type"] == "urn:voa:problem:overloaded"
        assert two.problem["retry_after_s"] == 5
        assert host.supervisor.budget.held == 600_000 - FREE_BYTES
        first.data_received(b"a" * (MEBIBYTE - 600_000))
        await settled()
        assert one.statuses == [200]
        assert host.supervisor.budget.held == 0
        assert host.refused("bytes-in-flight") == 1
        # The rest of the refused body is thrown away, and its connection goes on.
        second.data_received(b"a" * (MEBIBYTE - 600_000) + post(1) + b"a")
        await settled()
        assert two.statuses == [503, 200]

    run(scenario)


def test_a_small_body_needs_no_room() -> None:
    async def scenario() -> None:
        host = Host(in_flight_mebibytes=1)
        assert host.supervisor.budget.take(MEBIBYTE)
        connection, wire = host.connect()
        connection.data_received(post(FREE_BYTES) + b"a" * FREE_BYTES)
        await settled()
        assert wire.statuses == [200]

    run(scenario)


def test_a_caller_that_leaves_gives_back_what_it_held() -> None:
    async def scenario() -> None:
        host = Host(in_flight_mebibytes=1)
        connection, _ = host.connect()
        connection.data_received(post(MEBIBYTE))
        connection.data_received(b"a" * 200_000)
        await settled()
        assert host.supervisor.budget.held == 200_000 - FREE_BYTES
        connection.connection_lost(ConnectionResetError())
        await settled()
        assert host.supervisor.budget.held == 0

    run(scenario)


@pytest.mark.parametrize("count", [1, 2**30])
def test_a_refusal_takes_nothing(count: int) -> None:
    budget = ByteBudget(0)
    assert not budget.take(count)
    assert budget.held == 0
