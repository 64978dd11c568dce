"""Subscriptions of the recorder: keys of rmw_zenoh are distinguished from those of a bridge."""

import pytest

from tests.voa_recordings.recorder.samples import RMW
from voa_recordings.recorder.listening import is_of_rmw


@pytest.mark.parametrize(
    ("key", "of_rmw"),
    [(RMW, True), ("a/rb/b/c", False), ("x/rb/scan/sensor_msgs::msg::dds_::LaserScan_/h", False), ("rb/scan", False)],
)
def test_keys_of_rmw_zenoh_are_recognised_by_domain_and_type(key: str, of_rmw: bool) -> None:
    assert is_of_rmw(key) == of_rmw
