"""Write a recorded experiment: `experiment.json` and mesh of a scenario, `scans.csv` of predictions and scans."""

import math
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from voa_msgs.geometry import SensorConfiguration
from voa_msgs.scenarios import GivenScores, Scenario
from voa_recordings.experiment_parts import (
    ExperimentFile,
    ExperimentLidar,
    ExperimentObject,
    ExperimentPose,
    ExperimentSensor,
    InvalidExperiment,
    Observation,
)
from voa_recordings.experiment_rows import SCANS, rows_of_scan, write_rows
from voa_recordings.selection import Selection

EXPERIMENT = "experiment.json"
_BESIDE_BEAMS = 3
"""Beams on each side of the predicted object that an empty scan has rows for."""
_BEHIND_M = 0.05
"""Distance behind the farthest predicted return at which a measured range counts as a no-return, metres."""

Ranges = list[float | None]
"""Range of each beam, metres; None for a no-return."""
Pair = tuple[str, str]
"""Names of a sensor configuration and of a pose."""
Predicted = Mapping[Pair, Sequence[float | None]]
"""Predicted ranges of every beam, metres, None for a no-return, by sensor configuration and pose."""


def experiment_of_scenario(
    scenario: Scenario,
    sensors: Sequence[SensorConfiguration],
    predicted: Predicted,
    mesh: ExperimentObject | None,
    selection: Selection,
    no_return_m: float | None = None,
) -> ExperimentFile:
    """Describe a recorded experiment on a scenario.

    Args:
        scenario: as the service stores it, with all fields of its lidar.
        sensors: sensor configurations from which scans are or will be taken.
        predicted: scans from all of them.
        mesh: name and scale of the mesh file in the folder; None: the experiment has no mesh.
        selection: choice of the rows of `scans.csv`.
        no_return_m: range beyond which a measured beam is a no-return, metres; None: that of the scenario's update rule
            if it is within the lidar's range, else 5 cm behind the farthest predicted return.
    """
    with_geometry = all(pose.position is not None for pose in scenario.poses)
    scores = _scores(scenario)
    return ExperimentFile.model_validate(
        {
            "name": scenario.name,
            "object": mesh,
            "lidar": lidar_of(scenario),
            "observation": Observation(no_return=no_return_m or _behind(predicted, scenario)),
            "selection": selection,
            "poses": [
                ExperimentPose(name=pose.name, position=pose.position, quaternion_wxyz=pose.quaternion_wxyz)
                if with_geometry
                else ExperimentPose(name=pose.name)
                for pose in scenario.poses
            ],
            "sensors": [
                ExperimentSensor(name=each.name, x=each.x, y=each.y, yaw_deg=round(math.degrees(each.yaw_rad), 9))
                for each in sensors
            ],
            "grasps": [grasp.name for grasp in scenario.grasps],
            **scores,
        }
    )


def _scores(scenario: Scenario) -> dict[str, object]:
    """Return the fields of `experiment.json` for the grasp scores of a scenario."""
    given = scenario.scores
    if isinstance(given, GivenScores):
        return {"scores": _by_grasp(scenario, given.probabilities)}
    return {"successes": _by_grasp(scenario, given.successes), "attempts": given.attempts}


def _by_grasp(scenario: Scenario, table: Sequence[Sequence[float]]) -> dict[str, dict[str, float]]:
    names = [pose.name for pose in scenario.poses]
    grasps = [grasp.name for grasp in scenario.grasps]
    return {grasp: dict(zip(names, row, strict=True)) for grasp, row in zip(grasps, table, strict=True)}


