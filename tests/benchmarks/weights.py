"""Proves that the weights between all predicted scans are quick to make, so that new sensor poses can be ranked.

64 sensors x 500 poses of the 10k cup: 64 matrices of 500 x 500. Ours sees the columns on which some pose returns and
computes one triangle. Peers:

* `exponential`: scipy's cdist over the whole scans (360 beams, a no-return coded as `range_max`), then exp(-d);
* `beam`: the formula of `rules.Beam` in vectorised numpy, on the same few columns as ours, one observed scan at
  a time; measured on a tenth of the rows of two sensors and scaled up.

In the same run the weights are compared with the peers'.
"""

import math
from functools import partial

import numpy as np
from scipy.spatial.distance import cdist

from tests.benchmarks import scene
from tests.benchmarks.measure import Result, faster, interleaved, require
from voa_core.checks import Floats
from voa_core.prediction import Prediction
from voa_core.rules.beam import Beam
from voa_core.rules.protocol import UpdateRule
from voa_core.rules.registry import rule_of
from voa_core.weights import Weigher

_POSES, _SENSORS = 500, 64
_SHARE_SENSORS, _SHARE_ROWS = 2, 50
_EVERY = np.arange(_POSES)
_TOLERANCE: dict[type[np.floating], float] = {np.float64: 1e-12, np.float32: 1e-5}


def run() -> list[Result]:
    """Two rules in both precisions."""
    predictions = scene.predictions(_POSES, _SENSORS)
    return [*_exponential(predictions), *_beam(predictions)]


def _exponential(predictions: list[Prediction]) -> list[Result]:
    rule = rule_of("exponential", scene.LIDAR)
    whole = [np.minimum(prediction.dense(), scene.LIDAR.range_max) for prediction in predictions]
    results = []
    for dtype, tolerance in _TOLERANCE.items():
        weights = Weigher.of(rule, predictions[0], dtype, keep=True).weights(_EVERY, _EVERY)
        require(np.abs(weights - _by_cdist(whole[0])).max() <= tolerance, "weights differ from cdist's")
        ours, peer = interleaved(
            [partial(_ours, rule, predictions, dtype), lambda: [_by_cdist(ranges) for ranges in whole]], rounds=3
        )
        results.append(faster(f"weights, exponential, {dtype.__name__} / scipy cdist", ours, peer))
    return results


def _beam(predictions: list[Prediction]) -> list[Result]:
    rule = rule_of("beam", scene.LIDAR)
    assert isinstance(rule, Beam)
    share = [prediction.ranges for prediction in predictions[:_SHARE_SENSORS]]
    scale = (_SENSORS / _SHARE_SENSORS) * (_POSES / _SHARE_ROWS)
    results = []
    for dtype, tolerance in _TOLERANCE.items():
        weights = Weigher.of(rule, predictions[0], dtype, keep=True).weights(_EVERY, _EVERY)
        off = np.abs(weights[:_SHARE_ROWS] - _by_numpy(rule, share[0])).max()
        require(off <= tolerance, f"beam weights differ from numpy's by {off}")
        ours, peer = interleaved(
            [partial(_ours, rule, predictions, dtype), lambda: [_by_numpy(rule, ranges) for ranges in share]], rounds=3
        )
        results.append(faster(f"weights, beam, {dtype.__name__} / numpy (scaled)", ours, scale * peer))
    return results


def _ours(rule: UpdateRule, predictions: list[Prediction], dtype: type[np.floating]) -> None:
    for prediction in predictions:
        Weigher.of(rule, prediction, dtype, keep=True)


def _by_cdist(ranges: Floats) -> Floats:
    weights: Floats = np.exp(-cdist(ranges, ranges))
    return weights


def _by_numpy(rule: Beam, ranges: Floats) -> Floats:
    """Weights (_SHARE_ROWS, n), each row scaled to a maximum of 1."""
    total = rule.z_hit + rule.z_short + rule.z_no_return + rule.z_random
    hit, short, lost, random = (z / total for z in (rule.z_hit, rule.z_short, rule.z_no_return, rule.z_random))
    z_max, decay = rule.range_max, rule.lambda_short_per_m
    none = np.isinf(ranges)
    expected = np.where(none, z_max, ranges)
    sigma = np.maximum(rule.sigma_hit_m, rule.noise_ratio * expected)
    peak = hit / (math.sqrt(2.0 * math.pi) * sigma)
    cut_off = np.maximum(-np.expm1(-decay * expected), 1e-12)
    rows = []
    for scan in ranges[:_SHARE_ROWS]:
        seen = np.where(np.isinf(scan), z_max, scan)
        before = short * decay * np.exp(-decay * seen) / cut_off
        near = peak * np.exp(-0.5 * ((seen - expected) / sigma) ** 2)
        density = np.where(none, 0.5 * hit / z_max, near) + np.where(seen <= expected, before, 0.0) + random / z_max
        nothing = np.where(none, 0.5 * hit + lost, lost)
        rows.append(rule.temper * np.log(np.where(np.isinf(scan), nothing, density)).sum(axis=1))
    logs = np.stack(rows)
    weights: Floats = np.exp(logs - logs.max(axis=1, keepdims=True))
    return weights
