"""Between messages and mathematics: the only place that knows both."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from voa_core.cutting import Contours
from voa_core.errors import BeamGridMismatch, InvalidInput, UnknownName
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.mistakes.mistake import Mistake
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Remember
from voa_core.priors import Category, pose_model
from voa_core.scans import MISSING, NO_RETURN, Scan
from voa_core.scenario import Scenario
from voa_core.workspace import Workspace
from voa_msgs import lidars, objects, priors, scenarios, sessions
from voa_msgs.base import Range
from voa_msgs.geometry import CandidateSensor, UncertainSensorPose
from voa_msgs.geometry import SensorConfiguration as SensorMessage
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.rules import InstalledRules, filled_update, update_policy, update_rule
from voa_service.meshes.mistakes import extent_mistakes
from voa_service.ports import ListedObject, StoredObject

_LIDAR_FIELDS = ("beams", "angle_min", "angle_increment", "range_min", "range_max", "zero")
_MOST_NAMES = 100
_MOST_TURN = 2.0 * np.pi
_USUAL_NOISE = {"noise_m": 0.01, "noise_ratio": 0.02, "dropout": 0.05}


def object_message(stored: StoredObject) -> objects.Object:
    """A stored mesh as a message."""
    mesh: Object = stored.object
    x, y, z = mesh.extents.tolist()
    return listed_object_message(
        ListedObject(
            mesh.digest, stored.name, (x, y, z), len(mesh.faces), mesh.watertight, stored.up, stored.created_at
        )
    )


def listed_object_message(stored: ListedObject) -> objects.Object:
    """A mesh in a list as a message."""
    return objects.Object(
        id=stored.id,
        name=stored.name,
        extents=list(stored.extents),
        faces=stored.faces,
        watertight=stored.watertight,
        up=stored.up,
        warnings=extent_mistakes(stored.extents),
        created_at=stored.created_at,
    )


def filled_in(request: scenarios.ScenarioRequest, presets: dict[str, lidars.LidarPreset]) -> scenarios.ScenarioRequest:
    """The scenario with every default written out, so that its digest is that of its content.

    Raises:
        UnknownName: there is no such lidar preset.
        InvalidInput: the lidar is not complete.
    """
    lidar = _filled_lidar(request.lidar, presets)
    update = filled_update(request.update, lidar_model(lidar))
    return request.model_copy(update={"lidar": lidar, "update": update})


def _filled_lidar(lidar: lidars.Lidar, presets: dict[str, lidars.LidarPreset]) -> lidars.Lidar:
    if lidar.preset is None:
        absent = [name for name in _LIDAR_FIELDS if getattr(lidar, name) is None]
        if absent:
            raise InvalidInput(
                "lidar", f"a preset ({', '.join(sorted(presets))}) or all of its fields", f"no {', '.join(absent)}"
            )
        base = dict(_USUAL_NOISE)
    elif lidar.preset not in presets:
        raise UnknownName("lidar preset", lidar.preset, sorted(presets))
    else:
        base = presets[lidar.preset].model_dump(exclude={"name", "title", "source"})
    own = {name: value for name, value in lidar.model_dump().items() if value is not None}
    return lidars.Lidar.model_validate(base | own)


def lidar_model(lidar: lidars.Lidar) -> LidarModel:
    """The mathematics' lidar of a filled-in message."""
    values = lidar.model_dump(exclude={"preset"})
    grid = BeamGrid(values.pop("beams"), values.pop("angle_min"), values.pop("angle_increment"))
    return LidarModel(grid=grid, **values)


