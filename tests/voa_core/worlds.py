"""Small worlds for the tests of the core: meshes, lidars, and random scenarios with predictions given as data."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Prediction, predictor_of_mesh
from voa_core.rules.protocol import UpdateRule
from voa_core.rules.registry import RULES, defaults, rule_of
from voa_core.sight import BEHIND_M, Returns, Sight
from voa_core.updating import OnNoMatch, UpdatePolicy
from voa_core.weights import Weigher

RULE_NAMES = sorted(RULES)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
HERE = SensorConfiguration("here", 0.0, 0.0, 0.0)

BOX_FACES = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
]


def box(x: float, y: float, z: float) -> Object:
    """A box of these sides, its lowest corner at the origin."""
    corners = [[i * x, j * y, k * z] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return Object.from_arrays(corners, BOX_FACES)


def lidar_of(
    beams: int = 8,
    *,
    increment: float | None = None,
    start: float = 0.0,
    height: float | None = 0.1,
    range_max: float = 2.0,
) -> LidarModel:
    """A lidar whose beams share one turn, unless `increment` says otherwise."""
    spacing = 2.0 * math.pi / beams if increment is None else increment
    return LidarModel(BeamGrid(beams, start, spacing), 0.1, range_max, height, "missing", 0.01, 0.02, 0.05)


def standing(*positions: Sequence[float]) -> PoseSet:
    """Upright poses "P0", "P1", ... at these positions."""
    names = [f"P{i}" for i in range(len(positions))]
    return PoseSet.from_arrays(names, positions, [UPRIGHT] * len(positions))


def scanned(
    object_: Object,
    sensor: SensorConfiguration,
    lidar: LidarModel,
    poses: PoseSet | None = None,
) -> Floats:
    """Predicted ranges (n, r); one pose at the origin by default."""
    placed = standing((0.0, 0.0, 0.0)) if poses is None else poses
    return predictor_of_mesh(object_, placed, lidar).predict(sensor).dense()


def data_predictor(ranges: Floats, lidar: LidarModel) -> ObservationPredictor:
    """Predictions (n, r) given as data, for the sensor `HERE`."""
    poses = PoseSet.named([f"P{i}" for i in range(len(ranges))])
    return ObservationPredictor(poses, lidar, {HERE.name: ranges})


def diagonal(rng: np.random.Generator, n: int) -> Floats:
    """(n, 4) ranges of which no two agree within a margin of 8 mm on every beam."""
    ranges: Floats = rng.uniform(0.2, 1.9, (n, 4))
    ranges[:, 0] = 0.3 + 0.05 * rng.permutation(n)
    return ranges


@dataclass(frozen=True)
class World:
    """A random scenario: predictions as data, one sensor configuration, and what a ranking needs."""

    rule_name: str
    parameters: dict[str, float]
    lidar: LidarModel
    ranges: Floats
    scores: Floats
    belief: Floats
    sensor_belief: Floats | None
    on_no_match: OnNoMatch

    @property
    def rule(self) -> UpdateRule:
        own = {k: v for k, v in self.parameters.items() if k not in {"range_max", "noise_ratio"}}
        return rule_of(self.rule_name, self.lidar, **own)

    @property
    def policy(self) -> UpdatePolicy:
        return UpdatePolicy(self.on_no_match)

    @property
    def table(self) -> GraspTable:
        return GraspTable.of_probabilities([f"G{x}" for x in range(len(self.scores))], self.scores, len(self.belief))

    @property
    def sensor(self) -> Belief | None:
        return None if self.sensor_belief is None else Belief.of(self.sensor_belief)

    def weigher(self, dtype: type[np.floating] = np.float64, *, keep: bool = True) -> Weigher:
        return Weigher.of(self.rule, Prediction.of_dense(self.lidar.grid, self.ranges), dtype, keep=keep)


def parameters_of(name: str, lidar: LidarModel, **changed: float) -> dict[str, float]:
    """Every number that the twin needs for a rule."""
    return {**defaults(name, lidar), "range_max": lidar.range_max, "noise_ratio": lidar.noise_ratio, **changed}


def random_belief(rng: np.random.Generator, n: int, support: int) -> Floats:
    """(n,) with `support` entries above 0."""
    belief: Floats = np.zeros(n)
    belief[rng.permutation(n)[:support]] = rng.uniform(0.05, 1.0, support)
    belief /= belief.sum()
    return belief


def random_ranges(rng: np.random.Generator, n: int, r: int, kinds: int) -> Floats:
    """(n, r) ranges below 1.5 m or inf; of `kinds` sorts, so that margins match off the diagonal too."""
    sorts = rng.uniform(0.15, 1.5, (kinds, r))
    sorts[rng.uniform(size=sorts.shape) < 0.3] = np.inf
    wobble = rng.integers(-3, 4, (n, r)) / 512.0  # no sum of these comes near a margin of 8 mm
    ranges: Floats = sorts[rng.integers(0, kinds, n)] + wobble
    return ranges


@st.composite
def worlds(draw: st.DrawFn, rule_name: str) -> World:
    """A random world under the rule; beliefs have zeros, supports may not meet, scans may repeat."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, m, r = draw(st.integers(1, 7)), draw(st.integers(1, 4)), draw(st.integers(1, 6))
    lidar = lidar_of(r, range_max=2.0)
    parameters = parameters_of(rule_name, lidar, no_return_m=draw(st.sampled_from([0.9, 1.0, 2.0])))
    if rule_name == "gaussian":
        parameters["sigma_m"] = draw(st.sampled_from([0.1, 1.0]))
    scores = rng.uniform(0.0, 1.0, (m, n))
    scores[rng.uniform(size=scores.shape) < draw(st.sampled_from([0.0, 0.4, 1.0]))] = 0.0
    other = random_belief(rng, n, draw(st.integers(1, n))) if draw(st.booleans()) else None
    return World(
        rule_name,
        parameters,
        lidar,
        random_ranges(rng, n, r, draw(st.integers(1, n))),
        scores,
        random_belief(rng, n, draw(st.integers(1, n))),
        other,
        draw(st.sampled_from(["reject", "nearest"])),
    )


def as_lists(array: NDArray[np.float64]) -> list[list[float]]:
    return [[float(value) for value in row] for row in array]


def sight_at_half_a_metre(measured: Floats, fewest: NDArray[np.intp]) -> Sight:
    """Sight of classified beams (r,), on each of which each of n poses returns at 0.5 m; `fewest` (n,) is as stated."""
    r, n = len(measured), len(fewest)
    returns = Returns(np.arange(n + 1) * r, np.zeros(n, dtype=np.int64), np.arange(r), np.full(n * r, 0.5))
    return Sight(measured, returns, BEHIND_M, fewest)
