"""Errors of predicted scans: measured minus predicted ranges, beam by beam.

Measured scans come from the simulated lidar or from a recorded experiment; predictions are computed from the mesh by
`voa_core`, or are those in the recorded experiment.
"""

import math
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from voa_core.checks import Floats
from voa_core.lidars import BeamGrid, LidarModel
from voa_core.lidars import SensorConfiguration as Stand
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, predictor_of_mesh
from voa_core.workspace import Workspace
from voa_fleet.episodes.bench import make_bench
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import LidarGeometry, lidar_geometry
from voa_fleet.world.meshes import read_obj
from voa_fleet.world.object_poses import Drop, noisy_pose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_recordings.experiment import RecordedExperiment
from voa_recordings.experiment_parts import InvalidExperiment

Source = Literal["recorded", "mesh"]


@dataclass(frozen=True)
class ComparedBeam:
    """A beam of a scan that was measured or predicted to return.

    Attributes:
        sensor, pose: their names.
        angle_deg: of the beam in the lidar's frame.
        measured_m, predicted_m: ranges; None for a no-return.
    """

    sensor: str
    pose: str
    angle_deg: float
    measured_m: float | None
    predicted_m: float | None

    @property
    def error_mm(self) -> float | None:
        """Measured minus predicted range, millimetres; None unless the beam returns in both."""
        if self.measured_m is None or self.predicted_m is None:
            return None
        return 1e3 * (self.measured_m - self.predicted_m)


@dataclass(frozen=True)
class Errors:
    """Statistics of measured minus predicted ranges, millimetres; None where no beam returns in both.

    Attributes:
        beams: number of beams that return in both.
        mean, median, std, lowest, highest: of the differences.
        median_abs, p95_abs: of their absolute values.
        only_measured, only_predicted: number of beams that return in one of them only.
    """

    beams: int
    mean: float | None
    median: float | None
    std: float | None
    lowest: float | None
    highest: float | None
    median_abs: float | None
    p95_abs: float | None
    only_measured: int
    only_predicted: int


@dataclass(frozen=True)
class ObservationErrors:
    """Compared beams of an object or a recorded experiment.

    Attributes:
        name: of the object or experiment.
        source: of the predictions.
        scans: number of measured scans.
        sensors, poses: names, in order.
        beams: every beam of every scan that was measured or predicted to return.
    """

    name: str
    source: Source
    scans: int
    sensors: tuple[str, ...]
    poses: tuple[str, ...]
    beams: tuple[ComparedBeam, ...]

    @property
    def overall(self) -> Errors:
        """Statistics over all beams."""
        return errors_of(self.beams)

    def by_sensor(self) -> dict[str, Errors]:
        """Compute the statistics per sensor configuration, by its name."""
        return {sensor: errors_of(beam for beam in self.beams if beam.sensor == sensor) for sensor in self.sensors}

    def by_beam(self) -> dict[tuple[str, float], Errors]:
        """Compute the statistics per sensor configuration and beam angle, degrees, ascending."""
        groups: dict[tuple[str, float], list[ComparedBeam]] = {}
        for beam in self.beams:
            groups.setdefault((beam.sensor, beam.angle_deg), []).append(beam)
        order = sorted(groups, key=lambda key: (self.sensors.index(key[0]), key[1]))
        return {key: errors_of(groups[key]) for key in order}


def errors_of(beams: Iterable[ComparedBeam]) -> Errors:
    """Compute the statistics of some beams."""
    compared = list(beams)
    apart = np.array([beam.error_mm for beam in compared if beam.error_mm is not None], dtype=np.float64)
    only_measured = sum(beam.predicted_m is None for beam in compared)
    only_predicted = sum(beam.measured_m is None for beam in compared)
    if apart.size == 0:
        return Errors(0, None, None, None, None, None, None, None, only_measured, only_predicted)
    return Errors(
        beams=int(apart.size),
        mean=float(apart.mean()),
        median=float(np.median(apart)),
        std=float(apart.std()),
        lowest=float(apart.min()),
        highest=float(apart.max()),
        median_abs=float(np.median(np.abs(apart))),
        p95_abs=float(np.percentile(np.abs(apart), 95.0)),
        only_measured=only_measured,
        only_predicted=only_predicted,
    )


