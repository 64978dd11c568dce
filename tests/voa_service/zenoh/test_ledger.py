"""Each stop counts once: two processes that receive the same scans, and apply their looks sooner or later."""

from typing import Any

import pytest

from tests.voa_service.zenoh.replica_pair import Pair


def test_what_both_take_of_the_same_revolutions_counts_once(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(4):
        pair.stop(["Q1", "Q2"][number % 2], both)
        one.apply()
        other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_looks_of_one_stop_count_once_although_they_are_of_other_revolutions(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(4):
        sensor = ["Q1", "Q2"][number % 2]
        pair.revolution(sensor, [one])  # the other one misses it
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_a_process_that_is_far_behind_counts_nothing_twice(pair: Pair) -> None:
    both = one, other = pair.processes()
    for number in range(12):
        sensor = ["Q1", "Q2"][number % 2]
        pair.revolution(sensor, [other])
        pair.stop(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2"] * 6


def test_a_process_that_starts_while_the_robot_is_parked_takes_no_second_look(pair: Pair) -> None:
    (one,) = pair.processes(count=1)
    pair.stop("Q1", [one])
    one.apply()
    (_, other) = pair.processes()
    for _ in range(3):
        pair.stop("Q1", [other])
    other.apply()
    assert (pair.looks(), other.robot.waiting_for) == (["Q1"], "the robot to move on: this stop's look is taken")
    pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q1", "Q2"]


def test_a_process_that_starts_before_the_look_of_the_stop_is_applied_takes_none_that_counts(pair: Pair) -> None:
    (one,) = pair.processes(count=1)
    pair.stop("Q1", [one])
    (_, other) = pair.processes()
    pair.revolution("Q1", [other])
    one.apply()
    for _ in range(3):
        pair.stop("Q1", [other])
    other.apply()
    assert pair.looks() == ["Q1"]


def test_a_robot_without_a_clock_and_without_noise_comes_back_to_a_place(pair: Pair) -> None:
    both = one, other = pair.processes()
    for sensor in ("Q1", "Q2", "Q1", "Q2", "Q1"):
        pair.stop(sensor, both, clock=False)
        one.apply()
        other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2", "Q1"]


def test_a_look_is_searched_among_those_since_its_stop_began(pair: Pair) -> None:
    """The other process was cut off while the robot was at a place to which it comes back."""
    both = one, other = pair.processes()
    pair.stop("Q2", both)
    pair.stop("Q1", [one])
    pair.stop("Q2", [one])
    one.apply()
    other.apply()
    for _ in range(2):
        pair.stop("Q1", [other])  # the one is gone
    other.apply()
    assert pair.looks() == ["Q2", "Q1", "Q2", "Q1"]


def test_a_look_of_this_stop_is_detected_although_an_own_one_was_counted_after_it(pair: Pair) -> None:
    one, other = pair.processes()
    pair.stop("Q1", [other])  # the one misses it
    pair.stop("Q2", [one])
    one.apply()
    other.apply()  # late
    for _ in range(2):
        pair.stop("Q2", [other])
    other.apply()
    assert pair.looks() == ["Q2", "Q1"]


@pytest.mark.parametrize("missed", [0, 1])
def test_looks_of_two_revolutions_count_once(pair: Pair, missed: int) -> None:
    both = one, other = pair.processes("{ scans = 2 }")
    for number in range(4):
        sensor = ["Q1", "Q2"][number % 2]
        for _ in range(missed):
            pair.revolution(sensor, [one])
        for _ in range(3):
            pair.revolution(sensor, both)
        one.apply()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2"]


def test_every_scan_counts_once_also_when_one_process_is_far_behind(pair: Pair) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    for _ in range(150):
        pair.revolution("Q1", both)
        one.apply()
    other.apply()
    assert len(pair.looks()) == 150


@pytest.mark.parametrize("clock", [True, False])
def test_every_scan_counts_once_also_when_one_process_ends(pair: Pair, clock: bool) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    for _ in range(20):
        pair.revolution("Q1", both, clock=clock)
    one.apply(5)
    other.apply()
    assert len(pair.looks()) == 20


def test_scans_that_are_alike_count_one_for_one_also_after_one_that_was_missed(pair: Pair) -> None:
    both = one, other = pair.processes('{ mode = "every" }')
    pair.revolution("Q1", [other])
    other.due.clear()
    pair.revolution("Q1", [one], (0.6, 0.5, 0.5, 1.0))  # the other one misses it
    one.apply()
    for _ in range(20):
        pair.revolution("Q1", both, clock=False)
    one.apply(5)
    other.apply()
    assert len(pair.looks()) == 21


def test_a_process_reads_no_more_than_it_must_where_every_scan_counts(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = pair.processes('{ mode = "every" }', count=1)
    store, reads = pair.services[0].inside.sessions.store, []
    read = store.robot_looks

    def counted(id_: str, robot: str, limit: int) -> Any:
        reads.append(limit)
        return read(id_, robot, limit)

    monkeypatch.setattr(store, "robot_looks", counted)
    for _ in range(50):
        pair.revolution("Q1", [one])
        one.apply()
    assert len(pair.looks()) == 50
    assert set(reads) == {1}


@pytest.mark.parametrize("scans", [1, 5])
def test_scans_that_are_alike_count_after_a_restart(pair: Pair, scans: int) -> None:
    (one,) = pair.processes('{ mode = "every" }', count=1)
    for _ in range(scans):
        pair.revolution("Q1", [one], clock=False)
    one.apply()
    (again,) = pair.processes('{ mode = "every" }', count=1)
    for _ in range(scans):
        pair.revolution("Q1", [again], clock=False)
    again.apply()
    assert len(pair.looks()) == 2 * scans


@pytest.mark.parametrize("scans", [2, 3])
def test_requests_to_either_process_are_looks(pair: Pair, scans: int) -> None:
    both = pair.processes(f'{{ mode = "on_request", scans = {scans} }}')
    for number in range(4):
        both[number % 2].robot.request()
        for _ in range(scans):
            pair.revolution("Q1", both)
        for process in both:
            process.apply()
    assert len(pair.looks()) == 4
