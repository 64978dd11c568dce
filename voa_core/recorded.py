"""Recorded experiments: the values of looks over scans that were measured at each pose.

Two calls lead from recorded ranges to the executed counterpart of VOA (AECD):

    scenario = scenario_of_recorded(pose_names, table, lidar, rule, predicted)
    aecd = value_recorded_looks(scenario, measured)["Q1"].aecd
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.assistance import executed_value, value_of_assistance
from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import LidarModel, SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN, Scan
from voa_core.scenario import Scenario
from voa_core.updating import OnNoMatch, Update, UpdatePolicy, update

RecordedRanges = Sequence[Sequence[float | None]] | Floats
"""Recorded ranges of n poses and r beams, metres; None or inf is a no-return, NaN a missing beam."""


@dataclass(frozen=True, eq=False)
class RecordedLook:
    """Values of a look from one sensor configuration in a recorded experiment.

    Attributes:
        voa: Value of Assistance over the predicted scans: the value expected beforehand.
        aecd: the same expression over the measured scans: the value that the look had.
        updates: for each pose, the update by the scan that was measured there.
    """

    voa: float
    aecd: float
    updates: tuple[Update, ...]


def scenario_of_recorded(
    pose_names: Sequence[str],
    table: GraspTable,
    lidar: LidarModel,
    rule: UpdateRule,
    predicted: Mapping[str, RecordedRanges],
    on_no_match: OnNoMatch = "nearest",
) -> Scenario:
    """Make the scenario of a recorded experiment, with a uniform prior, from its predicted ranges.

    Args:
        pose_names: of the n poses.
        table: scores of the grasps at the poses.
        lidar: with r beams.
        rule: the update rule.
        predicted: by the name of each sensor configuration, (n, r); the sensors need no coordinates.
        on_no_match: effect of a scan that no pose explains; the paper's lab used "nearest".

    Raises:
        InvalidInput: a name stands twice, ranges have another shape, or a range is negative.
    """
    poses = PoseSet.named(pose_names)
    shape = (len(poses), lidar.grid.beams)
    ranges = {sensor: _ranges(f"predicted of {sensor!r}", values, shape) for sensor, values in predicted.items()}
    return Scenario(
        poses=poses,
        table=table,
        sensors=tuple(SensorConfiguration(sensor, 0.0, 0.0, 0.0) for sensor in ranges),
        predictor=ObservationPredictor(poses, lidar, ranges),
        rule=rule,
        policy=UpdatePolicy(on_no_match),
        prior=Belief.uniform(len(poses)),
    )


def value_recorded_looks(
    scenario: Scenario, measured: Mapping[str, RecordedRanges], belief: Belief | None = None
) -> dict[str, RecordedLook]:
    """Compute VOA and AECD of a look from each sensor configuration with measured scans.

    Measured ranges count however short they are: the limit `range_min` of the lidar does not apply to them.

    Args:
        scenario: of the experiment, with predictions for the sensors.
        measured: ranges of the scan that was measured at each pose, (n, r), by the names of the sensors.
        belief: before the look, (n,); None: the scenario's prior.

    Raises:
        UnknownName: the scenario has no such sensor.
        InvalidInput: ranges have another shape.
    """
    before = scenario.prior if belief is None else belief
    return {name: _value(scenario, scenario.sensor(name), ranges, before) for name, ranges in measured.items()}


def _value(scenario: Scenario, sensor: SensorConfiguration, measured: RecordedRanges, before: Belief) -> RecordedLook:
    shape = (len(scenario.poses), scenario.lidar.grid.beams)
    weigher = scenario.weigher(sensor, np.float64, keep=True)
    voa = value_of_assistance(weigher, before, scenario.table, scenario.policy).voa
    scans = [
        Scan.recorded(ranges, scenario.lidar) for ranges in _ranges(f"measured of {sensor.name!r}", measured, shape)
    ]
    updates = tuple(update(before, scenario.evidence(scan, sensor), scenario.policy) for scan in scans)
    aecd = executed_value(before, [done.belief for done in updates], scenario.table)
    return RecordedLook(voa, aecd, updates)


def _ranges(field: str, values: RecordedRanges, shape: tuple[int, int]) -> Floats:
    """Copy recorded ranges to an array of `shape`, with inf for None."""
    rows = [[NO_RETURN if value is None else value for value in row] for row in values]
    if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
        lengths = sorted({len(row) for row in rows})
        raise InvalidInput(field, f"{shape[0]} poses of {shape[1]} beams", f"{len(rows)} poses of {lengths} beams")
    return np.array(rows, dtype=np.float64)
