"""Mistakes that show in a scan that no pose explains well: a clockwise driver, a wrong yaw, millimetres."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from voa_core.cutting import Contours
from voa_core.evidence import Evidence, evidence_of_beams, restricted
from voa_core.lidars import BeamGrid, SensorConfiguration, SensorUncertainty
from voa_core.mistakes.found import Kind, Mistake
from voa_core.mistakes.picking import evenly
from voa_core.prediction import Prediction
from voa_core.rasterising import rasterise
from voa_core.scans import Scan, classify
from voa_core.scenario import Scenario

_SIGMAS = 5.0
_FEWEST_BEAMS = 3
_MUCH_BETTER = 0.5
_MOST_POSES = 500
"""Poses that the scan is compared with in each other reading of it."""


def mistakes_of_scan(
    scenario: Scenario,
    scan: Scan,
    sensor: SensorConfiguration,
    uncertainty: SensorUncertainty | None,
    evidence: Evidence,
) -> tuple[Mistake, ...]:
    """Find why a scan fits badly; nothing is looked for while the best pose fits within 5 sigma.

    Args:
        scenario: for which the scan was taken.
        scan: as measured.
        sensor: where the lidar is said to have stood.
        uncertainty: of that pose.
        evidence: what the scan says as it is.
    """
    fit = _Fit.of(evidence, scenario, uncertainty)
    if evidence.beams_compared == 0 or fit.is_good:
        return ()
    found = []
    if fit.rmsd_mm is not None:
        detail = (
            f"even pose {scenario.poses.names[fit.pose]!r}, which fits best, is {fit.rmsd_mm:.1f} mm off over the "
            f"{fit.hits} beams that hit it; {fit.expected_mm:.1f} mm are expected. Is it the object, and does it lie "
            "at one of the poses? Is the sensor where it is said to be?"
        )
        found.append(Mistake("poor-fit", detail, (scenario.poses.names[fit.pose],)))
    return tuple(found + _millimetres(scenario, scan) + _another_reading(scenario, scan, sensor, uncertainty, fit))


@dataclass(frozen=True)
class _Fit:
    """How well the pose that fits best explains a scan.

    Attributes:
        pose: its index.
        hits: beams on which the scan and the pose return.
        predicted: beams on which the pose returns.
        rmsd_mm: over the beams that hit; None without any.
        whole_rmsd_mm: over all compared beams.
        expected_mm: what the lidar's noise, and the uncertainty of its pose, lead to.
    """

    pose: int
    hits: int
    predicted: int
    rmsd_mm: float | None
    whole_rmsd_mm: float
    expected_mm: float

    @classmethod
    def of(cls, evidence: Evidence, scenario: Scenario, uncertainty: SensorUncertainty | None) -> "_Fit":
        pose = evidence.best_fit
        ranges = evidence.sight.hits(pose)
        lidar = scenario.lidar
        square = np.maximum(lidar.noise_m, lidar.noise_ratio * ranges) ** 2
        if uncertainty is not None:
            square = square + uncertainty.xy_m**2 + (ranges * uncertainty.yaw_rad) ** 2
        expected = float(np.sqrt(square.mean())) if len(ranges) else lidar.noise_m
        predicted = int(np.count_nonzero(evidence.sight.reach[pose] > -np.inf))
        rmsd, whole = evidence.fit_hit_rmsd_mm, evidence.fit_rmsd_mm or 0.0
        return cls(pose, len(ranges), predicted, rmsd, whole, 1e3 * expected)

    @property
    def is_seen(self) -> bool:
        """Whether the fit is good, and rests on at least half of the beams that should hit."""
        return self.rmsd_mm is not None and self.is_good and self.hits >= max(_FEWEST_BEAMS, self.predicted / 2)

    @property
    def is_good(self) -> bool:
        """Within 5 sigma over the hits; a pose that can hardly be seen fits whatever is not seen."""
        if self.rmsd_mm is None:
            return self.predicted < _FEWEST_BEAMS
        return self.rmsd_mm <= _SIGMAS * self.expected_mm


def _millimetres(scenario: Scenario, scan: Scan) -> list[Mistake]:
    """Ranges that all but lie beyond the lidar's limit, and within its limits as millimetres."""
    low, high = scan.limits(scenario.lidar)
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
    """Another way to read the directions of a scan's beams, and the mistake that would explain it."""

    kind: Kind
    why: str
    scan: Scan
    sensor: SensorConfiguration


def _readings(scan: Scan, sensor: SensorConfiguration) -> Iterator[_Reading]:
    grid = scan.grid
    mirrored = replace(scan, grid=BeamGrid(grid.beams, -grid.angle_min, -grid.angle_increment))
    why = "its beams run the other way round: does the driver turn clockwise, or does the lidar hang upside down?"
    yield _Reading("scan-mirrored", why, mirrored, sensor)
    for degrees in (90, 180, 270):
        turned = replace(sensor, yaw_rad=sensor.yaw_rad + np.radians(degrees))
        why = f"the lidar's yaw is {degrees} degrees more than is said: check yaw_rad, and where its beam 0 points"
        yield _Reading("scan-turned", why, scan, turned)


def _another_reading(
    scenario: Scenario, scan: Scan, sensor: SensorConfiguration, uncertainty: SensorUncertainty | None, fit: _Fit
) -> list[Mistake]:
    """The one other reading under which the scan fits best, if it fits much better than as it is."""
    height = scenario.lidar.height_m if sensor.height_m is None else sensor.height_m
    if scenario.predictor.contours_at is None or height is None:
        return []
    cuts = scenario.predictor.contours_at(height)
    index = evenly(len(scenario.poses), _MOST_POSES)
    cuts = replace(cuts, cut_of_pose=cuts.cut_of_pose[index], placement=cuts.placement[index])
    fits = [
        (_Fit.of(_evidence(scenario, cuts, reading.scan, reading.sensor), scenario, uncertainty), reading)
        for reading in _readings(scan, sensor)
    ]
    fits = [each for each in fits if each[0].is_seen and each[0].whole_rmsd_mm < _MUCH_BETTER * fit.whole_rmsd_mm]
    if not fits:
        return []
    best, reading = min(fits, key=lambda each: each[0].whole_rmsd_mm)
    pose = scenario.poses.names[index[best.pose]]
    detail = f"the scan fits pose {pose!r} within {best.rmsd_mm:.1f} mm if {reading.why}"
    return [Mistake(reading.kind, detail, (pose,))]


def _evidence(scenario: Scenario, cuts: Contours, scan: Scan, sensor: SensorConfiguration) -> Evidence:
    """What a scan says of the poses whose cuts are given."""
    lidar, workspace = scenario.lidar, scenario.workspace
    crossing = workspace.crossing(sensor, scan.grid.angles) if workspace else None
    prediction = Prediction.of_dense(scan.grid, rasterise(cuts, sensor, scan.grid, lidar.range_max))
    return evidence_of_beams(
        classify(scan, lidar, crossing),
        [restricted(prediction, sensor, scan, lidar, workspace)],
        scenario.rule,
        has_workspace=workspace is not None,
    )
