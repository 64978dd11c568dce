import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import COORDINATES, COVARIANCES, STAMPS, odometry, scan, scans
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose
from voa_ros.localisation import Localisation, lidar_pose, localisation, middle_s, robot_pose
from voa_ros.messages import LaserScan, Odometry, Pose, PoseWithCovariance, Stamp
from voa_ros.motions import Motion, composed, inverse, wrapped
from voa_ros.robot_places import AmclPlace, Mount, PlanarPose
from voa_ros.robots import load
from voa_ros.tracks import NoPose, PoseTrack, RobotPose

YAWS = st.floats(-100.0, 100.0)
MOTIONS = st.builds(Motion, st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), YAWS)


def track(*poses: tuple[float, float, float, float], max_age_s: float = 0.2) -> PoseTrack:
    own = PoseTrack(max_age_s)
    for pose in poses:
        own.receive(RobotPose(*pose), 0.0)
    return own


def pose_of(own: PoseTrack, at_s: float) -> tuple[float, float, float]:
    pose = own.at(at_s)
    assert isinstance(pose, RobotPose), pose
    assert pose.at_s == at_s
    return (pose.x, pose.y, pose.yaw_rad)


def reason(answer: object) -> str:
    assert isinstance(answer, NoPose), answer
    return answer.reason


def close(one: UncertainSensorPose | NoPose, x: float, y: float, yaw_rad: float) -> bool:
    assert isinstance(one, UncertainSensorPose), one
    return (one.x, one.y) == pytest.approx((x, y), abs=1e-6) and abs(wrapped(one.yaw_rad - yaw_rad)) < 1e-6


def test_between_two_poses_is_the_straight_line() -> None:
    own = track((10.0, 0.0, 0.0, 0.0), (10.1, 1.0, 2.0, 0.4))
    assert pose_of(own, 10.025) == pytest.approx((0.25, 0.5, 0.1))
    assert pose_of(own, 10.1) == pytest.approx((1.0, 2.0, 0.4))


@pytest.mark.parametrize(
    ("before", "after", "middle"), [(3.1, -3.1, math.pi), (-3.1, 3.0, 3.0915927), (6.4, 0.0, 0.0584)]
)
def test_a_turn_goes_the_short_way(before: float, after: float, middle: float) -> None:
    _, _, yaw_rad = pose_of(track((0.0, 0.0, 0.0, before), (0.1, 0.0, 0.0, after)), 0.05)
    assert wrapped(yaw_rad - middle) == pytest.approx(0.0, abs=1e-4)


def test_past_the_end_the_nearest_pose_holds_for_a_while() -> None:
    own = track((10.0, 1.0, 2.0, 3.0))
    assert pose_of(own, 10.19) == pose_of(own, 9.81) == (1.0, 2.0, 3.0)
    assert reason(own.at(13.2)) == "the nearest pose is 3.2 s older than the scan: expected at most 0.2 s"
    assert reason(own.at(9.0)) == "the nearest pose is 1 s newer than the scan: expected at most 0.2 s"


def test_over_a_long_gap_there_is_no_line() -> None:
    own = track((10.0, 0.0, 0.0, 0.0), (11.0, 1.0, 0.0, 0.0))
    assert pose_of(own, 10.1) == (0.0, 0.0, 0.0)
    assert pose_of(own, 10.9) == (1.0, 0.0, 0.0)
    assert "0.5 s" in reason(own.at(10.5))


def test_an_empty_track_is_said() -> None:
    assert reason(track().at(0.0)) == "no pose was received yet"


@given(st.permutations(range(8)), st.floats(0.0, 0.14))
def test_the_order_of_arrival_does_not_matter(order: list[int], at_s: float) -> None:
    poses = [(0.02 * step, float(step), 0.0, 0.0) for step in range(8)]
    assert pose_of(track(*(poses[step] for step in order)), at_s) == pose_of(track(*poses), at_s)


def test_of_two_poses_with_one_stamp_the_last_received_counts() -> None:
    assert pose_of(track((1.0, 1.0, 0.0, 0.0), (1.0, 2.0, 0.0, 0.0)), 1.0) == (2.0, 0.0, 0.0)


