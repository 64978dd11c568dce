"""A table-top scenario in which nothing is wrong, and ways to change it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.mistakes.effort import THOROUGH, Effort
from voa_core.mistakes.heights import Mesh, Up
from voa_core.mistakes.mistake import Mistake
from voa_core.mistakes.scenarios import mistakes_of_scenario
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace

LIDAR = LidarModel(BeamGrid(360, 0.0, math.radians(1.0)), 0.12, 3.5, 0.02, "missing", 0.01, 0.02, 0.05)
TABLE = Workspace((-0.2, -0.2), (0.2, 0.2))


def wedge() -> Object:
    """A triangular block, 0.12 x 0.06 x 0.04 m, that no turn maps onto itself; its lowest point is at z = 0."""
    outline = [(-0.06, -0.03), (0.06, -0.03), (-0.03, 0.03)]
    corners = [(x, y, z) for z in (0.0, 0.04) for x, y in outline]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    return Object.from_arrays(corners, faces)


def poses_at(*placed: tuple[float, float, float, float]) -> PoseSet:
    """Upright poses "P0", "P1", ... from x, y, z and yaw in degrees."""
    yaws = [math.radians(yaw) for *_, yaw in placed]
    quaternions = [[math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)] for yaw in yaws]
    return PoseSet.from_arrays([f"P{i}" for i in range(len(placed))], [each[:3] for each in placed], quaternions)


POSES = poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 90.0), (0.05, 0.0, 0.0, 200.0))
WEST = SensorConfiguration("W", -0.5, 0.0, 0.0)
SOUTH = SensorConfiguration("S", 0.0, -0.6, math.pi / 2)


def scenario_of(
    *,
    object_: Object | None = None,
    poses: PoseSet = POSES,
    sensors: Sequence[SensorConfiguration] = (WEST, SOUTH),
    lidar: LidarModel = LIDAR,
    workspace: Workspace | None = TABLE,
    scores: Any = None,
) -> Scenario:
    """Build the good scenario with some parts replaced."""
    names = [f"G{x}" for x in range(2 if scores is None else len(scores))]
    table = GraspTable.of_probabilities(names, scores or [[0.5] * len(poses), [0.25] * len(poses)], len(poses))
    predictor = predictor_of_mesh(object_ or wedge(), poses, lidar)
    rule = rule_of("beam", lidar)
    return Scenario(
        poses, table, tuple(sensors), predictor, rule, UpdatePolicy(), Belief.uniform(len(poses)), workspace
    )


def mistakes_of_table(
    effort: Effort = THOROUGH, object_: Object | None = None, up: Up = "+Z", **changed: Any
) -> dict[str, Mistake]:
    """Find the mistakes of the good scenario with some parts replaced, by kind."""
    mesh = Mesh(object_ or wedge(), up)
    mistakes = mistakes_of_scenario(scenario_of(object_=mesh.object_, **changed), mesh, effort)
    return {mistake.kind: mistake for mistake in mistakes}


def moved(sensor: SensorConfiguration, **changed: Any) -> SensorConfiguration:
    """Change some fields of a sensor configuration."""
    return replace(sensor, **changed)


def with_y_up(object_: Object) -> Object:
    """The mesh as a program writes it whose y axis is up: (x, y, z) becomes (x, z, -y)."""
    vertices: Floats = object_.vertices @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return Object.from_arrays(vertices, object_.faces)
