"""The gate: who is refused, in which order, and what is counted."""

from collections.abc import Iterator

import pytest

from tests.voa_service.access.test_keyring import Shelf
from voa_service.access.callers import ANONYMOUS
from voa_service.access.gate import Gate
from voa_service.access.keyring import Keyring
from voa_service.access.rates import Rates
from voa_service.access.roles import BY_NAME, UNLISTED
from voa_service.failures import Forbidden, TooManyRequests, TooManyWithoutKey, Unauthenticated


@pytest.fixture
def shelf() -> Shelf:
    return Shelf()


@pytest.fixture
def gate(shelf: Shelf) -> Iterator[Gate]:
    ring = Keyring(shelf, shelf.now, refresh_seconds=3600.0)
    yield Gate(ring, Rates("3/hour", "1/hour", "2/hour"))
    ring.close()


def test_health_is_answered_without_a_key_and_everything_else_is_not(gate: Gate, shelf: Shelf) -> None:
    shelf.make()
    gate.keyring.refresh()
    assert gate.identify(None, BY_NAME["service.health"], "here") is ANONYMOUS
    for call in (*BY_NAME.values(), UNLISTED):
        if not call.public:
            with pytest.raises(Unauthenticated):
                gate.identify(None, call, call.name)


def test_what_is_not_in_the_table_is_for_operators(gate: Gate, shelf: Shelf) -> None:
    sensor, operator = shelf.make(), shelf.make(role="operator")
    gate.keyring.refresh()
    with pytest.raises(Forbidden):
        gate.admit(gate.identify(sensor.text, UNLISTED, "here"), UNLISTED)
    gate.admit(gate.identify(operator.text, UNLISTED, "here"), UNLISTED)


def test_a_call_that_a_key_may_not_make_counts_as_a_call_and_not_as_a_heavy_one(gate: Gate, shelf: Shelf) -> None:
    made = shelf.make(sessions=("s1",))
    gate.keyring.refresh()
    rank = BY_NAME["voa.rank"]
    caller = gate.identify(made.text, rank, "here")
    for call, subject in ((rank, "s2"), (BY_NAME["belief.put"], "s1")):
        with pytest.raises(Forbidden):
            gate.admit(caller, call, subject)
    gate.admit(caller, rank, "s1")
    for call in (rank, BY_NAME["belief.put"]):
        with pytest.raises(TooManyRequests, match="may make 3 calls per hour"):
            gate.admit(caller, call, "s1")


def test_origins_whose_name_the_caller_chooses_are_limited_together_at_ten_times_the_rate(
    gate: Gate, shelf: Shelf
) -> None:
    shelf.make()
    gate.keyring.refresh()
    call = BY_NAME["scan.put"]

    def is_reported(name: str, group: str | None = "robots") -> bool:
        try:
            gate.identify(None, call, name, group)
        except TooManyWithoutKey:
            return False
        except Unauthenticated:
            return True
        raise AssertionError("a call without a key was admitted")

    assert [is_reported("one") for _ in range(40)].count(True) == 2, "this name leaves room for others"
    assert [is_reported(f"robot {number}") for number in range(40)].count(True) == 18
    assert is_reported("alone", None)
    with pytest.raises(TooManyWithoutKey, match="more than 20 calls without a valid key per hour came from robots"):
        gate.identify(None, call, "another", "robots")


def test_calls_without_a_valid_key_are_limited_by_origin_and_a_valid_key_passes(gate: Gate, shelf: Shelf) -> None:
    made = shelf.make()
    gate.keyring.refresh()
    call = BY_NAME["session.get"]
    for key in (None, "nonsense"):
        with pytest.raises(Unauthenticated):
            gate.identify(key, call, "host")
    with pytest.raises(TooManyWithoutKey, match="2 calls without a valid key per hour came from host: send a key"):
        gate.identify("nonsense", call, "host")
    with pytest.raises(Unauthenticated):
        gate.identify(None, call, "10.0.0.2")
    assert gate.identify(made.text, call, "host").key == made.id
