"""Comparison of one scan with every pose: the weight and the fit of each, and if the scan shows the object at all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rules.distances import coded, squared_distance
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN, Scan, classify, restrict_prediction
from voa_core.workspace import Workspace

BEHIND_M = 0.1
"""Without a workspace, a return this far behind the farthest prediction of its beam still sees the object."""
_FEWEST_RETURNS = 3
_SLACK_M = 1e-9


@dataclass(frozen=True, eq=False)
class Sight:
    """Beams of one scan that could see the object, and those that do: for scans in which the object is missing.

    Attributes:
        measured: (u,) the scan's ranges, metres, on the compared beams on which some copy of a pose returns.
        reach: (n, u) largest range, metres, of a return that sees the object at each pose, in any of its displaced
            copies; -inf where no copy returns. With a workspace it is inf elsewhere: its edge bounds the returns.
        fewest: (n,) the fewest of the compared beams on which a displaced copy of each pose returns.
    """

    measured: Floats
    reach: Floats
    fewest: NDArray[np.intp]

    def hits(self, pose: int) -> Floats:
        """Measured ranges, (h,) metres, on the h beams on which both the scan and a copy of the pose return."""
        hit: Floats = self.measured[np.isfinite(self.measured) & (self.reach[pose] > -np.inf)]
        return hit

    def misses_object(self, possible: NDArray[np.bool_]) -> bool:
        """True if too few beams see the object for it to lie at one of the possible poses, flags (n,).

        With m the fewest returns that a copy of a possible pose predicts, the scan misses the object if m >= 3 and
        fewer than m / 3 of the beams on which such a copy returns see it. Two returns or fewer decide nothing.
        """
        fewest = int(self.fewest.min(where=possible, initial=np.iinfo(np.intp).max))
        if fewest < _FEWEST_RETURNS:
            return False
        seen = (self.measured <= _farthest(self.reach, possible) + _SLACK_M) & np.isfinite(self.measured)
        return 3 * int(np.count_nonzero(seen)) < fewest


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence of one scan for every pose, which does not depend on the belief.

    Attributes:
        log_weights: (n,) ln w of each pose under the update rule.
        distances: (n,) d of each pose, metres; with an uncertain sensor pose, the smallest over its sigma points.
        hit_rmsds: (n,) RMSD over the beams on which both return, metres, at that sigma point; NaN where there is none.
        beams_compared: number of beams that are not missing.
        sight: the beams that could see the object, and those that do.
    """

    log_weights: Floats
    distances: Floats
    hit_rmsds: Floats
    beams_compared: int
    sight: Sight

    @property
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
    uncertainty: SensorUncertainty | None = None,
    listed: bool = False,
) -> Evidence:
    """Compare a measured scan with the prediction of every pose.

    With an uncertain sensor pose the weight is the mean over its sigma points, and a pose's distance is that
    of the sigma point at which it fits best. Which beam is a return is decided at the stated pose.

    Args:
        scan: as measured.
        sensor: configuration from which the scan was taken, as far as it is known.
        predictor: of the scenario.
        rule: the update rule, which turns differences into weights.
        workspace: box outside which no return counts; None: there is none.
        uncertainty: standard deviations of the sensor pose.
        listed: the sensor is one of the scenario's own configurations.

    Raises:
        NoMesh: there is no prediction for the sensor.
        BeamGridMismatch: there is no prediction for the beams of the scan.
    """
    lidar = predictor.lidar
    grid = lidar.grid if lidar.grid.agrees_with(scan.grid) else scan.grid
    crossing = workspace.crossing(sensor, grid.angles) if workspace else None
    beams = classify(scan, lidar, crossing)
    stands = uncertainty.sigma_points(sensor) if uncertainty else [sensor]
    predictions = [
        restricted(predictor.predict(stand, grid, listed=listed), stand, scan, lidar, workspace) for stand in stands
    ]
    return evidence_of_beams(beams, predictions, rule, has_workspace=workspace is not None)