def test_a_clock_that_was_set_back_starts_a_new_track() -> None:
    own = track((100.0, 1.0, 0.0, 0.0), (3.0, 2.0, 0.0, 0.0))
    assert pose_of(own, 3.0) == (2.0, 0.0, 0.0)
    assert "97 s older" in reason(own.at(100.0))


def test_old_poses_are_forgotten() -> None:
    own = PoseTrack(0.2, most=10)
    for step in range(1_000):
        own.receive(RobotPose(0.01 * step, 0.0, 0.0, 0.0), 0.0)
    assert "newer" in reason(own.at(9.0))
    own.receive(RobotPose(9.85, 5.0, 0.0, 0.0), 0.0)  # late, and older than all that are kept
    assert pose_of(own, 9.9) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("stamp", "scan_time", "middle"),
    [
        ("first_ray", 0.25, 10.125),
        ("after_revolution", 0.25, 9.875),
        ("first_ray", math.inf, 10.0),
        ("after_revolution", math.nan, 10.0),
        ("after_revolution", -0.25, 10.0),
        ("first_ray", 60.0, 10.0),
    ],
)
def test_the_time_of_a_scan_is_the_middle_of_its_revolution(stamp: Any, scan_time: float, middle: float) -> None:
    assert middle_s(replace(scan(1.0, at=10.0), scan_time=scan_time), stamp) == pytest.approx(middle, abs=1e-9)


@given(scans(most=1), st.sampled_from(["first_ray", "after_revolution"]))
def test_any_scan_has_a_time(message: LaserScan, stamp: Any) -> None:
    assert abs(middle_s(message, stamp) - message.stamp.seconds) <= 1.0


@given(MOTIONS, MOTIONS, MOTIONS)
def test_planar_motions_are_a_group(one: Motion, two: Motion, three: Motion) -> None:
    for left, right in [
        (composed(composed(one, two), three), composed(one, composed(two, three))),
        (composed(one, inverse(one)), Motion(0.0, 0.0, 0.0)),
        (composed(inverse(one), one), Motion(0.0, 0.0, 0.0)),
    ]:
        assert (left.x, left.y) == pytest.approx((right.x, right.y), abs=1e-9)
        assert wrapped(left.yaw_rad - right.yaw_rad) == pytest.approx(0.0, abs=1e-9)


def test_the_lidars_pose_worked_out_by_hand() -> None:
    robot = RobotPose(0.0, 1.0, 0.0, math.pi / 2)
    pose = lidar_pose(robot, Mount(x=0.1, yaw_rad=0.1, height_m=0.2), PlanarPose(x=0.0, y=5.0, yaw_rad=math.pi / 2))
    # the robot is 1 m along the frame's +x, which is the world's +y; it looks back along the world's -x
    assert close(pose, -0.1, 6.0, math.pi + 0.1)
    assert (pose.height_m, pose.std) == (0.2, None)


def test_variances_become_standard_deviations() -> None:
    covariance = [0.0] * 36
    covariance[0], covariance[7], covariance[35] = 0.0001, 0.0003, 0.0004
    robot = robot_pose(PoseWithCovariance(Stamp(), "map", Pose.planar(0.0, 0.0, 0.0), tuple(covariance)))
    centred = lidar_pose(robot, Mount(), PlanarPose()).std
    assert centred is not None
    assert (centred.xy_m, centred.yaw_rad) == pytest.approx((math.sqrt(0.0002), 0.02))
    off = lidar_pose(robot, Mount(x=0.3, y=0.4), PlanarPose(yaw_rad=1.0)).std
    assert off is not None
    assert (off.xy_m, off.yaw_rad) == pytest.approx((math.sqrt(0.0002 + 0.0004 * 0.25 / 2), 0.02))
    std = PoseUncertainty(xy_m=0.5)
    assert lidar_pose(robot, Mount(), PlanarPose(), std).std == std


