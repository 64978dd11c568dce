"""The types that bridges announce."""

from typing import Any

import pytest

from tests.support.routers import router
from tests.support.waiting import wait_for
from voa_client import ZenohAddress
from voa_client.zenoh_session import joined
from voa_recordings.recorder.bridges import BridgeTypes, announced

IMU = "sensor_msgs/msg/Imu"


@pytest.mark.parametrize(
    ("token", "type_name"),
    [
        ("@/a1b2/@ros2_lv/MP/rb§imu/sensor_msgs§msg§Imu/:1:,10", IMU),
        ("@/a1b2/@ros2_lv/MS/rb§imu/sensor_msgs§msg§Imu/:1:,10", IMU),
        ("@ros2_lv/a1b2/MP/rb§imu/sensor_msgs§msg§Imu/:1:,10", IMU),
        ("@/a1b2/@ros2_lv/MP/rb§imu/sensor_msgs§srv§Imu/:1:,10", None),
        ("@/a1b2/@ros2_lv/MP/other/sensor_msgs§msg§Imu/:1:,10", None),
        ("a/b", None),
    ],
)
def test_a_token_tells_the_type_of_its_key(token: str, type_name: str | None) -> None:
    types = BridgeTypes()
    types.note(token)
    assert types.type_of("rb/imu") == type_name


def test_what_was_announced_before_and_since_is_known() -> None:
    with router() as own, joined(ZenohAddress.parse(f"zenoh://127.0.0.1:{own.port}")) as bridge:
        before: Any = bridge.liveliness().declare_token("@/a1/@ros2_lv/MP/rb§imu/sensor_msgs§msg§Imu/:::")
        with joined(ZenohAddress.parse(f"zenoh://127.0.0.1:{own.port}")) as session, announced(session) as types:
            wait_for(lambda: types.type_of("rb/imu") == IMU, "the earlier token is known")
            since: Any = bridge.liveliness().declare_token("@/a1/@ros2_lv/MP/rb§joy/sensor_msgs§msg§Joy/:::")
            wait_for(lambda: types.type_of("rb/joy") == "sensor_msgs/msg/Joy", "the later token is known")
            before.undeclare()
            since.undeclare()
        assert types.type_of("rb/imu") == IMU, "what was recorded keeps its type"