def evidence_of_beams(
    beams: Floats, predictions: Sequence[Prediction], rule: UpdateRule, *, has_workspace: bool
) -> Evidence:
    """Compare the classified beams (r,) of a scan with predictions on the same beams.

    Args:
        beams: metres, as `scans.classify` gives them.
        predictions: one for each sigma point of the sensor pose, limited by `restricted`.
        rule: the update rule, which turns differences into weights.
        has_workspace: True if the beams were classified with a workspace.
    """
    compared = [_compare(beams, prediction, rule) for prediction in predictions]
    log_weights, distances, hit_rmsds = (np.stack(values) for values in zip(*compared, strict=True))
    best = distances.argmin(axis=0), np.arange(distances.shape[1])
    return Evidence(
        log_weights[0] if len(compared) == 1 else np.logaddexp.reduce(log_weights) - np.log(len(compared)),
        distances[best],
        hit_rmsds[best],
        int(np.count_nonzero(~np.isnan(beams))),
        _sight(beams, predictions, np.inf if has_workspace else BEHIND_M),
    )


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


def _compare(beams: Floats, prediction: Prediction, rule: UpdateRule) -> tuple[Floats, Floats, Floats]:
    """Compare one scan, classified (r,), with the scans predicted for every pose at one sensor pose.

    Returns:
        ln w, d and RMSD over the beams on which both return (NaN where there is none), each (n,).
    """
    known = ~np.isnan(beams)
    compared = int(known.sum())
    if compared == 0:
        nothing = np.zeros(len(prediction.ranges))
        return nothing, nothing, np.full(len(nothing), np.nan)
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
    return rule.log_weights(statistic, compared), np.sqrt(square), hit_rmsds


def _hit_rmsds(observed: Floats, predicted: Floats, both: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> Floats:
    count = both.sum(axis=1)
    square = np.where(both, (observed - predicted) ** 2, 0.0).sum(axis=1)
    return np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)


def _sight(beams: Floats, predictions: Sequence[Prediction], behind_m: float) -> Sight:
    """Find the classified beams (r,) that could see a pose in any of its displaced copies, one prediction each.

    A return at most `behind_m` behind the farthest prediction of its beam sees the object.
    """
    could_see = np.zeros(len(beams), dtype=bool)
    for prediction in predictions:
        could_see[prediction.columns] = True
    columns = np.flatnonzero(could_see & ~np.isnan(beams))
    entry = np.full(len(beams), -1)
    entry[columns] = np.arange(len(columns))
    poses = len(predictions[0].ranges)
    reach, fewest = np.full((poses, len(columns)), -np.inf), np.full(poses, len(beams))
    for prediction in predictions:
        _enter_copy(prediction.ranges, entry[prediction.columns], behind_m, reach, fewest)
    return Sight(beams[columns], reach, fewest)


@kernel
def _enter_copy(
    ranges: Floats, entry: NDArray[np.intp], behind_m: float, reach: Floats, fewest: NDArray[np.intp]
) -> None:
    """Enter the predictions (n, c) of one displaced copy of every pose into `reach` (n, u) and `fewest` (n,).

    `entry` (c,) is the index among the u beams of each column; -1 for a column that is not compared.
    """
    for pose in range(len(ranges)):
        returns = 0
        for column in range(len(entry)):
            if entry[column] >= 0 and ranges[pose, column] < np.inf:
                returns += 1
                beam = entry[column]
                reach[pose, beam] = max(reach[pose, beam], ranges[pose, column] + behind_m)
        fewest[pose] = min(fewest[pose], returns)


@kernel
def _farthest(reach: Floats, possible: NDArray[np.bool_]) -> Floats:
    """The greatest of `reach` (n, u) over the possible poses (n,), for each beam, (u,)."""
    farthest = np.full(reach.shape[1], -np.inf)
    for pose in range(len(reach)):
        if possible[pose]:
            for beam in range(len(farthest)):
                farthest[beam] = max(farthest[beam], reach[pose, beam])
    return farthest
