from datetime import UTC, datetime, timedelta, timezone

import pytest

from voa_ros.outputs.fields import stamp_of, turned


def test_a_stamp_counts_from_1970_whatever_the_time_zone() -> None:
    east = timezone(timedelta(hours=9))
    assert stamp_of(datetime(1970, 1, 1, 0, 0, 1, 5, tzinfo=UTC)) == {"sec": 1, "nanosec": 5_000}
    assert stamp_of(datetime(1970, 1, 1, 9, 0, 1, 5, tzinfo=east)) == {"sec": 1, "nanosec": 5_000}


def test_a_quarter_turn_about_z_turns_x_to_y() -> None:
    half = 0.5**0.5
    assert turned((half, 0.0, 0.0, half), (1.0, 0.0, 2.0)) == pytest.approx((0.0, 1.0, 2.0))