def lidar_of(scenario: Scenario) -> ExperimentLidar:
    """Return the lidar of a scenario as a recorded experiment describes it, angles in degrees.

    Raises:
        InvalidExperiment: the scenario does not state all of the lidar's fields, as one from the service does.
    """
    lidar = scenario.lidar
    if (
        lidar.beams is None
        or lidar.angle_min is None
        or lidar.angle_increment is None
        or lidar.range_min is None
        or lidar.range_max is None
    ):
        raise InvalidExperiment(
            "expected a scenario whose lidar has beams, angle_min, angle_increment, range_min and range_max, as the "
            "service answers it: update the service"
        )
    return ExperimentLidar(
        beams=lidar.beams,
        angle_min_deg=round(math.degrees(lidar.angle_min), 6),
        angle_increment_deg=round(math.degrees(lidar.angle_increment), 6),
        range_min=lidar.range_min,
        range_max=lidar.range_max,
    )


def _behind(predicted: Predicted, scenario: Scenario) -> float:
    """Return the update rule's range of a no-return, or else a distance a little behind all that is predicted."""
    stated = scenario.update.no_return_m
    if stated is not None and stated < (scenario.lidar.range_max or math.inf):
        return stated
    farthest = max((value for ranges in predicted.values() for value in ranges if value is not None), default=None)
    most = scenario.lidar.range_max or math.inf
    return most if farthest is None else min(most, math.ceil(100.0 * (farthest + _BEHIND_M)) / 100.0)


def height_of(scenario: Scenario, sensor: SensorConfiguration) -> float | None:
    """Return the height of the scan plane at a sensor configuration, metres; None: the scenario states none."""
    return scenario.lidar.height_m if sensor.height_m is None else sensor.height_m


def refuse_experiment(folder: Path) -> None:
    """Raise InvalidExperiment if a folder holds a recorded experiment already, which would be overwritten."""
    for name in (EXPERIMENT, SCANS):
        if (folder / name).exists():
            raise InvalidExperiment(f"{folder} has a file {name} already: name a folder that holds no experiment")


def write_experiment(
    folder: Path,
    experiment: ExperimentFile,
    heights_m: Mapping[str, float | None],
    predicted: Predicted,
    measured: Mapping[Pair, Sequence[float | None]],
    mesh: Path | None = None,
) -> None:
    """Write a recorded experiment into a folder that holds none yet.

    Args:
        folder: made if it is missing.
        experiment: content of `experiment.json`.
        heights_m: height of the scan plane over the table by sensor configuration, metres.
        predicted: ranges of every pair of sensor configuration and pose.
        measured: ranges of the pairs that were measured; the others get rows with an empty cell for each beam that may
            meet the object at some pose, and for three beams beside them.
        mesh: file to be copied to the name that `experiment.object.mesh` states; None: there is none.

    Raises:
        InvalidExperiment: the folder holds an experiment already, or cannot be written.
    """
    refuse_experiment(folder)
    sensors = [sensor.name for sensor in experiment.sensors]
    poses = [pose.name for pose in experiment.poses]
    windows = {sensor: _window([predicted[sensor, pose] for pose in poses]) for sensor in sensors}
    rows = (
        row
        for sensor in sensors
        for pose in poses
        for row in rows_of_scan(
            sensor,
            pose,
            heights_m[sensor],
            measured.get((sensor, pose)),
            predicted[sensor, pose],
            () if (sensor, pose) in measured else windows[sensor],
        )
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        text = experiment.model_dump_json(indent=1, exclude_none=True)
        (folder / EXPERIMENT).write_text(text + "\n", encoding="utf-8")
        write_rows(folder / SCANS, rows, experiment.lidar)
        if mesh is not None and experiment.object is not None:
            shutil.copyfile(mesh, folder / experiment.object.mesh)
    except OSError as error:
        raise InvalidExperiment(f"{folder} cannot be written: {error}") from error


def _window(scans: Sequence[Sequence[float | None]]) -> frozenset[int]:
    """Return the beams on which any scan returns, and three beside each, on a lidar of a full turn also around it."""
    beams = len(scans[0]) if scans else 0
    seen = {index for scan in scans for index, value in enumerate(scan) if value is not None}
    beside = range(-_BESIDE_BEAMS, _BESIDE_BEAMS + 1)
    return frozenset((index + step) % beams for index in seen for step in beside)
