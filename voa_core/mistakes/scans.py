"""Mistakes in a scan that no pose explains well: a clockwise driver, a wrong yaw, ranges in millimetres."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from voa_core.cutting import Contours
from voa_core.evidence import Evidence, evidence_of_beams, restricted
from voa_core.lidars import BeamGrid, SensorConfiguration, SensorUncertainty
from voa_core.mistakes.mistake import Kind, Mistake
from voa_core.mistakes.picking import evenly
from voa_core.mistakes.values import FARTHEST_M
from voa_core.prediction import Prediction
from voa_core.rasterising import rasterise
from voa_core.scans import Scan, classify
from voa_core.scenario import Scenario
from voa_core.weights import wanted

_SIGMAS = 5.0
_FEWEST_BEAMS = 3
_MUCH_BETTER = 0.5
_MISSED_MM = 200.0
_LEAST_NOISE_M = 1e-3
_NEAREST_M = 0.01  # no object for an arm is scanned from nearer
_MOST_POSES = 500
"""Largest number of poses that a scan is compared with in each other reading of its beams."""


def mistakes_of_scan(
    scenario: Scenario,
    scan: Scan,
    sensor: SensorConfiguration,
    uncertainty: SensorUncertainty | None,
    evidence: Evidence,
    check: Callable[[], None] = wanted,
) -> tuple[Mistake, ...]:
    """Find probable reasons why a scan fits badly; if it fits well, only mistakes in the numbers of the sensor pose.

    A fit is good if its RMSD over the beams that hit is within 5 sigma, and at least half of the predicted hits occur.

    Args:
        scenario: the scenario of the scan.
        scan: as measured.
        sensor: configuration from which the scan was taken, as stated.
        uncertainty: of the sensor pose; None: it is exact.
        evidence: of the scan.
        check: called before the scan is compared with every pose again, in other readings of its beams; an error that
            it raises ends the search.
    """
    mistakes = [] if scenario.lists(sensor) else _sensor_pose(sensor, evidence)
    fit = _Fit.of(evidence, scenario, uncertainty)
    if evidence.beams_compared == 0 or fit.is_good:
        return tuple(mistakes)
    pose = scenario.poses.names[fit.pose]
    if fit.rmsd_mm > _SIGMAS * fit.expected_mm:
        detail = (
            f"even pose {pose!r}, which fits best, is {fit.rmsd_mm:.1f} mm off over the {fit.hits} beams that hit it; "
            f"{fit.expected_mm:.1f} mm are expected. Is it the object, and does it lie at one of the poses? Does the "
            "sensor stand where the scan says?"
        )
        mistakes.append(Mistake("poor-fit", detail, (pose,)))
    mistakes += _millimetres(scenario, scan)
    return tuple(mistakes + _another_reading(scenario, scan, sensor, uncertainty, fit, check))


def _sensor_pose(sensor: SensorConfiguration, evidence: Evidence) -> list[Mistake]:
    """Find a sensor pose in degrees or millimetres, or one from which no pose can be seen."""
    mistakes = []
    if abs(sensor.yaw_rad) > 2.0 * math.pi:
        detail = (
            f"the sensor's yaw_rad, {sensor.yaw_rad:g}, is more than a turn: is it in degrees? {sensor.yaw_rad:g} "
            f"degrees are {math.radians(sensor.yaw_rad):.4g} rad"
        )
        mistakes.append(Mistake("angle-in-degrees", detail))
    if max(abs(sensor.x), abs(sensor.y), abs(sensor.height_m or 0.0)) > FARTHEST_M:
        detail = (
            f"the sensor stands at x {sensor.x:g}, y {sensor.y:g}, more than {FARTHEST_M:g} m from the origin: is that "
            "in millimetres? Lengths are metres"
        )
        mistakes.append(Mistake("length-in-millimetres", detail))
    if evidence.beams_compared > 0 and evidence.sight.is_blind:
        detail = "from the stated sensor pose the object is seen at no pose: check x, y, yaw_rad and height_m"
        mistakes.append(Mistake("place-sees-nothing", detail))
    return mistakes


@dataclass(frozen=True)
class _Fit:
    """Fit of a scan by the pose that fits it best.

    Attributes:
        pose: its index.
        hits: beams on which the scan and the pose return.
        predicted: the fewest beams on which a copy of the pose returns.
        rmsd_mm: over the beams that hit; 0 without any.
        expected_mm: RMSD that the noise of the lidar and the uncertainty of its pose lead to.
    """

    pose: int
    hits: int
    predicted: int
    rmsd_mm: float
    expected_mm: float

    @classmethod
    def of(cls, evidence: Evidence, scenario: Scenario, uncertainty: SensorUncertainty | None) -> "_Fit":
        pose = evidence.best_fit
        ranges = evidence.sight.hits(pose)
        lidar = scenario.lidar
        square = np.maximum(lidar.noise_m, lidar.noise_ratio * ranges) ** 2
        if uncertainty is not None:
            square = square + uncertainty.xy_m**2 + (ranges * uncertainty.yaw_rad) ** 2
        expected = max(_LEAST_NOISE_M, math.sqrt(float(square.sum()) / len(ranges)) if len(ranges) else lidar.noise_m)
        rmsd = evidence.fit_hit_rmsd_mm or 0.0
        return cls(pose, len(ranges), int(evidence.sight.fewest[pose]), rmsd, 1e3 * expected)

    @property
    def is_good(self) -> bool:
        """True if the RMSD is within 5 sigma and half of the predicted hits occur; fewer than 3 suffice."""
        if self.hits == 0:
            return self.predicted < _FEWEST_BEAMS
        return self.rmsd_mm <= _SIGMAS * self.expected_mm and 2 * self.hits >= self.predicted

    @property
    def misfit_mm(self) -> float:
        """RMSD in mm over the beams that should hit; one that does not counts as 0.2 m off."""
        missed = max(0, self.predicted - self.hits)
        square = self.hits * self.rmsd_mm**2 + missed * _MISSED_MM**2
        return math.sqrt(square / max(1, self.hits + missed))


def _millimetres(scenario: Scenario, scan: Scan) -> list[Mistake]:
    """Find ranges that mostly lie beyond the lidar's limit, and within its limits if they are millimetres."""
    low, high = max(scenario.lidar.range_min, _NEAREST_M), scenario.lidar.range_max
    finite = scan.ranges[np.isfinite(scan.ranges) & (scan.ranges > 0.0)]
    middle = float(np.median(finite)) if len(finite) >= _FEWEST_BEAMS else 0.0
    if not (middle > high and low <= 1e-3 * middle <= high):
        return []
    detail = (
        f"half of the ranges are {middle:.4g} and more, and the lidar measures up to {high:g} m: are they millimetres? "
        "Divide them by 1000"
    )
    return [Mistake("length-in-millimetres", detail)]


