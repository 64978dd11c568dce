"""Comparison of one scan with every displaced copy of every pose: the weight of each, and how well it fits."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from voa_core.checks import Floats
from voa_core.comparisons import comparison_of, squared_distances_of_pairs
from voa_core.displaced_scans import DisplacedScans, predict_copies
from voa_core.displacements import Displacements
from voa_core.filtering import log_means
from voa_core.lidars import LidarModel, SensorConfiguration
from voa_core.places import Viewpoint
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rules.distances import coded, squared_distance
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN, Scan, classify, restrict_prediction
from voa_core.sight import BEHIND_M, Sight, joined, sight_of, sight_of_copies
from voa_core.workspace import Workspace

_NUMBERS_AT_ONCE = 2**22  # predicted ranges of every beam of a block of poses, 32 MiB


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence of one scan for every pose, which does not depend on the belief.

    Attributes:
        log_copies: (n, J) ln w of each displaced copy of each pose under the update rule.
        distances: (n,) d of each pose, metres: that of the copy with the smallest.
        hit_rmsds: (n,) RMSD over the beams on which both return, metres, of that copy; NaN where there is none.
        beams_compared: number of beams that are not missing.
        sight: the beams that could see the object, and those that do.
        log_absent: ln w of a table without the object, which returns no beam.
        viewpoint: from where the scan was taken; None: unknown, so that no other look shares its place.
    """

    log_copies: Floats
    distances: Floats
    hit_rmsds: Floats
    beams_compared: int
    sight: Sight
    log_absent: float = 0.0
    viewpoint: Viewpoint | None = None

    @property
    def copies(self) -> int:
        """Number J of displaced copies of each pose."""
        return int(self.log_copies.shape[1])

    @cached_property
    def log_weights(self) -> Floats:
        """Logarithms ln w of the weights of the poses, (n,): each is the mean over the copies of the pose."""
        return log_means(self.log_copies)

    @cached_property
    def best_fit(self) -> int:
        """Index of the pose with the largest weight, the first listed of equals.

        Where every weight is 0, as under `margin`, it is the pose with the smallest RMSD.
        """
        best = int(np.argmax(self.log_weights))
        return best if self.log_weights[best] > -np.inf else int(np.argmin(self.distances))

    @property
    def fit_rmsd_mm(self) -> float | None:
        """RMSD of the pose that fits best, millimetres; None where no beam is compared."""
        if self.beams_compared == 0:
            return None
        return 1e3 * float(self.distances[self.best_fit]) / float(np.sqrt(self.beams_compared))

    @property
    def fit_hit_rmsd_mm(self) -> float | None:
        """RMSD over the beams on which the scan and the pose that fits best return, millimetres; None without any."""
        rmsd = float(self.hit_rmsds[self.best_fit])
        return None if np.isnan(rmsd) else 1e3 * rmsd


