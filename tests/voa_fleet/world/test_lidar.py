"""The simulated lidar sees what the mesh's exact cut predicts, and errs as its imperfections say."""

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from tests.voa_assets.mugs import scenario_of
from voa_assets import path
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.frames import Floats
from voa_fleet.world.imperfections import Clutter, Imperfections, room
from voa_fleet.world.lidar import lidar_geometry, scan_message, true_ranges, with_errors
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import OBJECTS, FleetObject
from voa_fleet.world.scene import World, build_world
from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar

EAST = SensorPose(x=0.4, y=0.0, yaw_rad=math.pi)


def look(world: World, pose: str, sensor: SensorPose) -> Floats:
    target = world.object
    data = mujoco.MjData(world.model)
    world.put_object(data, scenario_pose(target, pose))
    mujoco.mj_kinematics(world.model, data)
    return true_ranges(world, data, lidar_geometry(target.scenario.lidar), sensor)


@pytest.mark.parametrize("name", OBJECTS)
def test_without_faults_a_scan_is_the_predicted_one(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    world = build_world(target, arm=False, robots=("robot",))
    core = scenario_of(path(f"{name}/scenario.json"))
    for sensor in core.sensors[::3]:
        predicted = core.predictor.predict(sensor).dense()
        for row, pose in enumerate(target.poses):
            measured = look(
                world, pose, SensorPose(x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m)
            )
            assert (np.isfinite(measured) == np.isfinite(predicted[row])).all()
            seen = np.isfinite(measured)
            # A beam that runs along a facet may end on either side of its edge.
            apart = np.abs(measured[seen] - predicted[row][seen])
            assert np.sort(apart)[:-1].max() < 1e-6
            assert seen.sum() >= 4


def test_a_wall_is_seen_behind_and_a_box_hides_the_object(mug: FleetObject) -> None:
    free = look(build_world(mug, arm=False), "U_180", EAST)
    walls = look(build_world(mug, arm=False, clutter=room(2.0)), "U_180", EAST)
    box = Clutter("box", (0.2, 0.0), (0.02, 0.3, 0.2))
    hidden = look(build_world(mug, arm=False, clutter=(box,)), "U_180", EAST)
    assert free[0] == pytest.approx(0.36, abs=1e-3)
    assert math.isinf(free[180])
    assert walls[0] == free[0]
    assert walls[180] == pytest.approx(2.0 - 0.01 - 0.4, abs=1e-6)
    assert hidden[0] == pytest.approx(0.4 - 0.21, abs=1e-6)


def test_nothing_is_seen_beyond_the_range(mug: FleetObject) -> None:
    far = look(build_world(mug, arm=False, clutter=room(3.4)), "U_180", EAST)
    assert far[180] == pytest.approx(3.4 - 0.01 - 0.4, abs=1e-6)
    assert math.isinf(far[0 + 135])  # towards a corner it is more than 3.5 m
    assert np.isfinite(far).sum() < 360


def test_the_height_of_the_sensor_counts(mug: FleetObject) -> None:
    above = SensorPose(x=0.4, y=0.0, yaw_rad=math.pi, height_m=0.097)
    assert np.isinf(look(build_world(mug, arm=False), "U_180", above)).all()


def test_the_arm_is_seen_and_the_robot_is_not(mug: FleetObject) -> None:
    world = build_world(mug, robots=("robot",))
    data = mujoco.MjData(world.model)
    world.put_object(data, scenario_pose(mug, "U_0"))
    data.mocap_pos[world.mocaps[0]] = [-0.25, 0.0, 0.05]
    mujoco.mj_kinematics(world.model, data)
    ranges = true_ranges(world, data, lidar_geometry(mug.scenario.lidar), SensorPose(x=-0.25, y=0.0, yaw_rad=0.0))
    assert ranges[180] == pytest.approx(0.55 - 0.25 - 0.06, abs=1e-3)


def test_faults_come_as_often_and_as_large_as_they_should(mug: FleetObject) -> None:
    lidar = lidar_geometry(mug.scenario.lidar)
    near, far = np.full(lidar.beams, 0.4), np.full(lidar.beams, 2.0)
    imperfections = Imperfections(range_noise_m=0.003, range_noise_ratio=0.03)
    rng = np.random.default_rng(0)
    close = np.array([with_errors(near, lidar, imperfections, rng) for _ in range(100)])
    away = np.array([with_errors(far, lidar, imperfections, rng) for _ in range(100)])
    assert close.std() == pytest.approx(0.003, rel=0.03)
    assert away.std() == pytest.approx(0.06, rel=0.03)
    lossy = np.array([with_errors(near, lidar, Imperfections(beam_loss=0.1), rng) for _ in range(100)])
    assert (lossy == 0.0).mean() == pytest.approx(0.1, abs=0.01)
    assert (lossy[lossy > 0.0] == 0.4).all()


def test_a_lost_packet_takes_six_beams(mug: FleetObject) -> None:
    lidar = lidar_geometry(mug.scenario.lidar)
    rng = np.random.default_rng(0)
    scans = [with_errors(np.full(360, 0.4), lidar, Imperfections(packet_loss=0.2), rng) for _ in range(50)]
    packets = np.array(scans).reshape(50, 60, 6)
    lost = packets == 0.0
    assert (lost.all(axis=2) == lost.any(axis=2)).all()
    assert lost.mean() == pytest.approx(0.2, abs=0.02)


def test_what_is_nothing_too_near_or_too_far_is_zero(mug: FleetObject) -> None:
    lidar = lidar_geometry(mug.scenario.lidar)
    ranges = np.full(360, 0.4)
    ranges[:3] = [np.inf, 0.1, 3.6]
    measured = with_errors(ranges, lidar, Imperfections(), np.random.default_rng(0))
    assert measured[:3].tolist() == [0.0, 0.0, 0.0]
    assert (measured[3:] == 0.4).all()


def test_ranges_are_whole_millimetres_where_the_lidar_says_so(mug: FleetObject) -> None:
    lidar = lidar_geometry(mug.scenario.lidar)
    imperfections = Imperfections(range_noise_m=0.003, resolution_m=0.001)
    measured = with_errors(np.full(360, 0.4), lidar, imperfections, np.random.default_rng(0))
    np.testing.assert_allclose(measured * 1e3, np.round(measured * 1e3), rtol=0.0, atol=1e-9)
    assert len(set(measured)) > 5


def test_the_same_errors_befall_whatever_is_seen(mug: FleetObject) -> None:
    lidar, imperfections = lidar_geometry(mug.scenario.lidar), Imperfections.of_lds_01()
    first = with_errors(np.full(360, 0.3), lidar, imperfections, np.random.default_rng(4))
    second = with_errors(np.full(360, 0.4), lidar, imperfections, np.random.default_rng(4))
    assert ((first == 0.0) == (second == 0.0)).all()
    both = first > 0.0
    np.testing.assert_allclose(first[both] - 0.3, second[both] - 0.4, rtol=0.0, atol=1e-9)


def test_a_scan_goes_out_raw() -> None:
    assert scan_message(np.array([0.0, 0.1234567, 2.0])).ranges == [0.0, 0.123457, 2.0]


def test_a_lidar_may_be_stated_in_full_and_must_be_complete() -> None:
    own = Lidar(beams=4, angle_min=0.0, angle_increment=1.5, range_min=0.1, range_max=2.0, height_m=0.1)
    assert lidar_geometry(own).angles.tolist() == [0.0, 1.5, 3.0, 4.5]
    assert lidar_geometry(Lidar(preset="lds-01", height_m=0.05, range_max=1.0)).range_max == 1.0
    with pytest.raises(InvalidObject, match="expected beams"):
        lidar_geometry(Lidar(height_m=0.1))
    with pytest.raises(UnknownName, match="lds-01"):
        lidar_geometry(Lidar(preset="lds-99", height_m=0.1))


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Imperfections(range_noise_m=-0.1), "range_noise_m"),
        (lambda: Imperfections(beam_loss=1.5), "beam_loss"),
        (lambda: Imperfections(robot_xy_m=math.nan), "robot_xy_m"),
    ],
)
def test_imperfections_that_cannot_be_are_refused(make: Callable[[], Imperfections], name: str) -> None:
    with pytest.raises(InvalidObject, match=name):
        make()
