"""The bench: the same drops, whatever was run before."""

from dataclasses import replace

import numpy as np
import pytest

from voa_fleet.episodes.bench import CLUTTER, Bench, make_bench, spread_of, stated_by
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import lidar_geometry, true_ranges
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty, Spread
from voa_msgs.priors import Prior

IMPERFECTIONS = replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=0.05, robot_xy_m=0.01)


@pytest.fixture(scope="module")
def bench(mug: FleetObject) -> Bench:
    return make_bench(mug, IMPERFECTIONS, 3, VirtualClock(), "robot")


def run(bench: Bench, index: int) -> tuple[str, list[float | None], tuple[float, ...]]:
    prepared = bench.prepare(index)
    lying = bench.scene.world.object_pose(bench.scene.data)
    assert lying == prepared.drop.place
    prepared.robot.drive_to(bench.scene.world.object.scenario.sensors[2])
    return prepared.drop.pose, prepared.robot.take_scan().ranges, (*lying.position, *lying.quaternion_wxyz)


def test_a_drop_depends_on_seed_and_index_alone(bench: Bench, mug: FleetObject) -> None:
    first = run(bench, 4)
    bench.prepare(1).arm.attempt("TD0")
    assert run(bench, 4) == first
    assert run(make_bench(mug, IMPERFECTIONS, 3, VirtualClock(), "other"), 4) == first
    assert run(bench, 5) != first


def test_robot_and_arm_begin_where_they_wait(bench: Bench) -> None:
    before = bench.prepare(0).robot.pose()
    bench.prepare(0).robot.drive_to(bench.scene.world.object.scenario.sensors[0])
    assert bench.prepare(1).robot.pose() == before


def test_poses_come_as_often_as_the_prior_says(bench: Bench, mug: FleetObject) -> None:
    def counts(prior: Prior | None) -> list[int]:
        target = replace(mug, scenario=mug.scenario.model_copy(update={"prior": prior}))
        one = make_bench(target, Imperfections(), 1, VirtualClock(), "robot")
        truths = [one.prepare(index).drop.pose for index in range(120)]
        return [truths.count(pose) for pose in target.poses]

    assert min(counts(None)) > 6  # 20 each on average, standard deviation 4.1
    assert counts([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) == [0, 0, 120, 0, 0, 0]


def test_an_honest_robot_states_its_error() -> None:
    assert stated_by(Imperfections()) is None
    assert stated_by(Imperfections(robot_xy_m=0.02)) == PoseUncertainty(xy_m=0.02)


@pytest.mark.parametrize(("what", "changed"), [("none", 0), ("wall", 50), ("box", 10)])
def test_clutter_is_in_view(mug: FleetObject, what: str, changed: int) -> None:
    room = Imperfections.of_lds_01()
    lidar, sensor = lidar_geometry(mug.scenario.lidar), mug.scenario.sensors[1]
    seen = []
    for clutter in ((), CLUTTER[what]()):
        scene = make_bench(mug, replace(room, clutter=(*room.clutter, *clutter)), 0, VirtualClock(), "robot").scene
        seen.append(true_ranges(scene.world, scene.data, lidar, sensor))
    differing = int(np.count_nonzero(seen[0] != seen[1]))
    assert differing >= changed
    assert (differing == 0) == (what == "none")


@pytest.mark.parametrize(
    ("xy_m", "yaw_rad", "spread"),
    [
        (0.0, 0.0, None),
        (0.005, 0.0, Spread(xy_m=0.005)),
        (0.0, 0.05, Spread(yaw_rad=0.05)),
        (0.005, 0.05, Spread(xy_m=0.005, yaw_rad=0.05)),
    ],
)
def test_the_spread_of_a_world_is_that_of_its_drops(xy_m: float, yaw_rad: float, spread: Spread | None) -> None:
    assert spread_of(replace(Imperfections(), object_xy_m=xy_m, object_yaw_rad=yaw_rad)) == spread