POSES = st.builds(Pose.planar, COORDINATES, COORDINATES, YAWS)
SOME_ODOMETRY = st.builds(
    Odometry, st.builds(Stamp, st.integers(0, 9)), st.just("odom"), st.just("base"), POSES, COVARIANCES
)
SOME_AMCL = st.builds(PoseWithCovariance, st.builds(Stamp, st.integers(0, 9)), st.just("map"), POSES, COVARIANCES)
MOUNTS = st.builds(Mount, x=COORDINATES, y=COORDINATES, yaw_rad=YAWS)
ORIGINS = st.builds(PlanarPose, x=COORDINATES, y=COORDINATES, yaw_rad=YAWS)


@given(SOME_AMCL, MOUNTS, ORIGINS)
def test_any_pose_becomes_a_message_that_passes(message: PoseWithCovariance, mount: Mount, origin: PlanarPose) -> None:
    pose = lidar_pose(robot_pose(message), mount, origin)
    assert UncertainSensorPose.model_validate_json(pose.model_dump_json()) == pose


def located(place: str) -> Localisation:
    lidar = "lidar = { x = 0.1 }"
    (robot,) = load(f'[[robot]]\nname = "a"\nsession = "s"\n{lidar}\n[robot.place]\n{place}')
    own = localisation(robot)
    assert own is not None
    return own


def amcl(x: float, y: float, yaw_rad: float, at: float, variance: float = 0.0) -> PoseWithCovariance:
    return PoseWithCovariance(Stamp.of(at), "map", Pose.planar(x, y, yaw_rad), (variance,) + (0.0,) * 35)


class Located:
    """A localisation whose messages arrive as soon as they are stamped, unless it is said otherwise."""

    def __init__(self, place: str) -> None:
        self.own = located(place)

    def odometry(self, message: Odometry, received_s: float | None = None) -> None:
        self.own.receive_odometry(message, message.stamp.seconds if received_s is None else received_s)

    def amcl(self, message: PoseWithCovariance, received_s: float | None = None) -> None:
        self.own.receive_amcl(message, message.stamp.seconds if received_s is None else received_s)

    def at(self, at_s: float) -> UncertainSensorPose | NoPose:
        return self.own.at(at_s, at_s)


def test_odometry_is_carried_into_the_world() -> None:
    own = Located('from = "odometry"\norigin = { x = 2.0, yaw_rad = 1.5707963267948966 }')
    assert reason(own.at(1.0)) == "no odometry was received yet"
    own.odometry(replace(odometry(1.0, 0.0, 0.0, at=1.0), covariance=(0.5,) * 36))
    own.odometry(odometry(1.2, 0.0, 0.0, at=1.1))
    pose = own.at(1.05)
    assert close(pose, 2.0, 1.2, math.pi / 2)
    assert isinstance(pose, UncertainSensorPose)
    assert pose.std is None  # an odometry's covariance is not about the world


@pytest.mark.parametrize("place", ['from = "sensor"\nsensor = "E"', 'from = "attachment"'])
def test_a_place_that_is_named_needs_no_localisation(place: str) -> None:
    assert localisation(load(f'[[robot]]\nname = "a"\nsession = "s"\n[robot.place]\n{place}')[0]) is None


def test_amcl_is_carried_on_by_odometry() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(5.0, 5.0, math.pi / 2, at=1.0))
    assert "no AMCL pose" in reason(own.at(1.0))
    own.amcl(amcl(1.0, 0.0, 0.0, at=1.0, variance=0.0002))
    assert close(own.at(1.0), 1.1, 0.0, 0.0)
    own.odometry(odometry(5.0, 5.5, math.pi, at=1.1))  # half a metre ahead, then turned left
    pose = own.at(1.1)
    assert close(pose, 1.5, 0.1, math.pi / 2)
    assert isinstance(pose, UncertainSensorPose)
    assert pose.std is not None
    assert (pose.std.xy_m, pose.std.yaw_rad) == pytest.approx((0.01, 0.0))


def test_amcl_waits_for_the_odometry_of_its_time() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(0.0, 0.0, 0.0, at=1.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=1.05))
    assert "no AMCL pose" in reason(own.at(1.0))
    own.odometry(odometry(0.2, 0.0, 0.0, at=1.1))
    assert close(own.at(1.1), 3.2, 0.0, 0.0)  # 3.1 is the base: AMCL met the odometry half way


