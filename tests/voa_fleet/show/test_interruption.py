"""Interruption early, in order and for certain."""

import signal
import threading
from contextlib import suppress

import pytest

from voa_fleet.show.interruption import TimeIsUp, interruptible


def test_nothing_rings_when_it_is_over_in_time() -> None:
    before = signal.getsignal(signal.SIGALRM), signal.getsignal(signal.SIGINT)
    with interruptible(60.0) as interruption:
        assert signal.getitimer(signal.ITIMER_REAL)[0] > 0.0
        interruption.check()
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0
    assert (signal.getsignal(signal.SIGALRM), signal.getsignal(signal.SIGINT)) == before


def test_the_end_of_its_time_is_raised_in_the_middle_of_anything() -> None:
    with pytest.raises(TimeIsUp), interruptible(0.01):
        threading.Event().wait(30.0)


@pytest.mark.parametrize(("number", "kind"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGALRM, TimeIsUp)])
def test_a_signal_that_somebody_swallowed_is_not_forgotten(number: signal.Signals, kind: type[BaseException]) -> None:
    with interruptible(None) as interruption:
        with suppress(BaseException):  # as a callback of a library may
            signal.raise_signal(number)
        with pytest.raises(kind):
            interruption.check()


def test_other_threads_are_left_alone() -> None:
    seen: list[bool] = []

    def work() -> None:
        with interruptible(60.0) as interruption:
            interruption.check()
            seen.append(signal.getitimer(signal.ITIMER_REAL)[0] == 0.0)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(30.0)
    assert seen == [True]
