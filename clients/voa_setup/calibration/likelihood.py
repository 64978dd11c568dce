"""Likelihood of scans given the pose of the lidar, relative to a room in which the object is not there.

Only beams that are predicted to meet the object count. With the difference d of measured and predicted range, such a
beam has the logarithm of `(1 - e) N(d; sigma) / u + e`: a return of the object, normally distributed, or (e) of
something else, evenly distributed with the density u. A return far behind the predicted one, or none, has `ln e`; one
far in front was hidden and says nothing. A pose thus gains by every return that it explains.
"""

import numpy as np

from voa_setup.calibration.planar import Floats
from voa_setup.calibration.stops import Measured

_OTHERWISE = 0.05
_DENSITY_PER_M = 1.0
_HIDDEN_M = 0.1
_AT_ONCE = 2048


def log_likelihoods(measured: Measured, lidars: Floats, sigma_m: float, range_max: float) -> Floats:
    """Compute the log-likelihood ratio of a scan for poses of the lidar.

    Args:
        measured: the scan, and the object at its pose.
        lidars: (k, 3) x, y, yaw of the lidar in the world.
        sigma_m: standard deviation of the ranges, metres.
        range_max: of the lidar, metres.

    Returns:
        (k,) nats; 0 where the object is not in range of any beam.
    """
    parts = [
        _log_likelihoods(measured, lidars[start : start + _AT_ONCE], sigma_m, range_max)
        for start in range(0, len(lidars), _AT_ONCE)
    ]
    return np.concatenate(parts)


def _log_likelihoods(measured: Measured, lidars: Floats, sigma_m: float, range_max: float) -> Floats:
    predicted = measured.target.ranges(lidars, measured.grid, range_max)
    columns = np.flatnonzero(np.isfinite(predicted).any(axis=0) & ~np.isnan(measured.ranges))
    predicted = predicted[:, columns]
    hit = np.isfinite(predicted)
    off = measured.ranges[columns] - np.where(hit, predicted, 0.0)
    near = np.abs(off) <= _HIDDEN_M
    normal = np.exp(-0.5 * (np.where(near, off, 0.0) / sigma_m) ** 2) / (np.sqrt(2.0 * np.pi) * sigma_m)
    ratio = np.where(near, (1.0 - _OTHERWISE) * normal / _DENSITY_PER_M, 0.0) + _OTHERWISE
    return np.asarray(np.where(hit & (off >= -_HIDDEN_M), np.log(ratio), 0.0).sum(axis=1), dtype=np.float64)


def residuals(measured: Measured, lidar: Floats, within_m: float, range_max: float) -> Floats:
    """Return the differences of measured and predicted ranges, metres, of the beams on which they are close."""
    predicted = measured.target.ranges(lidar[None, :], measured.grid, range_max)[0]
    with np.errstate(invalid="ignore"):
        off = measured.ranges - predicted
    return np.asarray(off[np.abs(off) <= within_m], dtype=np.float64)
