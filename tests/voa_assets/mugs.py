"""Shared by the tests of the assets: a scenario's request body as objects of the core."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from voa_assets import lidar_presets
from voa_core.displacements import Spread
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace


def lidar_of(preset: dict[str, Any], height_m: float | None = None) -> LidarModel:
    grid = BeamGrid(preset["beams"], preset["angle_min"], preset["angle_increment"])
    noise = (preset["noise_m"], preset["noise_ratio"], preset["dropout"])
    return LidarModel(grid, preset["range_min"], preset["range_max"], height_m, preset["zero"], *noise)


def object_of(file: Path) -> Object:
    mesh = trimesh.load_mesh(file, process=False)
    return Object.from_arrays(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def scenario_of(file: Path) -> Scenario:
    """`file` holds the body of POST /v1/scenarios, with the mesh's file name in place of the object's id."""
    body = json.loads(file.read_text(encoding="utf-8"))
    lidar = lidar_of(lidar_presets()[body["lidar"]["preset"]], body["lidar"]["height_m"])
    poses = PoseSet.from_arrays(
        *([pose[field] for pose in body["poses"]] for field in ("name", "position", "quaternion_wxyz"))
    )
    table = GraspTable.of_successes(
        [grasp["name"] for grasp in body["grasps"]],
        body["scores"]["successes"],
        body["scores"]["attempts"],
        len(poses),
    )
    sensors = tuple(
        SensorConfiguration(s["name"], s["x"], s["y"], s["yaw_rad"], s.get("height_m"), s.get("cost", 0.0))
        for s in body["sensors"]
    )
    update = dict(body["update"])
    policy = UpdatePolicy(update.pop("on_no_match"))
    rule = rule_of(update.pop("rule"), lidar, **update)
    box = Workspace(tuple(body["workspace"]["min"]), tuple(body["workspace"]["max"]))
    predictor = predictor_of_mesh(object_of(file.with_name(body["object"])), poses, lidar)
    spread = Spread(**body["spread"]) if "spread" in body else None
    return Scenario(
        poses,
        table,
        sensors,
        predictor,
        rule,
        policy,
        Belief.uniform(len(poses)),
        box,
        spread=spread,
        seed=body["name"],
    )
