"""Deferred items are handed on after their delay, in order and within bounds."""

import pytest

from tests.support.waiting import SECONDS, wait_for
from voa_service.zenoh.deferred import Deferred


def test_deferred_items_are_handed_on_in_order_after_the_delay() -> None:
    handed_on: list[int] = []
    deferred = Deferred(0.05, handed_on.append, 100, 100)
    assert [deferred.put(number, 1) for number in range(10)] == [0] * 10
    assert handed_on == []
    wait_for(lambda: len(handed_on) == 10, "all of them")
    assert handed_on == list(range(10))
    deferred.close()


def test_deferred_items_can_be_hastened_and_items_after_them_wait_again() -> None:
    handed_on: list[int] = []
    deferred = Deferred(3600.0, handed_on.append, 100, 100)
    for number in range(5):
        deferred.put(number, 20)
    deferred.hasten()
    wait_for(lambda: len(handed_on) == 5, "all of them")
    deferred.put(5, 20)
    assert deferred.put(6, 90) == 1, "the bytes of those that went are free again"
    deferred.close()
    assert handed_on == list(range(5))


def test_draining_hands_on_what_waits_and_returns_when_that_is_done() -> None:
    handed_on: list[int] = []
    deferred = Deferred(3600.0, handed_on.append, 100, 100)
    for number in range(50):
        deferred.put(number, 1)
    deferred.drain(SECONDS)
    assert handed_on == list(range(50))
    deferred.put(50, 1)
    deferred.drain(0.0)
    assert handed_on == list(range(50)), "there was no time"
    deferred.close()
    deferred.drain(SECONDS)
    assert handed_on == list(range(50)), "one that is closed has no thread any more"


def test_what_is_added_while_draining_is_handed_on_too() -> None:
    handed_on: list[int] = []

    def hand_on(number: int) -> None:
        handed_on.append(number)
        if number < 5:
            deferred.put(number + 1, 1)

    deferred = Deferred(3600.0, hand_on, 100, 100)
    deferred.put(0, 1)
    deferred.drain(SECONDS)
    assert handed_on == list(range(6))
    deferred.close()


def test_deferred_items_are_dropped_at_the_end() -> None:
    handed_on: list[int] = []
    deferred = Deferred(3600.0, handed_on.append, 100, 100)
    deferred.put(1, 1)
    deferred.close()
    assert handed_on == []


@pytest.mark.parametrize(("most", "most_bytes"), [(2, 1000), (1000, 20)])
def test_beyond_the_bounds_the_oldest_are_dropped_and_counted(most: int, most_bytes: int) -> None:
    handed_on: list[int] = []
    deferred = Deferred(0.2, handed_on.append, most, most_bytes)
    assert sum(deferred.put(number, 10) for number in range(5)) == 3
    wait_for(lambda: len(handed_on) == 2, "the newest")
    deferred.close()
    assert handed_on == [3, 4]
