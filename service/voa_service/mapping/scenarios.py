"""Scenarios: from a message to the mathematics."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from voa_core.cutting import Contours
from voa_core.displacements import Spread
from voa_core.errors import InvalidInput, NoMesh
from voa_core.grasps import GraspTable
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Remember
from voa_core.scenario import Scenario
from voa_core.workspace import Workspace
from voa_msgs import lidars, scenarios
from voa_service.mapping.beliefs import prior_of
from voa_service.mapping.lidars import filled_lidar, lidar_model
from voa_service.mapping.predictions import check_predictable, predicted_ranges, stacked
from voa_service.mapping.rules import InstalledRules, filled_update, update_policy, update_rule
from voa_service.mapping.sensors import sensor_of


def filled_in(
    request: scenarios.ScenarioRequest, presets: Mapping[str, lidars.LidarPreset]
) -> scenarios.ScenarioRequest:
    """Return a scenario with every default written out, so that its digest is that of its content.

    Raises:
        UnknownName: there is no such lidar preset.
        InvalidInput: the lidar lacks fields.
    """
    lidar = filled_lidar(request.lidar, presets)
    update = filled_update(request.update, lidar_model(lidar), spread=request.spread is not None)
    return request.model_copy(update={"lidar": lidar, "update": update})


def scenario_of(
    request: scenarios.ScenarioRequest,
    contours_at: Callable[[PoseSet, float], Contours] | None,
    remember: Remember,
    installed: InstalledRules,
) -> Scenario:
    """Build the mathematics of a filled-in scenario.

    Args:
        request: the scenario with every default written out.
        contours_at: returns the cuts of the object at poses and a height in metres; None: there is no object.
        remember: keeps predictions.
        installed: the update rules of other packages.

    Raises:
        VoaError: the scenario contradicts itself.
    """
    lidar = lidar_model(request.lidar)
    poses = _poses(request.poses)
    sensors = tuple(sensor_of(sensor) for sensor in request.sensors)
    unique = {sensor.name for sensor in sensors}
    if len(unique) != len(sensors):
        raise InvalidInput("sensors", "names that differ", "a name twice")
    data = {} if request.predictions is None else predicted_ranges(request.predictions, sorted(unique), poses.names)
    check_predictable(request, contours_at is not None, data, sensors, poses)
    cuts = None if contours_at is None else partial(contours_at, poses)
    return Scenario(
        poses=poses,
        table=_table(request, len(poses)),
        sensors=sensors,
        predictor=ObservationPredictor(poses, lidar, data, cuts, remember),
        rule=update_rule(request.update, lidar, installed),
        policy=update_policy(request.update),
        prior=prior_of(request.prior, poses),
        workspace=_workspace(request),
        min_gain=request.min_gain,
        spread=_spread(request, has_mesh=cuts is not None),
        absent=request.absent,
    )


def _spread(request: scenarios.ScenarioRequest, *, has_mesh: bool) -> Spread | None:
    if request.spread is None:
        return None
    if not has_mesh:
        raise NoMesh(
            "a spread displaces the object, which needs its mesh: name an object beside the predictions, or leave "
            "`spread` out"
        )
    return Spread(request.spread.xy_m, request.spread.yaw_rad)


def _workspace(request: scenarios.ScenarioRequest) -> Workspace | None:
    if request.workspace is None:
        return None
    (x0, y0), (x1, y1) = request.workspace.min, request.workspace.max
    return Workspace((x0, y0), (x1, y1))


def _poses(poses: Sequence[scenarios.Pose]) -> PoseSet:
    names = [pose.name for pose in poses]
    positions = [pose.position for pose in poses if pose.position is not None]
    quaternions = [pose.quaternion_wxyz for pose in poses if pose.quaternion_wxyz is not None]
    if len(positions) == len(quaternions) == len(poses):
        return PoseSet.from_arrays(names, positions, quaternions)
    if positions or quaternions:
        raise InvalidInput("poses", "position and quaternion_wxyz of every pose, or of none", "of some")
    return PoseSet.named(names)


def _table(request: scenarios.ScenarioRequest, poses: int) -> GraspTable:
    names = [grasp.name for grasp in request.grasps]
    scores = request.scores
    rows = scores.probabilities if isinstance(scores, scenarios.GivenScores) else scores.successes
    lengths = {len(row) for row in rows}
    if len(rows) != len(names) or lengths != {poses}:
        got = f"{len(rows)} rows of {', '.join(map(str, sorted(lengths)))}"
        raise InvalidInput("scores", f"one row per grasp ({len(names)}), one entry per pose ({poses})", got)
    if isinstance(scores, scenarios.GivenScores):
        return GraspTable.of_probabilities(names, stacked(rows), poses)
    return GraspTable.of_successes(names, stacked(rows), scores.attempts, poses)