def simulated_errors(
    target: FleetObject,
    scans: int,
    imperfections: Imperfections,
    seed: int,
    progress: Callable[[int], None] | None = None,
) -> ObservationErrors:
    """Take `scans` scans of every pose from every sensor configuration of the scenario, and compare them.

    The prediction is for the believed place of the robot and the exact pose of the object; the scan is taken with
    their errors. Returns outside of the scenario's workspace are not from the object.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    lidar = lidar_geometry(target.scenario.lidar)
    predictor = _predictor_of(target, lidar)
    bench = make_bench(target, imperfections, seed)
    beams: list[ComparedBeam] = []
    for sensor in target.scenario.sensors:
        stand = Stand(sensor.name, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m)
        predicted = predictor.predict(stand).dense()
        for row, pose in enumerate(target.poses):
            for index in range(scans):
                pair = zlib.crc32(sensor.name.encode()), zlib.crc32(pose.encode())
                rng = np.random.default_rng([seed, *pair, index])
                drop = Drop(index, pose, noisy_pose(scenario_pose(target, pose), imperfections, rng))
                robot = bench.place(drop, rng).robot
                robot.stand_at(sensor)
                beams += _compared(target, stand, pose, lidar, robot.measure(), predicted[row])
            if progress is not None:
                progress(scans)
    names = tuple(sensor.name for sensor in target.scenario.sensors)
    total = scans * len(names) * len(target.poses)
    return ObservationErrors(target.name, "mesh", total, names, tuple(target.poses), tuple(beams))


def recorded_errors(experiment: RecordedExperiment, source: Source) -> ObservationErrors:
    """Compare the measured scans of a recorded experiment with its predictions, or with those of its mesh.

    Raises:
        InvalidExperiment: the experiment lacks what predictions from the mesh need.
    """
    by_mesh = _mesh_ranges(experiment) if source == "mesh" else {}
    beams = []
    for pair, scan in experiment.scans.items():
        if not scan.was_measured:
            continue
        for beam in scan.beams:
            predicted = _finite(by_mesh[pair][beam.index]) if source == "mesh" else beam.predicted
            if beam.measured is None and predicted is None:
                continue
            angle = experiment.lidar.angle_min_deg + beam.index * experiment.lidar.angle_increment_deg
            beams.append(ComparedBeam(*pair, angle, beam.measured, predicted))
    return ObservationErrors(
        name=experiment.name,
        source=source,
        scans=sum(scan.was_measured for scan in experiment.scans.values()),
        sensors=tuple(sensor.name for sensor in experiment.sensors),
        poses=tuple(experiment.pose_names),
        beams=tuple(beams),
    )


def has_predictions(experiment: RecordedExperiment) -> bool:
    """True if the experiment has a predicted range of any beam."""
    return any(beam.predicted is not None for scan in experiment.scans.values() for beam in scan.beams)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _mesh_ranges(experiment: RecordedExperiment) -> dict[tuple[str, str], Floats]:
    """Predicted scan (beams,), metres, of every recorded pair at the height of its own scan plane."""
    places = [pose.position for pose in experiment.poses if pose.position is not None]
    turns = [pose.quaternion_wxyz for pose in experiment.poses if pose.quaternion_wxyz is not None]
    heights = {pair: experiment.height_m(*pair) for pair in experiment.scans}
    complete = len(places) == len(turns) == len(experiment.poses) and None not in heights.values()
    if experiment.mesh is None or not complete:
        raise InvalidExperiment(
            f"{experiment.name}: predictions from the mesh need a mesh file, plane heights, and position and "
            "quaternion_wxyz of every pose"
        )
    mesh, lidar, names = read_obj(experiment.mesh), experiment.lidar, experiment.pose_names
    grid = BeamGrid(lidar.beams, math.radians(lidar.angle_min_deg), math.radians(lidar.angle_increment_deg))
    model = LidarModel(grid, 0.0, max(lidar.range_max, experiment.no_return_m), None, "missing", 1e-3, 0.0, 0.0)
    predictor = predictor_of_mesh(
        Object.from_arrays(mesh.vertices, mesh.faces, experiment.scale),
        PoseSet.from_arrays(names, places, turns),
        model,
    )
    predictions: dict[tuple[str, str], Floats] = {}
    for sensor in experiment.sensors:
        for height in {heights[pair] for pair in heights if pair[0] == sensor.name}:
            stand = Stand(sensor.name, sensor.x, sensor.y, math.radians(sensor.yaw_deg), height)
            ranges = predictor.predict(stand).dense()
            own = [pair for pair in heights if pair[0] == sensor.name and heights[pair] == height]
            predictions |= {pair: ranges[names.index(pair[1])] for pair in own}
    return predictions


def _predictor_of(target: FleetObject, lidar: LidarGeometry) -> ObservationPredictor:
    grid = BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
    model = LidarModel(grid, lidar.range_min, lidar.range_max, lidar.height_m, "missing", 1e-3, 0.0, 0.0)
    places: list[Sequence[float]] = []
    turns: list[Sequence[float]] = []
    for name in target.poses:
        exact = scenario_pose(target, name)
        places.append(exact.position)
        turns.append(exact.quaternion_wxyz)
    poses = PoseSet.from_arrays(target.poses, places, turns)
    return predictor_of_mesh(Object.from_arrays(target.mesh.vertices, target.mesh.faces), poses, model)


def _compared(
    target: FleetObject, stand: Stand, pose: str, lidar: LidarGeometry, measured: Floats, predicted: Floats
) -> list[ComparedBeam]:
    """Beams on which the object was measured or predicted; a 0 is no evidence, so that such beams are left out."""
    seen = measured > 0.0
    box = target.scenario.workspace
    if box is not None:
        low, high = (float(box.min[0]), float(box.min[1])), (float(box.max[0]), float(box.max[1]))
        crossing = Workspace(low, high).crossing(stand, lidar.angles)
        of_object = seen & crossing.inside(measured)
        evident = seen & ~crossing.before(measured)
    else:
        of_object = evident = seen
    beams = []
    for index in np.flatnonzero(evident & (of_object | np.isfinite(predicted))):
        value = float(measured[index]) if of_object[index] else None
        angle = round(math.degrees(float(lidar.angles[index])), 6)
        beams.append(ComparedBeam(stand.name, pose, angle, value, _finite(predicted[index])))
    return beams
