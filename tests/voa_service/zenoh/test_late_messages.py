"""A process that works on messages long after they came recognises the stops that the other one has counted."""

from collections.abc import Sequence

import pytest

from tests.voa_service.zenoh.replica_pair import NAME, SCANS, Pair, Process

STANDING = 3 * SCANS
"""Revolutions at a stop: a look could be taken again at each."""
DRIVE_S = 2.0
"""Time from one stop to the next."""
MANY = 1_000
LOOKS = [f"{{ scans = {scans} }}" for scans in (2, SCANS)]


def drive(pair: Pair, sensors: Sequence[str], to: Sequence[Process], behind: int = MANY) -> None:
    """Let the robot stop at places, one after another; looks are applied as they come.

    Args:
        pair: of processes.
        sensors: names of the places.
        to: processes that receive the messages.
        behind: number of messages that a process which is stuck leaves waiting.
    """
    for sensor in sensors:
        for _ in range(STANDING):
            pair.revolution(sensor, to)
            for process in to:
                if process.is_stuck:
                    process.catch_up(behind)
                process.apply()
        pair.clock.now += DRIVE_S


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("behind", [1, SCANS + 1, STANDING + 1, 2 * STANDING + 2, 3 * STANDING])
def test_a_process_that_is_always_behind_counts_nothing_twice(pair: Pair, look: str, behind: int) -> None:
    both = _, other = pair.processes(look)
    stops = ["Q1", "Q2"] * 3
    other.is_stuck = True
    drive(pair, stops, both, behind)
    other.catch_up()
    other.apply()
    assert pair.looks() == stops


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("behind", [1, 3])
def test_a_process_that_was_stuck_for_some_stops_counts_nothing_twice(pair: Pair, look: str, behind: int) -> None:
    both = _, other = pair.processes(look)
    stops = ["Q1", "Q2"] * 3
    drive(pair, stops[:2], both)
    other.is_stuck = True
    drive(pair, stops[2 : 2 + behind], both)
    other.is_stuck = False
    other.catch_up()
    other.apply()
    drive(pair, stops[2 + behind :], both)
    assert pair.looks() == stops


@pytest.mark.parametrize("look", LOOKS)
def test_a_process_that_is_behind_counts_the_stops_that_nobody_else_has(pair: Pair, look: str) -> None:
    both = _, other = pair.processes(look)
    drive(pair, ["Q1", "Q2"], both)
    other.is_stuck = True
    drive(pair, ["Q1"], both)
    drive(pair, ["Q2", "Q1"], [other])  # the one is gone
    other.catch_up()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2", "Q1"]


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("behind", [1, STANDING + 1, 2 * STANDING + 2])
def test_a_robot_that_is_claimed_while_a_process_is_behind_has_one_look_of_each_stop(
    pair: Pair, look: str, behind: int
) -> None:
    both = _, other = pair.processes(look, to=f'scenario = "{pair.scenario}"')
    other.is_stuck = True
    drive(pair, ["Q1", "Q2"], both, behind)
    second = pair.services[0].open(pair.scenario, robots=[NAME])
    drive(pair, ["Q1", "Q2", "Q1", "Q2"], both, behind)
    other.catch_up()
    other.apply()
    assert (pair.looks(), pair.looks(second)) == (["Q1", "Q2"], ["Q1", "Q2", "Q1", "Q2"])


def test_looks_from_before_a_robot_was_mapped_are_known_to_a_process_that_is_behind(pair: Pair) -> None:
    (one,) = pair.processes(count=1)
    drive(pair, ["Q1"], [one])
    (_, other) = pair.processes()  # while the robot is parked
    other.is_stuck = True
    drive(pair, ["Q1", "Q2", "Q1"], [one, other])
    other.catch_up()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1"]


def test_looks_at_a_stop_that_a_process_missed_do_not_count_for_the_next_stop(pair: Pair) -> None:
    both = one, other = pair.processes()
    drive(pair, ["Q1"], both)
    drive(pair, ["Q2", "Q1"], [one])  # the other one is cut off
    drive(pair, ["Q2"], both)
    other.is_stuck = True
    drive(pair, ["Q1"], [other])  # the one is gone
    other.catch_up()
    other.apply()
    assert pair.looks() == ["Q1", "Q2", "Q1", "Q2", "Q1"]
