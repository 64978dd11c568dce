"""Proves that the work grows as derived: a scan update with the poses, a ranking with poses squared and sensors.

Each line doubles n (poses) or k (sensors). The peer is the law: what the size before took, times the factor
that is derived for a doubling (2, 4 and 2). So 1 is growth exactly as derived, and more than 1 is slower growth:
fixed costs are spread wider. Far below 1 would be an algorithm, or a cache, that breaks.

The scan update is a raw scan from a pose that nothing was kept for: predict, compare, condition. The ranking is
over kept weights in float64, 20 grasps.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from tests.benchmarks import scene
from tests.benchmarks.measure import Call, Result, faster, interleaved
from voa_core.evidence import evidence_of_scan
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.prediction import predictor_of_mesh
from voa_core.ranking import rank
from voa_core.rules.registry import rule_of
from voa_core.scans import Scan
from voa_core.updating import UpdatePolicy, update
from voa_core.weights import Weigher

_POSES = (125, 250, 500, 1000, 2000)
_SENSORS = (8, 16, 32, 64)
_FEW_SENSORS, _FEW_POSES, _GRASPS = 4, 500, 20


def run() -> list[Result]:
    """Three laws."""
    return [
        *_growth("scan update, n = {}", _POSES, scan_update, 2.0),
        *_growth(f"ranking of {_FEW_SENSORS} sensors, n = {{}}", _POSES, partial(ranking, k=_FEW_SENSORS), 4.0),
        *_growth(f"ranking of {_FEW_POSES} poses, k = {{}}", _SENSORS, partial(ranking, _FEW_POSES), 2.0),
    ]


def _growth(name: str, sizes: Sequence[int], work: Callable[[int], Call], factor: float) -> list[Result]:
    """One result per doubling; `work(size)` is the call to time."""
    taken = interleaved([work(size) for size in sizes])
    return [
        faster(f"growth: {name.format(size)} / {factor:g} x the line before", taken[i + 1], factor * taken[i])
        for i, size in enumerate(sizes[1:])
    ]


def scan_update(n: int) -> Call:
    """Make the call that updates a belief over `n` poses by a scan from a pose that nothing was kept for."""
    object_ = scene.cup("10k")
    predictor = predictor_of_mesh(object_, scene.poses(object_, n, planar=True), scene.LIDAR)
    rule, sensor = rule_of("beam", scene.LIDAR), scene.sensors(1)[0]
    scan = Scan(predictor.predict(sensor).dense()[n // 2], scene.LIDAR.grid)
    belief = Belief.of(scene.belief(n))
    return lambda: update(belief, evidence_of_scan(scan, sensor, predictor, rule), UpdatePolicy())


def ranking(n: int, k: int, grasps: int = _GRASPS) -> Call:
    """Make the call that ranks `k` sensors over `n` poses and some grasps from kept weights."""
    rule, sensors = rule_of("exponential", scene.LIDAR), scene.sensors(k)
    weighers = [Weigher.of(rule, prediction, np.float64, keep=True) for prediction in scene.predictions(n, k)]
    by_sensor = dict(zip(sensors, weighers, strict=True))
    belief = Belief.of(scene.belief(n))
    table = GraspTable.of_probabilities([f"G{x}" for x in range(grasps)], scene.scores(grasps, n), n)
    return lambda: rank(sensors, by_sensor.__getitem__, belief, table, UpdatePolicy())