def test_a_robot_that_stands_still_keeps_amcls_old_pose() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(0.0, 0.0, 0.0, at=0.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=0.0))
    for step in range(1, 5_000):
        own.odometry(odometry(0.0, 0.0, 0.0, at=0.05 * step))
    assert close(own.at(249.9), 3.1, 0.0, 0.0)


def test_amcl_that_is_gone_is_not_carried_without_end() -> None:
    own = Located('from = "amcl"\nmax_carried_m = 0.5')
    own.odometry(odometry(0.0, 0.0, 0.0, at=1.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=1.0))
    own.odometry(odometry(0.6, 0.0, 0.0, at=1.1))
    assert reason(own.at(1.1)) == "the robot has driven 0.6 m since AMCL's newest pose: expected at most 0.5 m"


def test_a_latched_amcl_pose_is_where_the_robot_is_now() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(5.0, 0.0, 0.0, at=1_000.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=1.0), received_s=1_000.0)
    assert close(own.at(1_000.0), 3.1, 0.0, 0.0)


def test_a_latched_amcl_pose_that_comes_first_waits_for_the_odometry() -> None:
    own = Located('from = "amcl"')
    own.amcl(amcl(3.0, 0.0, 0.0, at=1.0), received_s=1_000.0)
    assert reason(own.at(1_000.0)) == "no odometry was received yet"
    own.odometry(odometry(5.0, 0.0, 0.0, at=1_000.0))
    assert close(own.at(1_000.0), 3.1, 0.0, 0.0)


def test_an_amcl_pose_of_a_clock_that_is_ahead_is_not_awaited() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(5.0, 0.0, 0.0, at=10.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=13.0), received_s=10.0)
    assert close(own.at(10.0), 3.1, 0.0, 0.0)


@pytest.mark.parametrize("back_s", [1.0, 3.0, 99.0])
def test_a_clock_that_is_set_back_keeps_amcls_pose(back_s: float) -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(0.0, 0.0, 0.0, at=100.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=100.0))
    own.odometry(odometry(0.05, 0.0, 0.0, at=100.0 - back_s), received_s=100.05)
    assert close(own.own.at(100.0 - back_s, 100.05), 3.15, 0.0, 0.0)


def test_a_simulation_whose_odometry_starts_again_elsewhere_needs_a_new_pose_of_amcl() -> None:
    own = Located('from = "amcl"')
    own.odometry(odometry(2.0, 0.0, 0.0, at=100.0))
    own.amcl(amcl(3.0, 0.0, 0.0, at=100.0))
    own.amcl(amcl(3.2, 0.0, 0.0, at=100.1))  # awaits an odometry that never comes
    own.odometry(odometry(0.0, 0.0, 0.0, at=1.0), received_s=103.0)
    assert "no AMCL pose" in reason(own.own.at(1.0, 103.0))
    own.amcl(amcl(0.5, 0.0, 0.0, at=1.0), received_s=103.0)
    assert close(own.own.at(1.0, 103.0), 0.6, 0.0, 0.0)


@given(st.lists(st.one_of(SOME_ODOMETRY, SOME_AMCL), max_size=12), MOUNTS, ORIGINS, STAMPS)
def test_whatever_is_received_there_is_a_pose_or_a_reason(
    received: list[Odometry | PoseWithCovariance], mount: Mount, origin: PlanarPose, at: Stamp
) -> None:
    place = AmclPlace.model_validate({"from": "amcl", "origin": origin, "max_carried_m": 1e6})
    own = Localisation(place, mount)
    for message in received:
        if isinstance(message, Odometry):
            own.receive_odometry(message, message.stamp.seconds)
        else:
            own.receive_amcl(message, message.stamp.seconds)
    for at_s in [*range(10), at.seconds]:
        for stamped in (float(at_s), None):
            answer = own.at(stamped, float(at_s))
            assert isinstance(answer, UncertainSensorPose) or answer.reason


# --- clocks that say nothing


