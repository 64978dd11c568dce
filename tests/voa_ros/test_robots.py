import math

import pytest

from voa_msgs.geometry import PoseUncertainty
from voa_ros.robot_places import AmclPlace, AttachmentPlace, Mount, OdometryPlace, PlanarPose, SensorPlace
from voa_ros.robots import InvalidRobots, LookRule, RobotMapping, Subscription, load
from voa_ros.topics import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE_STAMPED

FULL = """
[[robot]]
name = "tb3_1"
session = "4f1c"
namespace = "lab/tb3_1"
scan = "front/scan"
domain = 7
frame_id = "base_scan"
stamp = "after_revolution"
lidar = { x = -0.032, y = 0, yaw_rad = 0.5, height_m = 0.18, upside_down = true }
look = { mode = "on_request", scans = 7 }

[robot.place]
from = "odometry"
topic = "/odometry/filtered"
origin = { x = 0.4, y = 0.0, yaw_rad = 3.14 }
std = { xy_m = 0.01, yaw_rad = 0.02 }
max_age_s = 0.3
"""
SHORT = """
[[robot]]
name = "tb3_1"
scenario = "abc"
place = { from = "sensor", sensor = "E" }
"""


def with_place(place: str) -> RobotMapping:
    return load(SHORT.replace('from = "sensor", sensor = "E"', place))[0]


def test_everything_that_can_be_said_is_read() -> None:
    (robot,) = load(FULL)
    assert (robot.name, robot.session, robot.scenario, robot.stamp) == ("tb3_1", "4f1c", None, "after_revolution")
    assert (robot.domain, robot.frame_id) == (7, "base_scan")
    assert robot.lidar == Mount(x=-0.032, y=0.0, yaw_rad=0.5, height_m=0.18, upside_down=True)
    assert robot.look == LookRule(mode="on_request", scans=7)
    place = robot.place
    assert isinstance(place, OdometryPlace)
    assert (place.origin, place.max_age_s) == (PlanarPose(x=0.4, yaw_rad=3.14), 0.3)
    assert place.std == PoseUncertainty(xy_m=0.01, yaw_rad=0.02)
    assert robot.subscriptions == (
        Subscription("lab/tb3_1/front/scan", LASER_SCAN),
        Subscription("odometry/filtered", ODOMETRY),
    )


def test_what_is_not_said_has_a_default() -> None:
    (robot,) = load(SHORT)
    assert (robot.session, robot.scenario, robot.stamp, robot.lidar) == (None, "abc", "first_ray", Mount())
    assert (robot.domain, robot.frame_id, robot.lidar.upside_down) == (0, None, False)
    assert (robot.look.mode, robot.look.scans) == ("stationary", 10)
    assert robot.look.still_yaw_rad == pytest.approx(math.radians(0.5))
    assert isinstance(robot.place, SensorPlace)
    assert robot.subscriptions == (Subscription("tb3_1/scan", LASER_SCAN),)


def test_amcl_needs_odometry_too() -> None:
    robot = with_place('from = "amcl"')
    assert isinstance(robot.place, AmclPlace)
    assert robot.subscriptions == (
        Subscription("tb3_1/scan", LASER_SCAN),
        Subscription("tb3_1/odom", ODOMETRY),
        Subscription("tb3_1/amcl_pose", POSE_WITH_COVARIANCE_STAMPED),
    )


def test_attachments_need_no_other_topic() -> None:
    robot = with_place('from = "attachment"')
    assert isinstance(robot.place, AttachmentPlace)
    assert (robot.odometry_topic, robot.amcl_topic) == (None, None)


def test_an_empty_namespace_is_none() -> None:
    (robot,) = load(SHORT + 'namespace = ""')
    assert robot.scan_topic == "scan"


