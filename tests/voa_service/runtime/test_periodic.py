"""Work in the background is repeated, survives a database that fails, and ends."""

import threading
from collections.abc import Callable

from tests.support.waiting import wait_for
from voa_service.runtime.periodic import Periodic
from voa_store.errors import Unavailable


def test_work_is_repeated_and_a_failing_database_only_delays_it() -> None:
    rounds: list[int] = []

    def work(_: Callable[[float], object]) -> None:
        rounds.append(1)
        if len(rounds) < 3:
            raise Unavailable("the database does not work")

    periodic = Periodic("test", work, 0.001)
    periodic.start()
    wait_for(lambda: len(rounds) > 5, "rounds")
    periodic.close()
    ended = len(rounds)
    assert not [thread for thread in threading.enumerate() if thread.name == "test"]
    assert len(rounds) == ended


def test_closing_ends_a_pause_of_the_work() -> None:
    pausing = threading.Event()
    ended: list[object] = []

    def work(pause: Callable[[float], object]) -> None:
        pausing.set()
        ended.append(pause(600.0))

    periodic = Periodic("test", work, 600.0)
    periodic.start()
    assert pausing.wait(30.0)
    periodic.close()
    assert ended == [True]


def test_a_thread_that_was_not_started_can_be_closed() -> None:
    Periodic("test", lambda pause: None, 1.0).close()


def test_the_first_round_can_wait_and_closing_ends_that() -> None:
    rounds: list[int] = []
    periodic = Periodic("test", lambda _: rounds.append(1), 0.001, 3600.0)
    periodic.start()
    periodic.close()
    assert rounds == []
    assert not [thread for thread in threading.enumerate() if thread.name == "test"]