def scenario_of(
    request: scenarios.ScenarioRequest,
    contours_at: Callable[[PoseSet, float], Contours] | None,
    remember: Remember,
    installed: InstalledRules,
) -> Scenario:
    """The mathematics of a filled-in scenario.

    Args:
        request: with every default written out.
        contours_at: the cuts of the object at poses and a height; None: there is no object.
        remember: keeps predictions.
        installed: the update rules of other packages.

    Raises:
        VoaError: what it says cannot be.
    """
    lidar = lidar_model(request.lidar)
    poses = _poses(request.poses)
    sensors = tuple(sensor_of(sensor) for sensor in request.sensors)
    unique = {sensor.name for sensor in sensors}
    if len(unique) != len(sensors):
        raise InvalidInput("sensors", "names that differ", "a name twice")
    data = {} if request.predictions is None else _data(request.predictions, sorted(unique), poses.names)
    _check_predictable(request, contours_at is not None, data, sensors, poses)
    cuts = None if contours_at is None else partial(contours_at, poses)
    predictor = ObservationPredictor(poses, lidar, data, cuts, remember)
    workspace = None
    if request.workspace is not None:
        (x0, y0), (x1, y1) = request.workspace.min, request.workspace.max
        workspace = Workspace((x0, y0), (x1, y1))
    return Scenario(
        poses=poses,
        table=_table(request, len(poses)),
        sensors=sensors,
        predictor=predictor,
        rule=update_rule(request.update, lidar, installed),
        policy=update_policy(request.update),
        prior=prior_of(request.prior, poses),
        workspace=workspace,
        min_gain=request.min_gain,
    )


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
    given = scores.probabilities if isinstance(scores, scenarios.GivenScores) else scores.successes
    lengths = {len(row) for row in given}
    if len(given) != len(names) or lengths != {poses}:
        found = f"{len(given)} rows of {', '.join(map(str, sorted(lengths)))}"
        raise InvalidInput("scores", f"one row per grasp ({len(names)}), one entry per pose ({poses})", found)
    if isinstance(scores, scenarios.GivenScores):
        return GraspTable.of_probabilities(names, _array(given), poses)
    return GraspTable.of_successes(names, _array(given), scores.attempts, poses)


def _data(
    predictions: dict[str, dict[str, list[Range]]], sensors: Sequence[str], poses: Sequence[str]
) -> dict[str, NDArray[np.float64]]:
    """Predicted ranges by sensor, (n, r)."""
    data = {}
    for sensor, of_pose in predictions.items():
        if sensor not in sensors:
            raise UnknownName("sensor", sensor, sensors)
        for pose in of_pose:
            if pose not in poses:
                raise UnknownName("pose", pose, poses)
        absent = [pose for pose in poses if pose not in of_pose]
        if absent:
            raise InvalidInput(f"predictions.{sensor}", "ranges for every pose", f"none for {absent[0]!r}")
        lengths = {len(ranges) for ranges in of_pose.values()}
        if len(lengths) > 1:
            raise InvalidInput(f"predictions.{sensor}", "equally many beams for every pose", f"{sorted(lengths)}")
        data[sensor] = _array([_floats(of_pose[pose], NO_RETURN) for pose in poses])
    return data


def _array(rows: Sequence[Sequence[float]]) -> NDArray[np.float64]:
    """Stack rows of equal length, (n, m), one by one: a conversion of them all would stop every other thread."""
    stacked = np.zeros((len(rows), len(rows[0])))
    for row, values in zip(stacked, rows, strict=True):
        row[:] = values
    return stacked


def _check_predictable(
    request: scenarios.ScenarioRequest,
    has_mesh: bool,
    data: dict[str, NDArray[np.float64]],
    sensors: Sequence[SensorConfiguration],
    poses: PoseSet,
) -> None:
    """Every configuration must have data, or a mesh with geometry and a height."""
    beams = request.lidar.beams
    for name, ranges in data.items():
        if ranges.shape[1] != beams:
            raise InvalidInput(f"predictions.{name}", f"{beams} beams (lidar.beams)", f"{ranges.shape[1]}")
    left = [sensor for sensor in sensors if sensor.name not in data]
    if not has_mesh:
        if not left:
            return
        expected = "an object, or predictions of every sensor and pose"
        raise InvalidInput("object, predictions", expected, f"no predictions of {left[0].name!r} and no object")
    if poses.positions is None:
        raise InvalidInput("poses", "position and quaternion_wxyz, which the object's mesh needs", "names only")
    blind = [sensor for sensor in left if sensor.height_m is None and request.lidar.height_m is None]
    if blind:
        raise InvalidInput("height_m", f"one for sensor {blind[0].name!r}, or one for the lidar", "none")


def _floats(ranges: Sequence[Range], null: float) -> list[float]:
    return [null if value is None else value for value in ranges]


def sensor_of(sensor: SensorMessage) -> SensorConfiguration:
    """A named sensor configuration."""
    return SensorConfiguration(sensor.name, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m, sensor.cost)