@dataclass(frozen=True, eq=False)
class _Reading:
    """A different reading of the directions of a scan's beams, and the mistake that would explain it."""

    kind: Kind
    why: str
    scan: Scan
    sensor: SensorConfiguration


def _readings(scan: Scan, sensor: SensorConfiguration) -> Iterator[_Reading]:
    grid = scan.grid
    mirrored = replace(scan, grid=BeamGrid(grid.beams, -grid.angle_min, -grid.angle_increment))
    why = "its beams are taken in reverse: does the driver turn clockwise, or does the lidar hang upside down?"
    yield _Reading("scan-mirrored", why, mirrored, sensor)
    for degrees in (90, 180, 270):
        turned = replace(sensor, yaw_rad=sensor.yaw_rad + np.radians(degrees))
        why = f"the lidar's yaw is {degrees} degrees more than stated: check yaw_rad, and where its beam 0 points"
        yield _Reading("scan-turned", why, scan, turned)


def _another_reading(
    scenario: Scenario,
    scan: Scan,
    sensor: SensorConfiguration,
    uncertainty: SensorUncertainty | None,
    fit: _Fit,
    check: Callable[[], None],
) -> list[Mistake]:
    """Find the reading of the beams under which the scan fits best, if it fits much better than as measured."""
    height = scenario.lidar.height_m if sensor.height_m is None else sensor.height_m
    if scenario.predictor.contours_at is None or height is None:
        return []
    check()
    cuts = scenario.predictor.contours_at(height)
    index = evenly(len(scenario.poses), _MOST_POSES)
    cuts = replace(cuts, cut_of_pose=cuts.cut_of_pose[index], placement=cuts.placement[index])
    fits = [
        (_Fit.of(_evidence(scenario, cuts, reading.scan, reading.sensor), scenario, uncertainty), reading)
        for reading in _readings(scan, sensor)
    ]
    fits = [
        (other, reading)
        for other, reading in fits
        if other.hits >= _FEWEST_BEAMS and other.is_good and other.misfit_mm < _MUCH_BETTER * fit.misfit_mm
    ]
    if not fits:
        return []
    best, reading = min(fits, key=lambda each: each[0].misfit_mm)
    pose = scenario.poses.names[index[best.pose]]
    detail = f"the scan fits pose {pose!r} within {best.rmsd_mm:.1f} mm if {reading.why}"
    return [Mistake(reading.kind, detail, (pose,))]


def _evidence(scenario: Scenario, cuts: Contours, scan: Scan, sensor: SensorConfiguration) -> Evidence:
    """Compare a scan with the poses of the given cuts."""
    lidar, workspace = scenario.lidar, scenario.workspace
    crossing = workspace.crossing(sensor, scan.grid.angles) if workspace else None
    prediction = Prediction.of_dense(scan.grid, rasterise(cuts, sensor, scan.grid, lidar.range_max))
    return evidence_of_beams(
        classify(scan, lidar, crossing),
        restricted(prediction, sensor, scan, lidar, workspace),
        scenario.rule,
        has_workspace=workspace is not None,
    )
