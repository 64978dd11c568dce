"""Scans that arrive twice, and those that only seem to."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import scan
from voa_ros.cdr import encode_laser_scan
from voa_ros.messages import LaserScan, Stamp
from voa_ros.repeats import REMEMBERED, Repeats, payload_digest


def repeated(own: Repeats, measured: LaserScan) -> bool:
    return own.is_repeated(measured, payload_digest(encode_laser_scan(measured)))


def test_two_bridges_bring_each_scan_twice_and_each_counts_once() -> None:
    own = Repeats()
    revolutions = [scan(1.0, 2.0, at=0.2 * number) for number in range(1, 60)]
    for one in revolutions:
        assert not repeated(own, one)
        assert repeated(own, one)
        assert own.in_a_row == 1


@pytest.mark.parametrize("late", [1, 5, REMEMBERED - 1])
def test_the_second_bridge_may_be_some_revolutions_late(late: int) -> None:
    own = Repeats()
    revolutions = [scan(1.0, at=0.2 * number) for number in range(1, 60)]
    for number, one in enumerate(revolutions):
        assert not repeated(own, one)
        if number >= late:
            assert repeated(own, revolutions[number - late])


def test_a_scan_of_long_ago_is_a_new_one() -> None:
    own = Repeats()
    revolutions = [scan(1.0, at=0.2 * number) for number in range(1, REMEMBERED + 2)]
    for one in revolutions:
        repeated(own, one)
    assert not repeated(own, revolutions[0])


def test_a_frozen_stamp_makes_no_repetition() -> None:
    own = Repeats()
    assert not any(repeated(own, scan(1.0 + 0.001 * number, at=7.0)) for number in range(60))
    assert own.in_a_row == 0


def test_the_same_ranges_at_another_time_are_another_scan() -> None:
    own = Repeats()
    assert not any(repeated(own, scan(1.0, at=float(number))) for number in range(1, 60))


def test_a_driver_without_a_clock_may_say_the_same_for_ever() -> None:
    own = Repeats()
    assert not any(repeated(own, scan(1.0)) for _ in range(60))


def test_repetitions_in_a_row_are_counted() -> None:
    own = Repeats()
    counted = []
    for _ in range(10):
        repeated(own, scan(1.0, at=1.0))
        counted.append(own.in_a_row)
    assert counted == list(range(10))
    repeated(own, scan(1.0, at=2.0))
    assert own.in_a_row == 0


@given(st.binary(max_size=50), st.binary(max_size=50))
def test_payloads_have_names_of_their_own(one: bytes, other: bytes) -> None:
    assert (payload_digest(one) == payload_digest(other)) == (one == other)
    assert len(payload_digest(one)) == 16


def test_the_whole_payload_counts() -> None:
    own, first = Repeats(), scan(1.0, at=1.0)
    repeated(own, first)
    for other in (
        replace(first, frame_id="other"),
        replace(first, intensities=(1.0,)),
        replace(first, stamp=Stamp(1, 1)),
        replace(first, scan_time=0.1),
    ):
        assert not repeated(own, other)
