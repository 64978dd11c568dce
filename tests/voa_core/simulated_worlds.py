"""A small world of displaced poses, and the values of looks in it by brute force, written from the page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import ndtri

from tests.support import twin
from tests.voa_core.worlds import as_lists, box, parameters_of
from voa_core.checks import Floats
from voa_core.displacements import Spread, standard_normal_points
from voa_core.geometry import quaternion_of_matrix, turn
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scan_model import ScanModel
from voa_core.simulation import Sampling, name_of_place
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace

OBJECT = box(0.12, 0.05, 0.2)
LIDAR = LidarModel(BeamGrid(72, 0.0, math.radians(5.0)), 0.1, 2.0, 0.1, "missing", 0.004, 0.02, 0.05)
POSITIONS = [(0.0, 0.0), (0.05, 0.02), (-0.04, 0.06), (0.0, 0.0), (0.03, -0.05)]
YAWS = [0.0, 0.7, 1.6, 2.4, 3.9]
POSES = PoseSet.from_arrays(
    [f"P{i}" for i in range(5)],
    [(x, y, 0.0) for x, y in POSITIONS],
    [quaternion_of_matrix(turn(yaw)) for yaw in YAWS],
)
NEAR = SensorConfiguration("near", -0.3, 0.05, 0.1)
FAR = SensorConfiguration("far", 0.1, 0.45, -1.4, cost=0.02)
PLACES = (NEAR, FAR)
SCORES = np.array([[0.9, 0.2, 0.1, 0.6, 0.3], [0.1, 0.8, 0.3, 0.2, 0.7], [0.4, 0.4, 0.9, 0.4, 0.4]])
SPREAD = Spread(0.01, 0.08)
STD = SensorUncertainty(0.006, 0.03)
SAMPLING = Sampling("seed", 3)


@dataclass(frozen=True)
class PlainGaussian:
    """Update rule w = exp(-d^2 / (2 sigma^2)) without compiled loops, for the many scans of statistics."""

    no_return_m: float = 1.0
    sigma_m: float = 0.05

    def statistic(self, observed: Any, predicted: Any) -> Any:
        seen, expected = (np.minimum(ranges, self.no_return_m) for ranges in (observed, predicted))
        return ((seen[:, None, :] - expected[None, :, :]) ** 2).sum(axis=2)

    def statistic_among(self, ranges: Any) -> Any:
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Any, _beams: int, /) -> Any:
        return -0.5 * statistic / self.sigma_m**2


def moved(displacements: Floats) -> PoseSet:
    """The poses, each in its displaced copies (n, J, 3), as poses of their own."""
    names, positions, quaternions = [], [], []
    for pose, copies in enumerate(displacements):
        for copy, (dx, dy, yaw) in enumerate(copies):
            names.append(f"{pose}/{copy}")
            positions.append((POSITIONS[pose][0] + dx, POSITIONS[pose][1] + dy, 0.0))
            quaternions.append(quaternion_of_matrix(turn(YAWS[pose] + yaw)))
    return PoseSet.from_arrays(names, positions, quaternions)


def seen_errors(sensor: SensorConfiguration, std: SensorUncertainty) -> Floats:
    """Covariance (n, 3, 3) of the displacement of each pose that an error of the sensor looks like."""
    own = np.diag([std.xy_m**2, std.xy_m**2, std.yaw_rad**2])
    jacobians = [np.array([[-1, 0, y - sensor.y], [0, -1, sensor.x - x], [0, 0, -1.0]]) for x, y in POSITIONS]
    return np.array([jacobian @ own @ jacobian.T for jacobian in jacobians])


@dataclass
class BruteForce:
    """Values of looks by loops over samples, scans, poses, copies and beams."""

    rule: str
    copies: int
    sampling: Sampling = SAMPLING
    spread: Spread = SPREAD
    std: SensorUncertainty = STD
    policy: UpdatePolicy = field(default_factory=UpdatePolicy)
    workspace: Workspace | None = None
    rule_parameters: dict[str, float] = field(default_factory=dict)

    @property
    def model(self) -> ScanModel:
        return ScanModel(
            predictor_of_mesh(OBJECT, POSES, LIDAR),
            rule_of(self.rule, LIDAR, **self.rule_parameters),
            self.policy,
            self.sampling.seed,
            self.workspace,
            self.spread,
            self.std,
        )

    def displacements(self, sensor: SensorConfiguration) -> Floats:
        points = standard_normal_points(self.copies, self.sampling.seed)
        own = np.diag([self.spread.xy_m**2, self.spread.xy_m**2, self.spread.yaw_rad**2])
        roots = np.linalg.cholesky(own + seen_errors(sensor, self.std))
        return np.array([points @ root.T for root in roots])

    def within(self, sensor: SensorConfiguration) -> list[tuple[float, float] | str | None]:
        if self.workspace is None:
            return ["everywhere"] * LIDAR.grid.beams
        box_ = (self.workspace.min, self.workspace.max)
        return [twin.crossing(sensor.x, sensor.y, sensor.yaw_rad + angle, box_) for angle in LIDAR.grid.angles]

    def predicted(self, sensor: SensorConfiguration, displacements: Floats) -> Floats:
        return predictor_of_mesh(OBJECT, moved(displacements), LIDAR).predict(sensor).dense()

    def copies_of(self, sensor: SensorConfiguration) -> list[list[list[float]]]:
        """Predicted scan of each copy of each pose, as it is compared."""
        exact = self.predicted(sensor, self.displacements(sensor)).reshape(len(POSES), self.copies, -1)
        limits = self.within(sensor)
        return [
            [
                [
                    twin.restrict_predicted(value, LIDAR.range_max, limit)  # type: ignore[arg-type] # the twin takes plain lists
                    for value, limit in zip(scan, limits, strict=True)
                ]
                for scan in as_lists(of_pose)
            ]
            for of_pose in exact
        ]

    def scans(self, sensor: SensorConfiguration, log_sums: Floats | None, looks: int) -> list[list[list[float]]]:
        """Simulated scans: for each sample of each pose, so many in a row."""
        samples, place = self.sampling.samples, name_of_place(sensor, listed=False)
        uniforms = self.sampling.uniforms(POSES, place)
        normal = ndtri(uniforms[:, :, :6])
        own = np.array([self.spread.xy_m, self.spread.xy_m, self.spread.yaw_rad])
        roots = np.linalg.cholesky(seen_errors(sensor, self.std))
        drawn = normal[:, :, :3] * own + np.einsum("nab,nkb->nka", roots, normal[:, :, 3:])
        if log_sums is not None:
            for pose in range(len(POSES)):
                shares = np.exp(log_sums[pose]) / np.exp(log_sums[pose]).sum()
                for sample in range(samples):
                    index = int(np.searchsorted(np.cumsum(shares), uniforms[pose, sample, 6], side="right"))
                    points = self.displacements(sensor)[pose]
                    root = np.linalg.cholesky(np.cov(points.T, bias=True))
                    share = 1.2 / self.copies ** (1 / 3)
                    drawn[pose, sample] = points.mean(axis=0) + share * root @ normal[pose, sample, 3:]
                    drawn[pose, sample] += math.sqrt(1 - share**2) * (points[index] - points.mean(axis=0))
        exact = self.predicted(sensor, drawn)
        columns = np.flatnonzero(np.isfinite(exact).any(axis=0))
        result: list[list[list[float]]] = [[] for _ in exact]
        for look in range(looks):
            noise = np.zeros(exact.shape)
            noise[:, columns] = self.sampling.noise(POSES, place, look, len(columns)).reshape(len(exact), -1)
            for row, (scan, off) in enumerate(zip(as_lists(exact), as_lists(noise), strict=True)):
                beams = []
                for value, z, limit in zip(scan, off, self.within(sensor), strict=True):
                    std = max(LIDAR.noise_m, LIDAR.noise_ratio * value) if value < math.inf else 0.0
                    measured = value + z * std if value < math.inf else math.inf
                    beams.append(
                        twin.classify_beam(
                            measured,
                            declared_no_return=False,
                            zero="missing",
                            range_min=LIDAR.range_min,
                            range_max=LIDAR.range_max,
                            within=limit,  # type: ignore[arg-type] # the twin takes plain lists
                        )
                    )
                result[row].append(beams)
        return result

    def after(
        self, plan: Sequence[tuple[SensorConfiguration, int]], belief: Floats, history: dict[str, Floats]
    ) -> list[list[float]]:
        """Belief after the scans of a plan, of each sample of each pose: places in order, so many scans at each."""
        parameters = parameters_of(self.rule, LIDAR, **self.rule_parameters)
        beliefs = [list(belief) for _ in range(len(POSES) * self.sampling.samples)]
        for sensor, looks in plan:
            copies = self.copies_of(sensor)
            logs = history.get(sensor.name)
            scans = self.scans(sensor, logs, looks)
            for row, some in enumerate(scans):
                sums = np.zeros((len(POSES), self.copies)) if logs is None else logs.copy()
                before = beliefs[row]
                for scan in some:
                    weights = [[twin.log_weight(self.rule, parameters, scan, copy) for copy in own] for own in copies]
                    away = [min(twin.distance(scan, copy, parameters["no_return_m"]) for copy in own) for own in copies]
                    means = [
                        (twin.log_mean_weight(list(old)), twin.log_mean_weight(list(old + np.array(new))))
                        for old, new in zip(sums, weights, strict=True)
                    ]
                    ratio = [new - old if old > -math.inf else -math.inf for old, new in means]
                    compared = len(twin.compared(scan))
                    own_means = [twin.log_mean_weight(of_pose) for of_pose in weights]
                    if compared:
                        fit = 1e3 * away[twin.best_fit(own_means, away)] / math.sqrt(compared)
                    refused = (
                        not compared
                        or twin.misses_object(scan, copies, list(belief), self.workspace is not None)
                        or (self.policy.reject_above_rmsd_mm or math.inf) < fit
                    )
                    if refused:
                        continue
                    updated = twin.update(before, ratio, away, compared, on_no_match=self.policy.on_no_match)
                    before = updated.belief
                    if updated.reason == "nearest":
                        sums = np.zeros_like(sums)
                    elif updated.accepted:
                        sums = sums + np.array(weights)
                beliefs[row] = before
        return beliefs

    def value(
        self,
        plan: Sequence[tuple[SensorConfiguration, int]],
        belief: Floats,
        *,
        definition: str = "executed",
        sensor_belief: Floats | None = None,
        pending: Sequence[tuple[SensorConfiguration, int]] = (),
        history: dict[str, Floats] | None = None,
    ) -> tuple[float, float]:
        """VOA of a plan that includes the pending scans, and its standard error."""
        table, history = as_lists(SCORES), history or {}
        outer = belief if sensor_belief is None else sensor_belief
        without = self.after(pending, belief, history)
        after = self.after(plan, belief, history)
        samples = self.sampling.samples
        total, square = 0.0, 0.0
        for pose in range(len(POSES)):
            gains = []
            for sample in range(samples):
                scores = []
                for beliefs in (after, without):
                    grasp, score = twin.best_grasp(table, beliefs[pose * samples + sample])
                    scores.append(twin.score_at(table, grasp, pose) if definition == "executed" else score)
                gains.append(scores[0] - scores[1])
            total += outer[pose] * sum(gains) / samples
            # And one scan more over all poses, after which nothing is gained.
            more = outer[pose]
            mean = sum(gains) / (samples + more)
            variance = (sum((gain - mean) ** 2 for gain in gains) + more * mean**2) / (samples - 1 + more)
            square += outer[pose] ** 2 * variance / samples
        return total, math.sqrt(square)
