"""The stage: the same drops, whatever was played before."""

from dataclasses import replace

import numpy as np
import pytest

from voa_fleet.devices.clocks import VirtualClock
from voa_fleet.episodes.stage import CLUTTER, Stage, make_stage, shares, stated_by
from voa_fleet.errors import InvalidObject
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import lidar_geometry, true_ranges
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.priors import PoseModelPrior, Prior

FLAWS = replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=0.05, robot_xy_m=0.01)


@pytest.fixture(scope="module")
def stage(mug: FleetObject) -> Stage:
    return make_stage(mug, FLAWS, 3, VirtualClock(), "robot")


def played(stage: Stage, index: int) -> tuple[str, list[float | None], tuple[float, ...]]:
    drop = stage.drop(index)
    lying = stage.scene.world.object_pose(stage.scene.data)
    drop.robot.drive_to(stage.scene.world.object.scenario.sensors[2])
    return drop.truth, drop.robot.take_scan().ranges, (*lying.position, *lying.quaternion_wxyz)


def test_a_drop_depends_on_seed_and_index_alone(stage: Stage, mug: FleetObject) -> None:
    first = played(stage, 4)
    stage.drop(1).arm.attempt("TD0")
    assert played(stage, 4) == first
    assert played(make_stage(mug, FLAWS, 3, VirtualClock(), "other"), 4) == first
    assert played(stage, 5) != first


def test_robot_and_arm_begin_where_they_wait(stage: Stage) -> None:
    before = stage.drop(0).robot.pose()
    stage.drop(0).robot.drive_to(stage.scene.world.object.scenario.sensors[0])
    assert stage.drop(1).robot.pose() == before


def test_poses_come_as_often_as_the_prior_says(stage: Stage, mug: FleetObject) -> None:
    def counts(prior: Prior | None) -> list[int]:
        thing = replace(mug, scenario=mug.scenario.model_copy(update={"prior": prior}))
        one = make_stage(thing, Imperfections(), 1, VirtualClock(), "robot")
        truths = [one.drop(index).truth for index in range(120)]
        return [truths.count(pose) for pose in thing.poses]

    assert min(counts(None)) > 6  # 20 each on average, standard deviation 4.1
    assert counts([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) == [0, 0, 120, 0, 0, 0]


def test_a_prior_without_shares_is_refused(mug: FleetObject) -> None:
    model = PoseModelPrior.model_validate({"form": "pose_model", "categories": [{"pose": "U_0", "probability": 1.0}]})
    thing = replace(mug, scenario=mug.scenario.model_copy(update={"prior": model}))
    with pytest.raises(InvalidObject, match="a share per pose, got form 'pose_model'"):
        shares(thing)


def test_an_honest_robot_states_its_error() -> None:
    assert stated_by(Imperfections()) is None
    assert stated_by(Imperfections(robot_xy_m=0.02)) == PoseUncertainty(xy_m=0.02)


@pytest.mark.parametrize(("what", "changed"), [("none", 0), ("wall", 50), ("box", 10)])
def test_clutter_is_in_view(mug: FleetObject, what: str, changed: int) -> None:
    room = Imperfections.of_lds_01()
    lidar, sensor = lidar_geometry(mug.scenario.lidar), mug.scenario.sensors[1]
    seen = []
    for clutter in ((), CLUTTER[what]()):
        scene = make_stage(mug, replace(room, clutter=(*room.clutter, *clutter)), 0, VirtualClock(), "robot").scene
        seen.append(true_ranges(scene.world, scene.data, lidar, sensor))
    differing = int(np.count_nonzero(seen[0] != seen[1]))
    assert differing >= changed
    assert (differing == 0) == (what == "none")
