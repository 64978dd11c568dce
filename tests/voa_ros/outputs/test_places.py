import math

import pytest

from tests.support.views import ranking, stored_scenario
from voa_ros.motions import Motion, composed
from voa_ros.outputs.places import base_pose, place
from voa_ros.robots import RobotMapping, load


def mapped(place_: str, more: str = "") -> RobotMapping:
    return load(f'[[robot]]\nname = "tb3_1"\nsession = "s"\nplace = {place_}\n{more}')[0]


ORIGIN = "origin = { x = 0.4, y = -0.2, yaw_rad = 2.0 }"


def test_origin_base_and_mount_lead_back_to_the_lidar() -> None:
    mapping = mapped(f'{{ from = "odometry", {ORIGIN} }}', "lidar = { x = -0.032, y = 0.01, yaw_rad = 0.5 }")
    lidar = Motion(0.3, 0.1, -2.5)
    base = base_pose(lidar, mapping)
    again = composed(composed(mapping.place.origin, base), mapping.lidar)  # type: ignore[union-attr] # this mapping has an origin
    assert (again.x, again.y) == pytest.approx((0.3, 0.1))
    assert math.remainder(again.yaw_rad + 2.5, math.tau) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("place_", "more", "frame"),
    [
        ('{ from = "odometry" }', "", "odom"),
        ('{ from = "amcl" }', "", "map"),
        ('{ from = "attachment" }', "", "world"),
        ('{ from = "amcl" }', 'outputs = { place_frame_id = "lab_map" }', "lab_map"),
        ('{ from = "sensor", sensor = "E" }', 'outputs = { frame_id = "table" }', "table"),
    ],
)
def test_the_goal_is_in_the_frame_in_which_the_robot_knows_its_pose(place_: str, more: str, frame: str) -> None:
    goal = place(stored_scenario(), ranking(), mapped(place_, more))
    assert goal is not None
    assert goal["header"] == {"frame_id": frame}


def test_a_recommendation_to_grasp_gives_no_goal() -> None:
    grasp = ranking(action="grasp", grasp="G1", expected_score=0.9)
    assert place(stored_scenario(), grasp, mapped('{ from = "amcl" }')) is None


def test_a_place_that_the_scenario_does_not_list_gives_no_goal() -> None:
    other = ranking(action="look", sensor="0", net_value=0.1)
    assert place(stored_scenario(), other, mapped('{ from = "amcl" }')) is None
