"""Name of the sensor configuration at which a robot stands."""

import math

import pytest

from voa_msgs.geometry import SensorConfiguration
from voa_ros.motions import Motion
from voa_ros.standing import nearest_place

EAST = SensorConfiguration(name="E", x=0.3, y=0.0, yaw_rad=math.pi)
CLOSE = SensorConfiguration(name="close", x=0.27, y=0.0, yaw_rad=math.pi)
NORTH = SensorConfiguration(name="N", x=0.0, y=0.3, yaw_rad=-math.pi / 2)


@pytest.mark.parametrize(
    ("pose", "name"),
    [
        (Motion(0.31, 0.01, math.pi), "E"),
        (Motion(0.28, 0.0, -math.pi + 0.1), "close"),
        (Motion(0.3, 0.0, math.pi - 0.3), None),
        (Motion(0.45, 0.0, math.pi), None),
        (Motion(0.0, 0.25, -math.pi / 2), "N"),
    ],
)
def test_a_robot_stands_at_the_nearest_place_that_it_faces_from(pose: Motion, name: str | None) -> None:
    assert nearest_place(pose, [EAST, CLOSE, NORTH]) == name


def test_without_places_there_is_no_name() -> None:
    assert nearest_place(Motion(0.0, 0.0, 0.0), []) is None
