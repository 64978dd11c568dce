"""What one scan says of every pose: a weight each, and how well the best of them fits."""

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rules import UpdateRule, coded, squared_distance
from voa_core.scans import NO_RETURN, Scan, classify, restrict_prediction
from voa_core.workspace import Workspace


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a scan says, whatever the belief.

    Attributes:
        log_weights: (n,) ln w of each pose.
        distances: (n,) d of each pose, metres.
        hit_rmsds: (n,) RMSD over the beams on which both return, metres; NaN where there is none.
        beams_compared: number of beams that are not missing.
    """

    log_weights: Floats
    distances: Floats
    hit_rmsds: Floats
    beams_compared: int

    @property
    def best_fit(self) -> int:
        """Index of the pose with the smallest RMSD, the first listed of equals."""
        return int(np.argmin(self.distances))

    @property
    def fit_rmsd_mm(self) -> float | None:
        """The smallest RMSD over all poses, millimetres; None where no beam is compared."""
        if self.beams_compared == 0:
            return None
        return 1e3 * float(self.distances.min()) / float(np.sqrt(self.beams_compared))

    @property
    def fit_hit_rmsd_mm(self) -> float | None:
        """The same over the beams on which both return; None where no pose has one."""
        known = self.hit_rmsds[~np.isnan(self.hit_rmsds)]
        return 1e3 * float(known.min()) if known.size else None


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
    """Compare a measured scan with what every pose predicts.

    With an uncertain sensor pose the weight is the mean over its sigma points, and a pose's distance is that
    of the sigma point at which it fits best. Which beam is a return is decided at the stated pose.

    Args:
        scan: as measured.
        sensor: where the lidar stood, or is thought to have stood.
        predictor: of the scenario.
        rule: how differences become weights.
        workspace: box outside which nothing counts.
        uncertainty: standard deviations of the sensor pose.
        listed: the sensor is one of the scenario's own configurations.

    Raises:
        NoMesh, BeamGridMismatch: as `ObservationPredictor.predict`.
    """
    lidar = predictor.lidar
    grid = lidar.grid if lidar.grid.agrees_with(scan.grid) else scan.grid
    crossing = workspace.crossing(sensor, grid.angles) if workspace else None
    beams = classify(scan, lidar, crossing)
    stands = uncertainty.sigma_points(sensor) if uncertainty else [sensor]
    each = [
        _compare(
            beams,
            restricted(predictor.predict(stand, grid, listed=listed), stand, scan, lidar, workspace),
            rule,
        )
        for stand in stands
    ]
    if len(each) == 1:
        return each[0]
    hits = np.stack([evidence.hit_rmsds for evidence in each])
    return Evidence(
        np.logaddexp.reduce([evidence.log_weights for evidence in each]) - np.log(len(each)),
        np.min([evidence.distances for evidence in each], axis=0),
        np.where(np.isnan(hits).all(axis=0), np.nan, np.min(np.where(np.isnan(hits), np.inf, hits), axis=0)),
        each[0].beams_compared,
    )


def restricted(
    prediction: Prediction,
    sensor: SensorConfiguration,
    scan: Scan | None,
    lidar: LidarModel,
    workspace: Workspace | None,
) -> Prediction:
    """A prediction as it is compared: within the scan's (else the lidar's) range and the workspace."""
    range_max = lidar.range_max if scan is None else scan.limits(lidar)[1]
    angles = prediction.grid.angles[prediction.columns]
    crossing = workspace.crossing(sensor, angles) if workspace else None
    return Prediction(prediction.grid, prediction.columns, restrict_prediction(prediction.ranges, range_max, crossing))


def _compare(beams: Floats, prediction: Prediction, rule: UpdateRule) -> Evidence:
    """One scan, classified (r,), against the scans predicted for every pose at one sensor pose."""
    known = ~np.isnan(beams)
    compared = int(known.sum())
    if compared == 0:
        nothing = np.zeros(len(prediction.ranges))
        return Evidence(nothing, nothing, np.full(len(nothing), np.nan), 0)
    kept = known[prediction.columns]
    observed = np.ascontiguousarray(beams[prediction.columns][kept])[None, :]
    predicted = np.ascontiguousarray(prediction.ranges[:, kept])
    # On every other beam all poses predict the same, nothing: one comparison serves them all.
    known[prediction.columns] = False
    rest = beams[known][None, :]
    nothing = np.full_like(rest, NO_RETURN)
    statistic = rule.statistic(observed, predicted)[0] + rule.statistic(rest, nothing)[0, 0]
    square = (
        squared_distance(observed, predicted, rule.no_return_m)[0]
        + squared_distance(rest, nothing, rule.no_return_m)[0, 0]
    )
    return Evidence(
        rule.log_weights(statistic, compared),
        np.sqrt(square),
        _hit_rmsds(
            coded(observed, rule.no_return_m),
            coded(predicted, rule.no_return_m),
            np.isfinite(observed) & np.isfinite(predicted),
        ),
        compared,
    )


def _hit_rmsds(observed: Floats, predicted: Floats, both: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> Floats:
    count = both.sum(axis=1)
    square = np.where(both, (observed - predicted) ** 2, 0.0).sum(axis=1)
    return np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)
