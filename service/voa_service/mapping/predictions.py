"""Predicted scans: from a scenario's data to the mathematics, and from the mathematics to messages."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from voa_core.errors import InvalidInput, UnknownName
from voa_core.lidars import SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.scans import NO_RETURN
from voa_core.scenario import Scenario
from voa_msgs.base import Range
from voa_msgs.scenarios import Predictions, ScenarioRequest
from voa_service.mapping.scans import floats


def predictions_message(scenario: Scenario, sensors: Sequence[SensorConfiguration]) -> Predictions:
    """Predict the scans of every pose from the given sensor configurations, by geometry alone, without the workspace.

    Raises:
        VoaError: a prediction needs a mesh where the scenario has none.
    """
    ranges = []
    for sensor in sensors:
        dense = scenario.predictor.predict(sensor, listed=scenario.lists(sensor)).dense()
        ranges.append([[None if r == NO_RETURN else r for r in beams] for beams in dense.tolist()])
    return Predictions(sensors=[sensor.name for sensor in sensors], poses=list(scenario.poses.names), ranges=ranges)


def predicted_ranges(
    predictions: dict[str, dict[str, list[Range]]], sensors: Sequence[str], poses: Sequence[str]
) -> dict[str, NDArray[np.float64]]:
    """Return predictions that a scenario states as data, in metres, by sensor: arrays of n poses by r beams.

    Raises:
        UnknownName: a sensor or a pose does not exist.
        InvalidInput: a pose is missing, or the numbers of beams differ.
    """
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
        data[sensor] = stacked([floats(of_pose[pose], NO_RETURN) for pose in poses])
    return data


def stacked(rows: Sequence[Sequence[float]]) -> NDArray[np.float64]:
    """Stack n rows of m numbers into an array (n, m), row by row: one large conversion would stop all other threads."""
    array = np.zeros((len(rows), len(rows[0])))
    for row, values in zip(array, rows, strict=True):
        row[:] = values
    return array


def check_predictable(
    request: ScenarioRequest,
    has_mesh: bool,
    data: dict[str, NDArray[np.float64]],
    sensors: Sequence[SensorConfiguration],
    poses: PoseSet,
) -> None:
    """Check that every sensor configuration has predictions as data, or a mesh, pose geometry and a height.

    Raises:
        InvalidInput: a sensor configuration has neither.
    """
    beams = request.lidar.beams
    for name, ranges in data.items():
        if ranges.shape[1] != beams:
            raise InvalidInput(f"predictions.{name}", f"{beams} beams (lidar.beams)", f"{ranges.shape[1]}")
    without_data = [sensor for sensor in sensors if sensor.name not in data]
    if not has_mesh:
        if not without_data:
            return
        expected = "an object, or predictions of every sensor and pose"
        raise InvalidInput("object, predictions", expected, f"no predictions of {without_data[0].name!r} and no object")
    if poses.positions is None:
        raise InvalidInput("poses", "position and quaternion_wxyz, which the object's mesh needs", "names only")
    without_height = [s for s in without_data if s.height_m is None and request.lidar.height_m is None]
    if without_height:
        raise InvalidInput("height_m", f"one for sensor {without_height[0].name!r}, or one for the lidar", "none")
