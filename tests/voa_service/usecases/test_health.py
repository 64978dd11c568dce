"""Readiness: the store is read and written, seldom, and nobody waits for it."""

import threading
from typing import Any, cast

import pytest

from tests.support.waiting import wait_for
from voa_service.failures import Failure
from voa_service.ports import Store
from voa_service.usecases.health import StoreCheck
from voa_store.errors import Unavailable


class Scripted:
    """A store whose `ping` is scripted, and a clock."""

    def __init__(self) -> None:
        self.pings = 0
        self.troubles = 0
        self.error: Exception | None = None
        self.free = threading.Event()
        self.free.set()
        self.now = 100.0

    def ping(self) -> None:
        self.pings += 1
        assert self.free.wait(30.0)
        if self.error is not None:
            raise self.error

    def check(self) -> StoreCheck:
        return StoreCheck(cast(Store, self), lambda: self.now)


def test_a_store_that_works_is_tried_once_a_second_at_most() -> None:
    store = Scripted()
    check = store.check()
    for _ in range(5):
        check.check()
    assert store.pings == 1
    store.now += 1.5
    check.check()
    assert store.pings == 2


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (Unavailable("database or disk is full"), "disk is full"),
        (OSError("the secret of the house"), "the store does not answer: OSError"),
    ],
)
def test_a_store_that_fails_is_not_ready_and_tried_each_time(error: Exception, says: str) -> None:
    store = Scripted()
    check = store.check()
    store.error = error
    for _ in range(3):
        with pytest.raises(Failure, match=says) as refused:
            check.check()
        assert refused.value.status == 503
    assert store.pings == 3
    store.error = None
    check.check()


def test_a_failure_of_another_call_has_it_tried_at_once() -> None:
    store = Scripted()
    check = store.check()
    check.check()
    store.troubles, store.error = 1, Unavailable("gone")
    with pytest.raises(Failure, match="gone"):
        check.check()


def test_a_busy_writer_does_not_make_readiness_wait_until_it_is_late() -> None:
    store = Scripted()
    check = store.check()
    check.check()
    store.now += 2.0
    store.free.clear()
    check.check()  # as before: the attempt goes on
    check.check()
    assert store.pings == 2
    store.now += 30.0
    with pytest.raises(Failure, match="has not ended for 30 s"):
        check.check()
    store.free.set()

    def works() -> bool:
        try:
            check.check()
        except Failure:
            return False
        return True

    wait_for(works, "the attempt to end")


def test_health_names_the_database(service: Any) -> None:
    assert service.get("/readyz")["database"].startswith("SQLite 3.")
