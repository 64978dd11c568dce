"""Probable mistakes of a scenario that has no grasps yet: its poses on the table, its places, and its scan plane."""

from collections.abc import Sequence

import numpy as np

from voa_core.errors import VoaError
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration as CoreSensor
from voa_core.mistakes.effort import QUICK
from voa_core.mistakes.heights import Mesh, mistakes_of_heights
from voa_core.mistakes.places import mistakes_of_places
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.lidars import LidarPreset
from voa_setup.heights import core_poses, lidar_model
from voa_setup.mesh import SetupMesh
from voa_setup.places import footprints
from voa_setup.poses import PoseSet
from voa_setup.writing import workspace_around

_RULE = "beam"


def mistakes_before_grasps(
    mesh: SetupMesh,
    poses: PoseSet,
    places: Sequence[SensorConfiguration],
    lidar: LidarPreset,
    height_m: float,
    xy_m: float,
) -> list[str]:
    """Return the probable mistakes that the service will report of the poses, the places and the scan plane.

    Args:
        mesh: of the object.
        poses: of the scenario, with its prior.
        places: of the lidar.
        lidar: its preset.
        height_m: of the scan plane.
        xy_m: standard deviation of the object's position, which widens the workspace.
    """
    core, model = core_poses(poses.poses), lidar_model(lidar, height_m)
    object_ = mesh.object_
    box = workspace_around(footprints(mesh, poses.poses), xy_m)
    (x0, y0), (x1, y1) = box["min"], box["max"]
    try:
        scenario = Scenario(
            poses=core,
            table=GraspTable.of_probabilities(["any"], np.ones((1, len(core))), len(core)),
            sensors=tuple(CoreSensor(place.name, place.x, place.y, place.yaw_rad) for place in places),
            predictor=predictor_of_mesh(object_, core, model),
            rule=rule_of(_RULE, model),
            policy=UpdatePolicy(),
            prior=Belief.of(poses.prior),
            workspace=Workspace((x0, y0), (x1, y1)),
        )
        mistakes = [
            *mistakes_of_heights(core, Mesh(object_), QUICK),
            *mistakes_of_places(scenario, object_, QUICK),
        ]
    except VoaError as error:
        return [f"The places cannot be searched for mistakes: {error}."]
    return [mistake.detail for mistake in mistakes]
