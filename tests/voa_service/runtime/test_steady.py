"""A clock by which nothing becomes old because a clock was set."""

from datetime import UTC, datetime, timedelta

from voa_service.runtime.steady import SteadyClock

NOON = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)


class Machine:
    """Machine whose wall clock can be set."""

    def __init__(self) -> None:
        self.wall, self.seconds = NOON, 100.0

    def passes(self, seconds: float) -> None:
        self.wall += timedelta(seconds=seconds)
        self.seconds += seconds

    def clock(self) -> SteadyClock:
        return SteadyClock(lambda: self.wall, lambda: self.seconds)


def test_it_is_the_wall_clock_while_nobody_sets_that() -> None:
    machine = Machine()
    clock = machine.clock()
    machine.passes(3600.0)
    assert (clock.now(), clock.behind_s()) == (NOON + timedelta(hours=1), 0.0)


def test_it_does_not_follow_a_clock_that_is_set_forward() -> None:
    machine = Machine()
    clock = machine.clock()
    machine.wall += timedelta(days=400)
    machine.passes(60.0)
    assert (clock.now(), clock.behind_s()) == (NOON + timedelta(seconds=60), 400 * 86_400.0)


def test_it_follows_a_clock_that_is_set_back_and_then_goes_on_from_where_it_was() -> None:
    machine = Machine()
    clock = machine.clock()
    machine.wall -= timedelta(days=400)
    machine.passes(60.0)
    assert (clock.now(), clock.behind_s()) == (machine.wall, 0.0)
    machine.wall += timedelta(days=400)
    assert (clock.now(), clock.behind_s()) == (NOON + timedelta(seconds=60), 0.0)
