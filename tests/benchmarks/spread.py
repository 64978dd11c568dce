"""Proves what a spread costs: 64 displaced copies of each of 500 poses, against poses that are exact, in the same run.

The weights of 256 scans, as many as the service simulates at a place for up to 256 poses, against the exact weights.
Then the first ranking as the service does it, with a scan of each of the 500 poses: predictions, weights and a belief.
Both are on eight of 64 sensors, a place at a time. Then another belief on the kept weights, and a scan update, with the
predictions remembered and without. `ours` is with the spread, `peer` without; the ratio is how many times dearer the
spread is.
"""

from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tests.benchmarks import scene
from tests.benchmarks.measure import Result, interleaved
from voa_core.assistance import Valuation
from voa_core.choices import LookWeights
from voa_core.displacements import Spread
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import defaults, rule_of
from voa_core.scan_model import ScanModel
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling, samples_per_pose
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

_POSES, _SENSORS, _GRASPS = 500, 8, 20
_SCANS = 256
_SPREAD = Spread(0.005, np.radians(3.0))


def run() -> list[Result]:
    """The rule for live robots and the rule of the preliminary paper."""
    return [result for rule in ("beam", "inverse_rmsd") for result in _of_rule(rule)]


def _of_rule(name: str) -> list[Result]:
    exact, vague = _scenario(name, None), _scenario(name, _SPREAD)
    model = ScanModel.of(vague)
    sampling = Sampling(vague.seed, samples_per_pose(_POSES))

    def first(look_of: Callable[[int], LookWeights], definition: Any) -> None:
        for index in range(_SENSORS):
            _value(exact, look_of(index), definition)

    def simulated(index: int) -> SimulatedWeights:
        return SimulatedWeights.of(model, vague.sensors[index], sampling, listed=True)

    def predicted(index: int) -> LookWeights:
        return exact.weigher(exact.sensors[index], np.float64, keep=True)

    kept = [simulated(index) for index in range(_SENSORS)], [predicted(index) for index in range(_SENSORS)]
    measured = exact.predictor.predict(exact.sensors[0]).dense()[0] + 0.002
    scan = Scan(measured, scene.LIDAR.grid)
    remembering = [replace(each, predictor=replace(each.predictor, remember=_memory())) for each in (vague, exact)]
    rows, poses = np.arange(_SCANS) * _POSES // _SCANS, np.arange(_POSES)
    bare = [_without_weights(model, sensor, look) for sensor, look in zip(vague.sensors, kept[0], strict=True)]
    predictions = [exact.predictor.predict(sensor) for sensor in exact.sensors]
    times = interleaved(
        [
            lambda: [look.weights(rows, poses) for look in bare],
            lambda: [Weigher.of(exact.rule, prediction, np.float64, keep=True) for prediction in predictions],
            partial(first, simulated, "executed"),
            partial(first, predicted, "posterior"),
            partial(first, kept[0].__getitem__, "executed"),
            partial(first, kept[1].__getitem__, "posterior"),
            partial(vague.evidence, scan, vague.sensors[0]),
            partial(exact.evidence, scan, exact.sensors[0]),
            partial(remembering[0].evidence, scan, vague.sensors[0]),
            partial(remembering[1].evidence, scan, exact.sensors[0]),
        ],
        rounds=3,
    )
    names = (
        f"weights of {_SCANS} scans, a place",
        "first ranking, a place",
        "ranking, another belief, a place",
        "scan update, fresh",
        "scan update, remembered",
    )
    return [
        Result(f"spread, {name}: {what} / without", own / peer, 1e3 * own / count, 1e3 * peer / count, "ms")
        for what, own, peer, count in zip(names, times[::2], times[1::2], (_SENSORS,) * 3 + (1, 1), strict=True)
    ]


def _without_weights(model: ScanModel, sensor: SensorConfiguration, look: SimulatedWeights) -> SimulatedWeights:
    """Keep the scans and the predictions of a look, so that its weights are computed each time."""
    displacements = model.displacements(sensor, 1)
    return replace(look, matrix=None, copies=model.copies(sensor, displacements, listed=True, keep=True))


def _scenario(name: str, spread: Spread | None) -> Scenario:
    object_ = scene.cup("10k")
    poses = scene.poses(object_, _POSES, planar=True)
    return Scenario(
        poses,
        GraspTable.of_probabilities([f"G{x}" for x in range(_GRASPS)], scene.scores(_GRASPS, _POSES), _POSES),
        tuple(scene.sensors(_SENSORS)),
        predictor_of_mesh(object_, poses, scene.LIDAR),
        rule_of(name, scene.LIDAR, **defaults(name, scene.LIDAR, spread=spread is not None)),
        UpdatePolicy(),
        Belief.of(scene.belief(_POSES)),
        spread=spread,
        seed="bench",
    )


def _value(scenario: Scenario, look: LookWeights, definition: Any) -> None:
    Valuation(scenario.prior, scenario.table, scenario.policy, definition).value(look)


def _memory() -> Callable[[Hashable, Callable[[], Any]], Any]:
    kept: dict[Hashable, Any] = {}

    def remember(key: Hashable, make: Callable[[], Any]) -> Any:
        if key not in kept:
            kept[key] = make()
        return kept[key]

    return remember