def evidence_of_scan(
    scan: Scan,
    sensor: SensorConfiguration,
    predictor: ObservationPredictor,
    rule: UpdateRule,
    *,
    workspace: Workspace | None = None,
    displacements: Displacements | None = None,
    listed: bool = False,
) -> Evidence:
    """Compare a measured scan with the prediction of every displaced copy of every pose.

    Which beam is a return is decided at the stated sensor pose. A single copy is the pose itself.

    Args:
        scan: as measured.
        sensor: configuration from which the scan was taken, as far as it is known.
        predictor: of the scenario.
        rule: the update rule, which turns differences into weights.
        workspace: box outside which no return counts; None: there is none.
        displacements: of the copies of each pose; None: the object lies exactly at a pose.
        listed: the sensor is one of the scenario's own configurations.

    Raises:
        NoMesh: there is no prediction for the sensor.
        BeamGridMismatch: there is no prediction for the beams of the scan.
    """
    lidar = predictor.lidar
    grid = lidar.grid if lidar.grid.agrees_with(scan.grid) else scan.grid
    crossing = workspace.crossing(sensor, grid.angles) if workspace else None
    beams = classify(scan, lidar, crossing)
    viewpoint = Viewpoint.of(sensor, lidar, listed=listed)
    has_workspace = workspace is not None
    if displacements is None or displacements.copies == 1:
        alone = restricted(predictor.predict(sensor, grid, listed=listed), sensor, scan, lidar, workspace)
        return evidence_of_beams(beams, alone, rule, has_workspace=has_workspace, viewpoint=viewpoint)
    each = displacements.at(predictor.poses, sensor)
    poses_at_once = max(1, _NUMBERS_AT_ONCE // (displacements.copies * grid.beams))
    key = displacements if listed else None  # a robot hardly ever comes back to a pose that is not listed
    copies = (
        predict_copies(predictor, sensor, each[start : start + poses_at_once], grid, first=start, key=key)
        for start in range(0, len(each), poses_at_once)
    )
    return _evidence_of_copies(
        beams,
        (restricted_copies(block, sensor, scan, lidar, workspace) for block in copies),
        rule,
        np.inf if has_workspace else BEHIND_M,
        viewpoint,
    )


def evidence_of_beams(
    beams: Floats,
    prediction: Prediction,
    rule: UpdateRule,
    *,
    has_workspace: bool,
    viewpoint: Viewpoint | None = None,
) -> Evidence:
    """Compare the classified beams (r,) of a scan with the prediction of each pose on the same beams.

    Args:
        beams: metres, as `scans.classify` gives them.
        prediction: limited by `restricted`, one scan of each pose.
        rule: the update rule, which turns differences into weights.
        has_workspace: True if the beams were classified with a workspace.
        viewpoint: from where the scan was taken; None: unknown.
    """
    log_copies, distances, hit_rmsds = _compare(beams, prediction, rule)
    return Evidence(
        log_copies,
        distances,
        hit_rmsds,
        int(np.count_nonzero(~np.isnan(beams))),
        sight_of(beams, prediction, np.inf if has_workspace else BEHIND_M),
        _log_absent(beams, rule),
        viewpoint,
    )


def _evidence_of_copies(
    beams: Floats,
    blocks: Iterable[DisplacedScans],
    rule: UpdateRule,
    behind_m: float,
    viewpoint: Viewpoint,
) -> Evidence:
    """Compare the classified beams (r,) of a scan with the displaced copies of consecutive poses, block by block."""
    compared, sights = [], []
    for copies in blocks:  # one after another: many copies would not fit in memory together
        compared.append(_compare_copies(beams, copies, rule))
        sights.append(sight_of_copies(beams, copies, behind_m))
    log_copies, distances, hit_rmsds = (np.concatenate(values) for values in zip(*compared, strict=True))
    return Evidence(
        log_copies,
        distances,
        hit_rmsds,
        int(np.count_nonzero(~np.isnan(beams))),
        joined(beams, sights),
        _log_absent(beams, rule),
        viewpoint,
    )


def _compare_copies(beams: Floats, copies: DisplacedScans, rule: UpdateRule) -> tuple[Floats, Floats, Floats]:
    """Compare one scan, classified (r,), with the displaced copies of k poses.

    Returns:
        ln w of each copy, (k, J); and d, and RMSD over the beams on which both return (NaN where there is none), of
        the copy of each pose with the smallest d, each (k,).
    """
    observed, poses = beams[None, :], np.arange(len(copies))
    pairs = np.zeros(len(copies), dtype=np.intp), poses
    square = squared_distances_of_pairs(observed, copies, rule.no_return_m, *pairs)
    best = square.argmin(axis=1)
    of_row = np.repeat(poses, np.diff(copies.start))
    seen, nearest = beams[copies.beams], copies.ranges[np.arange(len(of_row)), best[of_row]]
    both = np.isfinite(seen) & np.isfinite(nearest)
    off = np.minimum(seen, rule.no_return_m) - np.minimum(nearest, rule.no_return_m)
    count = np.bincount(of_row[both], minlength=len(copies))
    total = np.bincount(of_row[both], weights=off[both] ** 2, minlength=len(copies))
    hit_rmsds = np.where(count > 0, np.sqrt(total / np.maximum(count, 1)), np.nan)
    log_copies = comparison_of(rule, observed, copies).log_weights(*pairs)
    return log_copies, np.sqrt(square[poses, best]), hit_rmsds


def restricted(
    prediction: Prediction,
    sensor: SensorConfiguration,
    scan: Scan | None,
    lidar: LidarModel,
    workspace: Workspace | None,
) -> Prediction:
    """Limit a prediction to the range of the scan (None: of the lidar) and to the workspace, as it is compared."""
    range_max = lidar.range_max if scan is None else scan.limits(lidar)[1]
    angles = prediction.grid.angles[prediction.columns]
    crossing = workspace.crossing(sensor, angles) if workspace else None
    return Prediction(prediction.grid, prediction.columns, restrict_prediction(prediction.ranges, range_max, crossing))


def restricted_copies(
    copies: DisplacedScans,
    sensor: SensorConfiguration,
    scan: Scan | None,
    lidar: LidarModel,
    workspace: Workspace | None,
) -> DisplacedScans:
    """Limit displaced scans to the range of the scan (None: of the lidar) and to the workspace."""
    range_max = lidar.range_max if scan is None else scan.limits(lidar)[1]
    if workspace is None and range_max >= lidar.range_max:
        return copies  # predicted within the lidar's range
    return copies.restricted(range_max, workspace.crossing(sensor, copies.grid.angles) if workspace else None)


def _compare(beams: Floats, prediction: Prediction, rule: UpdateRule) -> tuple[Floats, Floats, Floats]:
    """Compare one scan, classified (r,), with the scan predicted for each of n poses at one sensor pose.

    Returns:
        ln w, (n, 1); and d, and RMSD over the beams on which both return (NaN where there is none), each (n,).
    """
    known = ~np.isnan(beams)
    compared = int(known.sum())
    poses = len(prediction.ranges)
    if compared == 0:
        return np.zeros((poses, 1)), np.zeros(poses), np.full(poses, np.nan)
    kept = known[prediction.columns]
    observed = np.ascontiguousarray(beams[prediction.columns][kept])[None, :]
    predicted = np.ascontiguousarray(prediction.ranges[:, kept])
    # On every other beam all poses predict a no-return: one comparison serves them all.
    known[prediction.columns] = False
    rest = beams[known][None, :]
    nothing = np.full_like(rest, NO_RETURN)
    statistic = rule.statistic(observed, predicted)[0] + rule.statistic(rest, nothing)[0, 0]
    square = (
        squared_distance(observed, predicted, rule.no_return_m)[0]
        + squared_distance(rest, nothing, rule.no_return_m)[0, 0]
    )
    hit_rmsds = _hit_rmsds(
        coded(observed, rule.no_return_m),
        coded(predicted, rule.no_return_m),
        np.isfinite(observed) & np.isfinite(predicted),
    )
    return rule.log_weights(statistic, compared)[:, None], np.sqrt(square), hit_rmsds


def _log_absent(beams: Floats, rule: UpdateRule) -> float:
    """Logarithm of the weight of a prediction without any return, for classified beams (r,)."""
    compared = beams[~np.isnan(beams)][None, :]
    if compared.shape[1] == 0:
        return 0.0
    nothing = np.full_like(compared, NO_RETURN)
    return float(rule.log_weights(rule.statistic(compared, nothing)[0], compared.shape[1])[0])


def _hit_rmsds(observed: Floats, predicted: Floats, both: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> Floats:
    count = both.sum(axis=1)
    square = np.where(both, (observed - predicted) ** 2, 0.0).sum(axis=1)
    return np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)
