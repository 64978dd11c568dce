"""Comparison of one scan with every displaced copy of every pose: the weight of each, and how well it fits."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np

from voa_core.checks import Floats, frozen
from voa_core.comparisons import comparison_of
from voa_core.displaced_scans import DisplacedScans, predict_copies, remembered_copies
from voa_core.displacements import Displacements
from voa_core.filtering import log_means
from voa_core.fits import Fits, fits_of_copies, fits_of_poses
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.places import Viewpoint
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rules.distances import DistanceRule
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
    prediction: Prediction | None = None,
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
        prediction: scans of the poses on the beams of the scan; None: the predictor makes it. Copies are predicted
            from the mesh in any case.

    Raises:
        NoMesh: there is no prediction for the sensor.
        BeamGridMismatch: there is no prediction for the beams of the scan.
    """
    lidar = predictor.lidar
    grid = lidar.beams_of(scan.grid)
    crossing = workspace.crossing(sensor, grid.angles) if workspace else None
    beams = classify(scan, lidar, crossing)
    viewpoint = Viewpoint.of(sensor, lidar, listed=listed)
    has_workspace = workspace is not None
    if displacements is None or displacements.copies == 1:
        exact = predictor.predict(sensor, grid, listed=listed) if prediction is None else prediction
        alone = restricted(exact, sensor, scan, lidar, workspace)
        return evidence_of_beams(beams, alone, rule, has_workspace=has_workspace, viewpoint=viewpoint)
    blocks = (
        restricted_copies(copies, sensor, scan, lidar, workspace)
        for copies in _blocks_of_copies(predictor, sensor, grid, displacements, listed=listed)
    )
    return _evidence_of_copies(beams, blocks, rule, np.inf if has_workspace else BEHIND_M, viewpoint)


def _blocks_of_copies(
    predictor: ObservationPredictor,
    sensor: SensorConfiguration,
    grid: BeamGrid,
    displacements: Displacements,
    *,
    listed: bool,
) -> Iterator[DisplacedScans]:
    """Predict the displaced copies of consecutive poses, block by block; those at listed sensors are remembered."""
    displaced = cache(partial(displacements.at, predictor.poses, sensor))  # not needed for what is remembered
    poses_at_once = max(1, _NUMBERS_AT_ONCE // (displacements.copies * grid.beams))
    for first in range(0, len(predictor.poses), poses_at_once):

        def predict(first: int = first) -> DisplacedScans:
            return predict_copies(predictor, sensor, displaced()[first : first + poses_at_once], grid, first=first)

        key = displacements, first, poses_at_once
        # A robot hardly ever comes back to a pose that is not listed.
        yield remembered_copies(predictor, sensor, grid, key, predict) if listed else predict()


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
    fits = fits_of_poses(beams, prediction, rule.no_return_m)
    compared = int(np.count_nonzero(~np.isnan(beams)))
    return Evidence(
        _log_weights(fits, compared, rule, partial(_log_weights_of_poses, beams, prediction, rule)),
        fits.distances,
        fits.hit_rmsds,
        compared,
        sight_of(beams, prediction, np.inf if has_workspace else BEHIND_M),
        _log_absent(beams, compared, rule),
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
    compared = int(np.count_nonzero(~np.isnan(beams)))
    fits, logs, sights = [], [], []
    for copies in blocks:  # one after another: many copies would not fit in memory together
        fits.append(fits_of_copies(beams, copies, rule.no_return_m))
        logs.append(_log_weights(fits[-1], compared, rule, partial(_log_weights_of_copies, beams, copies, rule)))
        sights.append(sight_of_copies(beams, copies, behind_m))
    return Evidence(
        np.concatenate(logs),
        np.concatenate([each.distances for each in fits]),
        np.concatenate([each.hit_rmsds for each in fits]),
        compared,
        joined(sights),
        _log_absent(beams, compared, rule),
        viewpoint,
    )


def _log_weights(fits: Fits, beams: int, rule: UpdateRule, otherwise: Callable[[], Floats]) -> Floats:
    """Return ln w of each copy of each pose, (n, J), from its distance where the rule depends on that alone.

    Args:
        fits: of the scan.
        beams: number of beams that are compared.
        rule: the update rule.
        otherwise: computes ln w of any other rule.
    """
    if beams == 0:
        return np.zeros_like(fits.squares)
    if _is_of_squares(rule):
        return rule.log_weights(fits.squares, beams)
    return otherwise()


def _log_weights_of_copies(beams: Floats, copies: DisplacedScans, rule: UpdateRule) -> Floats:
    """Compare one scan, classified (r,), with the displaced copies of k poses: ln w of each copy, (k, J)."""
    scans, poses = np.zeros(len(copies), dtype=np.intp), np.arange(len(copies))
    return comparison_of(rule, beams[None, :], copies).log_weights(scans, poses)


def restricted(
    prediction: Prediction,
    sensor: SensorConfiguration,
    scan: Scan | None,
    lidar: LidarModel,
    workspace: Workspace | None,
) -> Prediction:
    """Limit a prediction to the range of the scan (None: of the lidar) and to the workspace, as it is compared."""
    range_max = lidar.range_max if scan is None else scan.limits(lidar)[1]
    if workspace is None and range_max >= lidar.range_max:
        return prediction  # made within the lidar's range
    crossing = workspace.crossing(sensor, prediction.grid.angles[prediction.columns]) if workspace else None
    ranges = frozen(restrict_prediction(prediction.ranges, range_max, crossing))
    return Prediction(prediction.grid, prediction.columns, ranges)


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


def _log_weights_of_poses(beams: Floats, prediction: Prediction, rule: UpdateRule) -> Floats:
    """Compare one scan, classified (r,), with the scan predicted for each of n poses: ln w of each, (n, 1)."""
    known = ~np.isnan(beams)
    compared = int(known.sum())
    kept = known[prediction.columns]
    observed = np.ascontiguousarray(beams[prediction.columns][kept])[None, :]
    predicted = np.ascontiguousarray(prediction.ranges[:, kept])
    # On every other beam all poses predict a no-return: one comparison serves them all.
    known[prediction.columns] = False
    rest = beams[known][None, :]
    statistic = rule.statistic(observed, predicted)[0] + rule.statistic(rest, np.full_like(rest, NO_RETURN))[0, 0]
    return rule.log_weights(statistic, compared)[:, None]


def _log_absent(beams: Floats, compared: int, rule: UpdateRule) -> float:
    """Logarithm of the weight of a prediction without any return, for classified beams (r,), of which some compare."""
    if compared == 0:
        return 0.0
    if _is_of_squares(rule):
        off = beams[beams < rule.no_return_m] - rule.no_return_m
        statistic = np.array([off @ off])
    else:
        known = beams[~np.isnan(beams)]
        statistic = rule.statistic(known[None, :], np.full((1, compared), NO_RETURN))[0]
    return float(rule.log_weights(statistic, compared)[0])


def _is_of_squares(rule: UpdateRule) -> bool:
    return isinstance(rule, DistanceRule) and rule.is_of_squares