def candidates(scenario: Scenario, wanted: Sequence[str | CandidateSensor] | None) -> tuple[SensorConfiguration, ...]:
    """The sensor configurations that a request names or gives; None: the scenario's.

    Raises:
        UnknownName, InvalidInput: no such configuration; one name twice.
    """
    if wanted is None:
        return scenario.sensors
    found = []
    for index, item in enumerate(wanted):
        if isinstance(item, str):
            found.append(scenario.sensor(item))
        else:
            name = str(index) if item.name is None else item.name
            found.append(SensorConfiguration(name, item.x, item.y, item.yaw_rad, item.height_m, item.cost))
    if len({sensor.name for sensor in found}) != len(found):
        raise InvalidInput("sensors", "names that differ", "a name twice")
    return tuple(found)


def place_of(scenario: Scenario, request: sessions.ScanRequest) -> tuple[SensorConfiguration, SensorUncertainty | None]:
    """Where a scan was taken, and how well that is known."""
    if request.sensor_pose is None:
        return scenario.sensor(request.sensor or ""), None
    pose: UncertainSensorPose = request.sensor_pose
    sensor = SensorConfiguration("sensor_pose", pose.x, pose.y, pose.yaw_rad, pose.height_m)
    if pose.std is None or pose.std.xy_m == pose.std.yaw_rad == 0.0:
        return sensor, None
    return sensor, SensorUncertainty(pose.std.xy_m, pose.std.yaw_rad)


def scan_of(scan: sessions.Scan, lidar: LidarModel) -> Scan:
    """A raw scan; what it does not say of its beams is the lidar's.

    Raises:
        BeamGridMismatch: there are more or fewer ranges than the lidar has beams, and no angles of their own; or the
            beams span more than a turn.
        InvalidInput: the range limits contradict each other.
    """
    own = lidar.grid
    if len(scan.ranges) != own.beams and (scan.angle_min is None or scan.angle_increment is None):
        raise BeamGridMismatch(
            f"expected one range for each of the lidar's beams ({own.beams} from {own.angle_min:g} rad by "
            f"{own.angle_increment:g} rad), got {len(scan.ranges)} ranges: a scan with other beams must say both "
            "angle_min and angle_increment"
        )
    grid = BeamGrid(
        len(scan.ranges),
        own.angle_min if scan.angle_min is None else scan.angle_min,
        own.angle_increment if scan.angle_increment is None else scan.angle_increment,
    )
    if grid.beams * abs(grid.angle_increment) > _MOST_TURN + 1.5 * abs(grid.angle_increment):
        turns = grid.beams * abs(grid.angle_increment) / _MOST_TURN
        raise BeamGridMismatch(
            f"expected the {grid.beams} beams to span at most one turn, got an angle_increment of "
            f"{grid.angle_increment:g} rad, which makes {turns:.3g} turns: is it in degrees?"
        )
    ranges = np.array(_floats(scan.ranges, MISSING))
    found = Scan(ranges, grid, tuple(scan.no_return), scan.range_min, scan.range_max)
    low, high = found.limits(lidar)
    if low > high:
        raise InvalidInput("range_min", f"at most range_max ({high}, the scan's or the lidar's)", repr(low))
    return found


def warning_messages(mistakes: Iterable[Mistake]) -> list[ProbableMistake]:
    """Probable mistakes as messages; of a long list of names the first hundred."""
    return [
        ProbableMistake(
            kind=mistake.kind,
            detail=mistake.detail,
            poses=list(mistake.poses[:_MOST_NAMES]) or None,
            sensors=list(mistake.sensors[:_MOST_NAMES]) or None,
        )
        for mistake in mistakes
    ]


def prior_of(prior: list[float] | priors.PoseModelPrior | None, poses: PoseSet) -> Belief:
    """A prior over the poses; None: uniform."""
    if prior is None:
        return Belief.uniform(len(poses))
    if isinstance(prior, list):
        return Belief.of(prior, "prior", len(poses))
    found = []
    for category in prior.categories:
        if category.pose not in poses.names:
            raise UnknownName("pose", category.pose, poses.names)
        mean = None if category.mean_xy is None else (category.mean_xy[0], category.mean_xy[1])
        covariance = None
        if category.covariance_xy is not None:
            (xx, xy), (yx, yy) = category.covariance_xy
            covariance = ((xx, xy), (yx, yy))
        found.append(
            Category(
                poses.names.index(category.pose),
                category.probability,
                category.yaw_mean_rad,
                category.yaw_concentration,
                mean,
                covariance,
            )
        )
    return pose_model(poses, found)
