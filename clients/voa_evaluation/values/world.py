"""Scenarios of the fleet's objects for the mathematics, with the spread that every evaluated object has."""

import numpy as np

from voa_assets import lidar_presets
from voa_core.displacements import Spread
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import defaults, rule_of
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace
from voa_evaluation.values.setting import SPREAD_XY_M, SPREAD_YAW_RAD
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import GivenScores


def scenario_of(target: FleetObject, rule: str) -> Scenario:
    """Build an object's scenario under an update rule with its defaults, with the evaluation's spread.

    `margin` shares the belief among the nearest poses where a scan matches none, as in the experiments of the paper.

    Args:
        target: the object.
        rule: name of the update rule.

    Raises:
        FleetError: the scenario's lidar is not known, or lacks fields.
        UnknownName: there is no such rule.
    """
    lidar = _lidar_of(target)
    poses = _poses_of(target)
    parameters = defaults(rule, lidar, spread=True)
    if target.scenario.update.no_return_m is not None:
        parameters["no_return_m"] = target.scenario.update.no_return_m
    box = target.scenario.workspace
    return Scenario(
        poses=poses,
        table=_table_of(target),
        sensors=tuple(
            SensorConfiguration(each.name, each.x, each.y, each.yaw_rad, each.height_m, each.cost)
            for each in target.scenario.sensors
        ),
        predictor=predictor_of_mesh(Object.from_arrays(target.mesh.vertices, target.mesh.faces), poses, lidar),
        rule=rule_of(rule, lidar, **parameters),
        policy=UpdatePolicy("nearest" if rule == "margin" else "reject"),
        prior=Belief.uniform(len(poses)),
        workspace=None if box is None else Workspace((box.min[0], box.min[1]), (box.max[0], box.max[1])),
        min_gain=target.scenario.min_gain,
        spread=Spread(SPREAD_XY_M, SPREAD_YAW_RAD),
        seed=target.name,
    )


def _lidar_of(target: FleetObject) -> LidarModel:
    lidar, presets = target.scenario.lidar, lidar_presets()
    if lidar.preset is not None and lidar.preset not in presets:
        raise UnknownName("lidar preset", lidar.preset, list(presets))
    values = ({} if lidar.preset is None else presets[lidar.preset]) | lidar.model_dump(exclude_none=True)
    try:
        grid = BeamGrid(values["beams"], values["angle_min"], values["angle_increment"])
        limits = values["range_min"], values["range_max"]
        noise = values["noise_m"], values["noise_ratio"], values["dropout"]
        return LidarModel(grid, *limits, values.get("height_m"), values["zero"], *noise)
    except KeyError as error:
        raise InvalidObject(f"lidar: expected {error.args[0]} in the scenario or its preset, got none") from error


def _poses_of(target: FleetObject) -> PoseSet:
    exact = [scenario_pose(target, name) for name in target.poses]
    return PoseSet.from_arrays(
        target.poses, [pose.position for pose in exact], [pose.quaternion_wxyz for pose in exact]
    )


def _table_of(target: FleetObject) -> GraspTable:
    scores, poses = target.scenario.scores, len(target.poses)
    if isinstance(scores, GivenScores):
        return GraspTable.of_probabilities(target.grasps, np.array(scores.probabilities), poses)
    return GraspTable.of_successes(target.grasps, np.array(scores.successes), scores.attempts, poses)