def test_a_file_may_map_nothing_or_many() -> None:
    assert load("") == ()
    assert [robot.name for robot in load(SHORT + SHORT.replace("tb3_1", "tb3_2"))] == ["tb3_1", "tb3_2"]


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('session = "4f1c"', "", "robot 'tb3_1': expected exactly one of 'session' and 'scenario'"),
        ("session", 'scenario = "a"\nsession', "robot 'tb3_1': expected exactly one of 'session' and 'scenario'"),
        ('name = "tb3_1"', "", "robot no. 1: name: this field is required"),
        ('name = "tb3_1"', 'name = "tb3/1"', "robot 'tb3/1': name: String should match"),
        ('namespace = "lab/tb3_1"', 'namespace = "a b"', "robot 'tb3_1': namespace: expected a topic like"),
        ('"front/scan"', '""', "robot 'tb3_1': scan: expected a topic like 'tb3_1/scan'"),
        ("after_revolution", "late", "robot 'tb3_1': stamp: Input should be 'first_ray' or 'after_revolution'"),
        ("y = 0,", "z = 0,", "robot 'tb3_1': lidar.z: no such field: expected one of x, y, yaw_rad, height_m"),
        ("upside_down = true", "upside_down = 1", "robot 'tb3_1': lidar.upside_down: Input should be a valid boolean"),
        ("upside_down", "inverted", "robot 'tb3_1': lidar.inverted: no such field: expected one of x, y, yaw_rad"),
        ("domain = 7", "domain = 233", "robot 'tb3_1': domain: Input should be less than or equal to 232"),
        ("domain = 7", "domain = -1", "robot 'tb3_1': domain: Input should be greater than or equal to 0"),
        ("domain = 7", 'domain = "7"', "robot 'tb3_1': domain: Input should be a valid integer"),
        ('"base_scan"', '""', "robot 'tb3_1': frame_id: String should have at least 1 character"),
        ("x = -0.032", 'x = "a"', "robot 'tb3_1': lidar.x: Input should be a valid number"),
        ("x = -0.032", "x = nan", "robot 'tb3_1': lidar.x: expected a finite number, got nan"),
        ("x = -0.032", "x = true", "robot 'tb3_1': lidar.x: Input should be a valid number"),
        ("scans = 7", "scans = 0", "robot 'tb3_1': look.scans: Input should be greater than or equal to 1"),
        ("scans = 7", "scans = 1", "robot 'tb3_1': look: scans: expected at least 2 in mode 'on_request'"),
        ("scans = 7", "moved_xy_m = 0.001", "robot 'tb3_1': look: expected moved_xy_m"),
        ("scans = 7", "turns = 7", "robot 'tb3_1': look.turns: no such field: expected one of mode, scans, still_xy_m"),
        ('from = "odometry"', 'from = "gps"', "place.from: expected one of sensor, attachment, odometry, amcl"),
        ('from = "odometry"', "", "robot 'tb3_1': place.from: expected one of sensor, attachment, odometry, amcl"),
        ("max_age_s = 0.3", "max_age_s = 0", "robot 'tb3_1': place.max_age_s: Input should be greater than 0"),
        ("max_age_s", "age", "robot 'tb3_1': place.age: no such field: expected one of from, topic, origin, std"),
        ("x = 0.4", "a = 0.4", "robot 'tb3_1': place.origin.a: no such field: expected one of x, y, yaw_rad"),
        ("xy_m = 0.01", "xy = 0.01", "robot 'tb3_1': place.std.xy: no such field: expected one of xy_m, yaw_rad"),
        ('from = "odometry"', 'from = "sensor"\nsensor = ""', "robot 'tb3_1': place.sensor: String should have"),
        ("[[robot]]", "[[robots]]\n[[robot]]", "robots: no such field: expected one of robot"),
        ("[[robot]]", "[robot]", "robot: Input should be a valid list"),
        ("[[robot]]", "[[robot]", "expected TOML: "),
        ("scan =", "place = 3\nscan =", "expected TOML: "),
        (FULL, "robot = [3]", "robot no. 1: expected a table"),
        (FULL, FULL + FULL, "robot: the name 'tb3_1' is given twice: expected a different name for each robot"),
    ],
)
def test_a_mistake_is_reported_by_robot_and_field(old: str, new: str, line: str) -> None:
    assert old in FULL
    with pytest.raises(InvalidRobots) as refused:
        load(FULL.replace(old, new, 1))
    assert any(line in reported for reported in str(refused.value).splitlines()), str(refused.value)


def test_a_name_that_ros_could_not_have_needs_a_namespace() -> None:
    odd = SHORT.replace("tb3_1", "tb3.1")
    with pytest.raises(InvalidRobots, match=r"robot 'tb3\.1': namespace: expected one"):
        load(odd)
    assert load(odd + 'namespace = "tb3_1"')[0].scan_topic == "tb3_1/scan"