def test_a_stamp_that_says_nothing_is_matched_with_the_newest_pose() -> None:
    own = Located('from = "odometry"')
    own.odometry(odometry(1.0, 0.0, 0.0, at=10.0))
    own.odometry(odometry(2.0, 0.0, 0.0, at=10.1))
    assert close(own.own.at(None, 10.3), 2.1, 0.0, 0.0)
    assert reason(own.own.at(None, 11.1)) == (
        "the scan's stamp does not fit the clock of the odometry, and the newest odometry came 1 s before the scan: "
        "expected at most 0.4 s"
    )


@pytest.mark.parametrize("back_s", [1.0, 3.0, 100.0, -1.0, -3.0])
def test_a_scan_of_another_clock_is_matched_with_the_newest_pose(back_s: float) -> None:
    own = Located('from = "odometry"')
    for step in range(200):
        own.odometry(odometry(0.05 * step, 0.0, 0.0, at=200.0 + 0.05 * step))
    assert close(own.own.at(209.95 - back_s, 209.95), 10.05, 0.0, 0.0)


@pytest.mark.parametrize("late_s", [0.0, 0.2, 0.4])
def test_a_scan_that_comes_a_little_late_is_matched_by_its_stamp(late_s: float) -> None:
    own = Located('from = "odometry"')
    for step in range(40):
        own.odometry(odometry(0.05 * step, 0.0, 0.0, at=0.05 * step))
    assert close(own.own.at(1.0, 1.0 + late_s), 1.1, 0.0, 0.0)


def test_one_scan_that_comes_very_late_is_matched_by_its_stamp() -> None:
    own = Located('from = "odometry"')
    for step in range(40):
        own.odometry(odometry(0.05 * step, 0.0, 0.0, at=0.05 * step))
        if step % 4 == 0:
            own.at(0.05 * step)
    assert close(own.own.at(1.85, 2.75), 1.95, 0.0, 0.0)


def test_odometry_whose_clock_stands_is_matched_as_it_comes() -> None:
    own = Located('from = "odometry"')
    own.odometry(odometry(0.0, 0.0, 0.0, at=9.95))
    for step in range(100):
        now_s = 10.0 + 0.05 * step
        own.odometry(odometry(0.05 * step, 0.0, 0.0, at=10.0), received_s=now_s)
        assert close(own.at(now_s), 0.05 * step + 0.1, 0.0, 0.0)


@pytest.mark.parametrize("moving", [0.0, 1.0])
@pytest.mark.parametrize("back_s", [1.0, 3.0, 30.0])
def test_a_clock_that_is_set_back_onto_its_own_stamps(moving: float, back_s: float) -> None:
    """Simulations, and clocks set back by whole periods, write the stamps of before once more."""
    own = Located('from = "odometry"')
    for step in range(800):
        own.odometry(odometry(0.0, 0.0, 0.0, at=round(0.05 * step, 3)))
    for step in range(800, 900):
        now_s = 0.05 * step
        own.odometry(odometry(moving * now_s, 1.0, 0.0, at=round(now_s - back_s, 3)), received_s=now_s)
        assert close(own.own.at(now_s - back_s, now_s), moving * now_s + 0.1, 1.0, 0.0)
        assert close(own.own.at(None, now_s), moving * now_s + 0.1, 1.0, 0.0)


def test_poses_that_arrive_twice_are_no_clock_that_was_set_back() -> None:
    own = Located('from = "odometry"')
    for step in range(100):
        for delay in (0, 6):  # another bridge, 0.3 s slower
            if step >= delay:
                at_s = 0.05 * (step - delay)
                own.odometry(odometry(at_s, 0.0, 0.0, at=at_s), received_s=0.05 * step)
        if step >= 10:
            assert close(own.at(0.05 * step), 0.05 * step + 0.1, 0.0, 0.0)
            assert close(own.own.at(None, 0.05 * step), 0.05 * step + 0.1, 0.0, 0.0)


def test_a_late_pose_is_not_the_newest() -> None:
    own = PoseTrack(0.2, most=4)
    for step in (0, 1, 2, 4, 5, 3.5, 4.5):
        own.receive(RobotPose(0.02 * step, float(step), 0.0, 0.0), 0.02 * step)
    latest = own.latest(0.1)
    assert isinstance(latest, RobotPose)
    assert latest.x == 5.0
