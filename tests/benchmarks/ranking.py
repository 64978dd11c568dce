"""Proves that ranking looks is bound by one matrix product per sensor, and near what this machine can multiply.

64 sensors x 500 poses, 20 and 100 grasps, from kept weights; the VOA of every sensor under one belief. Peers:

* a straightforward numpy loop over sensors: posteriors, expected scores, best of each;
* filterpy: `discrete_bayes.update` for every outcome, measured on two sensors and scaled up;
* a large square matrix product in the same run: what share of its operations per second ours reaches, in percent.

In the same run the values are compared with those of the numpy loop.
"""

from functools import partial

import numpy as np
from filterpy import discrete_bayes

from tests.benchmarks import scene
from tests.benchmarks.measure import Result, faster, interleaved, require
from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.kernels import Array
from voa_core.lidars import SensorConfiguration
from voa_core.ranking import Ranking, rank
from voa_core.rules.registry import rule_of
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

_POSES, _SENSORS = 500, 64
_SHARE = 2
_PRODUCT = 1024
_TOLERANCE: dict[type[np.floating], float] = {np.float64: 1e-12, np.float32: 1e-5}


def run() -> list[Result]:
    """Two numbers of grasps, both precisions, three peers."""
    rule, predictions = rule_of("exponential", scene.LIDAR), scene.predictions(_POSES, _SENSORS)
    sensors = scene.sensors(_SENSORS)
    results = []
    for dtype in _TOLERANCE:
        weighers = [Weigher.of(rule, prediction, dtype, keep=True) for prediction in predictions]
        for grasps in (20, 100):
            results += _ranking(dict(zip(sensors, weighers, strict=True)), grasps, dtype)
    return results


def _ranking(weighers: dict[SensorConfiguration, Weigher], grasps: int, dtype: type[np.floating]) -> list[Result]:
    belief = Belief.of(scene.belief(_POSES))
    table = GraspTable.of_probabilities([f"G{x}" for x in range(grasps)], scene.scores(grasps, _POSES), _POSES)
    kept = [_dense(weigher) for weigher in weighers.values()]
    b, q = belief.p.astype(dtype), table.scores.astype(dtype)

    voas = {look.sensor: look.assistance.voa for look in _ours(weighers, belief, table).looks}
    off = np.abs(np.array([voas[sensor] for sensor in weighers]) - _by_numpy(kept, b, q)).max()
    require(off <= _TOLERANCE[dtype], f"values differ from numpy's by {off}")
    square = np.random.default_rng(5).random((_PRODUCT, _PRODUCT)).astype(dtype)
    ours, numpy_s, filterpy_s, product_s = interleaved(
        [
            partial(_ours, weighers, belief, table),
            partial(_by_numpy, kept, b, q),
            partial(_by_filterpy, kept[:_SHARE], belief.p, table.scores),
            partial(np.matmul, square, square),
        ]
    )
    what = f"ranking, {grasps} grasps, {dtype.__name__}"
    work = 2.0 * _SENSORS * _POSES * _POSES * (grasps + 1) * 1e-9
    reached, peak = work / ours, 2.0 * _PRODUCT**3 * 1e-9 / product_s
    return [
        faster(f"{what} / numpy loop", ours, numpy_s),
        faster(f"{what} / filterpy loop (scaled)", ours, filterpy_s * _SENSORS / _SHARE),
        Result(f"{what}, percent of the {_gemm(dtype)} peak", 100.0 * reached / peak, reached, peak, "GFLOP/s"),
    ]


def _ours(weighers: dict[SensorConfiguration, Weigher], belief: Belief, table: GraspTable) -> Ranking:
    return rank(list(weighers), weighers.__getitem__, belief, table, UpdatePolicy())


def _dense(weigher: Weigher) -> Array:
    """Kept weights (n, n) in the order in which numpy multiplies them the fastest: in float32 column by column."""
    every = np.arange(_POSES)
    weights = weigher.weights(every, every)
    return np.asfortranarray(weights) if weigher.dtype == np.float32 else weights


def _by_numpy(kept: list[Array], b: Array, q: Array) -> Floats:
    """VOA of each sensor, (k,)."""
    before = (q @ b).max()
    values = []
    for weights in kept:
        posteriors = weights * b
        posteriors /= posteriors.sum(axis=1, keepdims=True)
        values.append(b @ (posteriors @ q.T).max(axis=1) - before)
    return np.array(values, dtype=np.float64)


def _by_filterpy(kept: list[Array], b: Floats, q: Floats) -> list[float]:
    values = []
    for weights in kept:
        after = [(q @ discrete_bayes.update(row, b)).max() for row in weights]
        values.append(float(b @ np.array(after) - (q @ b).max()))
    return values


def _gemm(dtype: type[np.floating]) -> str:
    return {"float32": "sgemm", "float64": "dgemm"}[dtype.__name__]
