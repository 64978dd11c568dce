"""The scheduler: virtual time, one task at a time, and death at any step."""

import pytest

from tests.simulation.scheduler import Endless, Killed, Owner, Scheduler, Signal


def steps_of(seed: int) -> list[tuple[float, str, str]]:
    scheduler = Scheduler(seed)

    def work() -> None:
        for index in range(5):
            scheduler.step(str(index))

    for name in ("one", "two", "three"):
        scheduler.spawn(name, work)
    scheduler.run()
    return scheduler.trace


def test_a_seed_decides_the_order_of_steps() -> None:
    assert steps_of(1) == steps_of(1)
    orders = {tuple(name for _, name, _ in steps_of(seed)) for seed in range(20)}
    assert len(orders) == 20


def test_a_task_draws_the_same_whatever_other_tasks_there_are() -> None:
    def drawn(others: int) -> list[float]:
        scheduler, seen = Scheduler(7), list[float]()

        def work() -> None:
            task = scheduler.current
            assert task is not None
            for _ in range(3):
                scheduler.step("draws")
                seen.append(task.random.random())

        for index in range(others):
            scheduler.spawn(f"other{index}", lambda: scheduler.step("goes on"))
        scheduler.spawn("it", work)
        scheduler.run()
        return seen

    assert drawn(0) == drawn(5)


def test_time_passes_only_where_tasks_pause() -> None:
    scheduler, seen = Scheduler(1), list[float]()

    def work() -> None:
        scheduler.pause(3600.0)
        seen.append(scheduler.now)

    scheduler.spawn("sleeper", work)
    scheduler.run()
    assert seen == [3600.0]


def test_a_process_dies_at_its_step_and_others_go_on() -> None:
    scheduler, done, cleaned = Scheduler(3), list[str](), list[str]()
    owner = Owner("a", crash_at=2)
    owner.on_crash = lambda: scheduler.kill(owner)

    def doomed() -> None:
        try:
            for index in range(9):
                scheduler.step(str(index))
                done.append(f"doomed {index}")
        except Killed:
            scheduler.step("a step of a dead task returns at once")
            cleaned.append("doomed")
            raise

    def other() -> None:
        for index in range(9):
            scheduler.step(str(index))
        done.append("other")

    scheduler.spawn("doomed", doomed, owner)
    scheduler.spawn("other", other)
    scheduler.run()
    assert done == ["doomed 0", "other"]
    assert cleaned == ["doomed"]


def test_a_signal_wakes_those_that_wait_and_others_wake_by_themselves() -> None:
    scheduler, signal, woken = Scheduler(4), Signal(), list[tuple[str, bool]]()

    def waiting(name: str, seconds: float) -> None:
        scheduler.wait(signal, seconds)
        woken.append((name, scheduler.now < 5.0))

    scheduler.spawn("impatient", lambda: waiting("impatient", 1.0))
    scheduler.spawn("patient", lambda: waiting("patient", 100.0))
    scheduler.at(4.0, lambda: scheduler.notify(signal))
    scheduler.run()
    assert woken == [("impatient", True), ("patient", True)]
    assert scheduler.now < 101.0


def test_an_unexpected_error_of_a_task_is_kept_and_others_go_on() -> None:
    scheduler = Scheduler(5)

    def fails() -> None:
        scheduler.step("before")
        raise ValueError("wrong")

    scheduler.spawn("fails", fails)
    scheduler.spawn("other", lambda: scheduler.step("after"))
    scheduler.run()
    assert [(task.name, str(error)) for task, error in scheduler.errors] == [("fails", "wrong")]


def test_a_run_that_does_not_end_is_ended() -> None:
    scheduler = Scheduler(6, most_steps=100)

    def forever() -> None:
        while True:
            scheduler.step("again")

    scheduler.spawn("forever", forever)
    scheduler.run()
    assert isinstance(scheduler.errors[0][1], Endless)


def test_only_a_task_can_wait() -> None:
    with pytest.raises(RuntimeError, match="only a task"):
        Scheduler(1).pause(1.0)
