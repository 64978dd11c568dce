"""The gate: who is refused, in which order, and what is counted."""

from collections.abc import Iterator

import pytest

from tests.voa_service.access.test_keyring import Shelf
from voa_service.access.callers import ANONYMOUS
from voa_service.access.gate import Gate
from voa_service.access.keyring import Keyring
from voa_service.access.rates import Rates
from voa_service.access.roles import BY_NAME, UNLISTED
from voa_service.failures import Forbidden, TooManyRequests, Unauthenticated


@pytest.fixture
def shelf() -> Shelf:
    return Shelf()


@pytest.fixture
def gate(shelf: Shelf) -> Iterator[Gate]:
    ring = Keyring(shelf, shelf.now, refresh_seconds=3600.0)
    yield Gate(ring, Rates("2/hour", "2/hour"))
    ring.close()


def test_health_is_answered_without_a_key_and_everything_else_is_not(gate: Gate, shelf: Shelf) -> None:
    shelf.make()
    gate.keyring.refresh()
    assert gate.identify(None, BY_NAME["service.health"]) is ANONYMOUS
    for call in (*BY_NAME.values(), UNLISTED):
        if not call.public:
            with pytest.raises(Unauthenticated):
                gate.identify(None, call)


def test_what_is_not_in_the_table_is_for_operators(gate: Gate, shelf: Shelf) -> None:
    sensor, operator = shelf.make(), shelf.make(role="operator")
    gate.keyring.refresh()
    with pytest.raises(Forbidden):
        gate.admit(gate.identify(sensor.text, UNLISTED), UNLISTED)
    gate.admit(gate.identify(operator.text, UNLISTED), UNLISTED)


def test_a_call_that_is_refused_does_not_count(gate: Gate, shelf: Shelf) -> None:
    made = shelf.make(sessions=("s1",))
    gate.keyring.refresh()
    call = BY_NAME["scan.apply"]
    caller = gate.identify(made.text, call)
    for _ in range(5):
        with pytest.raises(Forbidden):
            gate.admit(caller, call, "s2")
        with pytest.raises(Forbidden):
            gate.admit(caller, BY_NAME["belief.put"], "s1")
    gate.admit(caller, call, "s1")
    gate.admit(caller, call, "s1")
    with pytest.raises(TooManyRequests):
        gate.admit(caller, call, "s1")
