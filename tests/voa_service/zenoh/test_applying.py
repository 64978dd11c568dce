"""Looks are applied once and none is lost: refused looks, processes that end, and a database that fails."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import pytest

from tests.voa_service.zenoh.replica_pair import NOTHING, SCANS, Pair
from voa_service.failures import Failure
from voa_store.errors import Unavailable


def test_what_the_one_has_not_applied_when_it_ends_the_other_does(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both)
    one.apply()
    pair.stop("Q2", both)
    pair.stop("Q1", both)
    other.apply()  # the one was killed
    pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_a_look_that_is_refused_is_taken_again_and_counts_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    assert "not accepted (no_beams)" in str(one.robot.waiting_for)
    pair.stop("Q1", both)  # for the other one this stop's look is taken
    one.apply()
    other.apply()
    pair.stop("Q1", both)
    one.apply()
    other.apply()
    assert pair.looks() == ["Q1"]


def test_after_a_stop_without_a_look_the_next_ones_count_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    for number in range(4):
        sensor = ["Q2", "Q1"][number % 2]
        pair.revolution(sensor, [one])
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q2", "Q1", "Q2", "Q1"]


def test_a_look_that_is_refused_and_not_taken_again_by_who_ends_is_taken_by_the_other(pair: Pair) -> None:
    both = one, other = pair.processes()
    pair.stop("Q1", both, NOTHING)
    one.apply()
    other.apply()
    pair.stop("Q1", [other])
    other.apply()
    assert pair.looks() == ["Q1"]


def once(call: Callable[..., Any]) -> Callable[..., Any]:
    """Make a call that fails the first time, as where the database does not answer."""
    calls = iter([True])

    def called(*given: Any) -> Any:
        if next(calls, False):
            raise Unavailable("the database does not answer")
        return call(*given)

    return called


def committed_once(call: Callable[..., Any]) -> Callable[..., Any]:
    """Make a call that fails the first time although its work is done, as where the response is lost."""
    failing = once(lambda: None)

    @contextmanager
    def block(inner: AbstractContextManager[Any]) -> Iterator[Any]:
        with inner as change:
            yield change
        failing()

    def called(*given: Any) -> Any:
        result = call(*given)
        if isinstance(result, AbstractContextManager):
            return block(result)
        failing()
        return result

    return called


@pytest.mark.parametrize("method", ["settle_robot", "change", "robot_looks", "history", "get_session"])
@pytest.mark.parametrize("fails", [once, committed_once])
def test_a_call_of_the_database_that_fails_loses_no_look_and_doubles_none(
    pair: Pair, monkeypatch: pytest.MonkeyPatch, method: str, fails: Callable[..., Any]
) -> None:
    (one,) = pair.processes(to=f'scenario = "{pair.scenario}"', count=1)
    pair.revolution("Q1", [one])
    store = pair.services[0].inside.sessions.store
    monkeypatch.setattr(store, method, fails(getattr(store, method)))
    refused = 0
    for _ in range(2 * SCANS + 4):
        try:
            pair.revolution("Q1", [one])
        except Failure:
            refused += 1
        one.apply()
    assert pair.looks() == ["Q1"]
    assert refused <= 1
