"""The mathematics once more, slow and obvious: written from the paper and deploy/docs/mathematics.md, for tests only.

It shares no code with `voa_core`: plain numbers, lists and loops. A beam is a float: its range for a return, `inf`
for a no-return, NaN for a missing beam. Weights are kept as their natural logarithms.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

NOTHING = math.inf
MISSING = math.nan

Box = tuple[tuple[float, float], tuple[float, float]]
"""A workspace: its lowest and its highest corner."""


# ---------------------------------------------------------------------------------------------- measured beams


def crossing(x: float, y: float, heading: float, box: Box) -> tuple[float, float] | None:
    """Distances at which a beam enters and leaves the box; None: it never crosses it."""
    (left, bottom), (right, top) = box
    cos, sin = math.cos(heading), math.sin(heading)
    met = [0.0] if left <= x <= right and bottom <= y <= top else []
    for wall in (left, right):
        if cos != 0.0:
            along = (wall - x) / cos
            if along >= 0.0 and bottom <= y + along * sin <= top:
                met.append(along)
    for wall in (bottom, top):
        if sin != 0.0:
            along = (wall - y) / sin
            if along >= 0.0 and left <= x + along * cos <= right:
                met.append(along)
    return (min(met), max(met)) if met else None


def classify_beam(  # noqa: PLR0911 - one return per line of the rule
    value: float | None,
    declared_no_return: bool,
    *,
    zero: Literal["missing", "no_return"],
    range_min: float,
    range_max: float,
    within: tuple[float, float] | Literal["everywhere"] | None = "everywhere",
) -> float:
    """Classify a measured beam; `within` is its `crossing` of the workspace."""
    if declared_no_return:
        return NOTHING
    if value is None or math.isnan(value) or value == -math.inf:
        return MISSING
    if value == math.inf:
        return NOTHING
    if value == 0.0:
        return MISSING if zero == "missing" else NOTHING
    if value < range_min:
        return MISSING
    if value > range_max:
        return NOTHING
    if within == "everywhere":
        return value
    if within is None:
        return NOTHING
    enter, leave = within
    if value < enter:
        return MISSING
    return NOTHING if value > leave else value


def restrict_predicted(
    value: float,
    range_max: float,
    within: tuple[float, float] | Literal["everywhere"] | None = "everywhere",
) -> float:
    """A predicted beam as it is compared: never missing."""
    if value > range_max:
        return NOTHING
    if within == "everywhere":
        return value
    return value if within is not None and within[0] <= value <= within[1] else NOTHING


# ------------------------------------------------------------------------------------------------- comparisons


def code(beam: float, no_return_m: float) -> float:
    return min(beam, no_return_m)


def compared(measured: Sequence[float]) -> list[int]:
    return [i for i, beam in enumerate(measured) if not math.isnan(beam)]


def distance(measured: Sequence[float], predicted: Sequence[float], no_return_m: float) -> float:
    return math.sqrt(
        math.fsum((code(measured[i], no_return_m) - code(predicted[i], no_return_m)) ** 2 for i in compared(measured))
    )


def rmsd(measured: Sequence[float], predicted: Sequence[float], no_return_m: float) -> float:
    return distance(measured, predicted, no_return_m) / math.sqrt(len(compared(measured)))


def best_fit(log_weights: Sequence[float], distances: Sequence[float]) -> int:
    """The pose with the largest weight, the first of equals; where every weight is 0, the one with the smallest d."""
    if max(log_weights) == -math.inf:
        return distances.index(min(distances))
    return log_weights.index(max(log_weights))


def fit_rmsd_mm(measured: Sequence[float], predicted: Sequence[float], no_return_m: float) -> float | None:
    return 1000.0 * rmsd(measured, predicted, no_return_m) if compared(measured) else None


def fit_hit_rmsd_mm(measured: Sequence[float], predicted: Sequence[float], no_return_m: float) -> float | None:
    both = [i for i in compared(measured) if measured[i] != NOTHING and predicted[i] != NOTHING]
    if not both:
        return None
    return 1000.0 * rmsd([measured[i] for i in both], [predicted[i] for i in both], no_return_m)


def misses_object(
    measured: Sequence[float], copies: Sequence[Sequence[Sequence[float]]], belief: Sequence[float], has_workspace: bool
) -> bool:
    """True if a scan misses the object (deploy/docs/mathematics.md, "Update").

    `copies[p]` are the predicted scans of the displaced copies of pose p.
    """
    beams = compared(measured)
    possible = [copy for of_pose, b in zip(copies, belief, strict=True) if b > 0.0 for copy in of_pose]
    m = min(sum(copy[i] != NOTHING for i in beams) for copy in possible)
    seen = 0
    for i in beams:
        returns = [copy[i] for copy in possible if copy[i] != NOTHING]
        if returns and measured[i] != NOTHING:
            seen += has_workspace or measured[i] <= max(returns) + 0.1
    return m >= 3 and seen < m / 3


# ------------------------------------------------------------------------------------------------ update rules


def log_weight(
    rule: str, parameters: Mapping[str, float], measured: Sequence[float], predicted: Sequence[float]
) -> float:
    """ln w(o, o~); `beam` needs the lidar's `range_max` and `noise_ratio` among its parameters."""
    d = distance(measured, predicted, parameters["no_return_m"])
    if rule == "margin":
        agree = all(
            abs(code(measured[i], parameters["no_return_m"]) - code(predicted[i], parameters["no_return_m"]))
            <= parameters["margin_m"] + 1e-9
            for i in compared(measured)
        )
        return 0.0 if agree else -math.inf
    if rule == "exponential":
        return -d
    if rule == "gaussian":
        return -(d**2) / (2.0 * parameters["sigma_m"] ** 2)
    if rule == "inverse_rmsd":
        return -math.log(max(d / math.sqrt(len(compared(measured))), parameters["floor_m"]))
    if rule == "beam":
        return parameters["temper"] * math.fsum(
            _log_beam(measured[i], predicted[i], parameters) for i in compared(measured)
        )
    raise AssertionError(f"the twin has no rule {rule!r}")


def _log(value: float) -> float:
    return math.log(value) if value > 0.0 else -math.inf


def _log_beam(z: float, expected: float, parameters: Mapping[str, float]) -> float:
    shares = [parameters[name] for name in ("z_hit", "z_short", "z_no_return", "z_random")]
    z_hit, z_short, z_no_return, z_random = (share / sum(shares) for share in shares)
    z_max, rate = parameters["range_max"], parameters["lambda_short_per_m"]
    if z == NOTHING:
        return _log(z_no_return) if expected != NOTHING else _log(z_hit / 2.0 + z_no_return)
    if expected == NOTHING:
        short = z_short * rate * math.exp(-rate * z) / (1.0 - math.exp(-rate * z_max))
        return _log(z_hit / (2.0 * z_max) + short + z_random / z_max)
    sigma = max(parameters["sigma_hit_m"], parameters["noise_ratio"] * expected)
    density = z_hit * math.exp(-((z - expected) ** 2) / (2.0 * sigma**2)) / (sigma * math.sqrt(2.0 * math.pi))
    if z <= expected:
        density += z_short * rate * math.exp(-rate * z) / (1.0 - math.exp(-rate * expected))
    return _log(density + z_random / z_max)


def log_mean_weight(log_weights: Sequence[float]) -> float:
    """ln of the mean of weights: over the sigma points of an uncertain sensor pose."""
    highest = max(log_weights)
    if highest == -math.inf:
        return -math.inf
    return highest + math.log(math.fsum(math.exp(w - highest) for w in log_weights) / len(log_weights))


# ----------------------------------------------------------------------------------------------------- updates


@dataclass(frozen=True)
class Updated:
    belief: list[float]
    accepted: bool
    reason: str | None
    log_evidence: float | None


def bayes(belief: Sequence[float], log_weights: Sequence[float]) -> tuple[list[float], float] | None:
    """b'[p] ~ b[p] w[p] and ln sum_p b[p] w[p]; None where the sum is 0."""
    joint = [_log(b) + w for b, w in zip(belief, log_weights, strict=True)]
    highest = max(joint)
    if highest == -math.inf:
        return None
    shares = [math.exp(value - highest) for value in joint]
    total = math.fsum(shares)
    return [share / total for share in shares], highest + math.log(total)


def nearest(distances: Sequence[float]) -> list[float]:
    likeness = [math.exp(-d) for d in distances]
    near = [max(likeness) - value <= 0.015 for value in likeness]
    return [1.0 / sum(near) if is_near else 0.0 for is_near in near]


def update(
    belief: Sequence[float],
    log_weights: Sequence[float],
    distances: Sequence[float],
    beams_compared: int,
    *,
    on_no_match: str = "reject",
    reject_above_rmsd_mm: float | None = None,
    nothing_seen: bool = False,
) -> Updated:
    before = list(belief)
    if beams_compared == 0:
        return Updated(before, False, "no_beams", None)
    if nothing_seen:
        return Updated(before, False, "nothing_seen", None)
    best_fit_mm = 1000.0 * distances[best_fit(log_weights, distances)] / math.sqrt(beams_compared)
    if reject_above_rmsd_mm is not None and best_fit_mm > reject_above_rmsd_mm:
        return Updated(before, False, "bad_fit", None)
    posterior = bayes(belief, log_weights)
    if posterior is not None:
        return Updated(posterior[0], True, None, posterior[1])
    if on_no_match == "nearest":
        return Updated(nearest(distances), True, "nearest", None)
    return Updated(before, False, "no_match", None)


def log_outcome_weights(scores: Sequence[float], success: bool, score_floor: float) -> list[float]:
    held = [min(max(score, score_floor), 1.0 - score_floor) for score in scores]
    return [_log(score if success else 1.0 - score) for score in held]


def update_by_outcome(
    belief: Sequence[float], scores: Sequence[float], success: bool, score_floor: float = 0.0
) -> Updated:
    posterior = bayes(belief, log_outcome_weights(scores, success, score_floor))
    if posterior is None:
        return Updated(list(belief), False, "no_match", None)
    return Updated(posterior[0], True, None, posterior[1])


# ------------------------------------------------------------------------------------ spread, places and absence


def covariance(
    object_std: tuple[float, float],
    sensor_std: tuple[float, float],
    pose_xy: tuple[float, float],
    sensor_xy: tuple[float, float],
) -> list[list[float]]:
    """C_a = C_o + A_a C_s A_a^T, entry by entry; each std is (xy, yaw)."""
    (x_p, y_p), (x_a, y_a) = pose_xy, sensor_xy
    a = [[-1.0, 0.0, -(y_a - y_p)], [0.0, -1.0, x_a - x_p], [0.0, 0.0, -1.0]]
    own, other = ([std[0], std[0], std[1]] for std in (object_std, sensor_std))
    return [
        [(own[i] ** 2 if i == j else 0.0) + sum(a[i][k] * other[k] ** 2 * a[j][k] for k in range(3)) for j in range(3)]
        for i in range(3)
    ]


def displacement(c: Sequence[Sequence[float]], z: Sequence[float]) -> tuple[float, float, float]:
    """L z with L the lower triangular root of a regular covariance, by Cholesky and Banachiewicz."""
    root = [[0.0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(i + 1):
            rest = c[i][j] - sum(root[i][k] * root[j][k] for k in range(j))
            root[i][j] = math.sqrt(rest) if i == j else rest / root[j][j]
    x, y, yaw = (sum(root[i][k] * z[k] for k in range(3)) for i in range(3))
    return x, y, yaw


def displaced(
    position: Sequence[float], quaternion_wxyz: Sequence[float], by: tuple[float, float, float]
) -> tuple[list[float], list[float]]:
    """The pose moved by (x, y), and turned by the yaw about its own position."""
    w, x, y, z = quaternion_wxyz
    cos, sin = math.cos(by[2] / 2.0), math.sin(by[2] / 2.0)
    turned = [cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w]
    return [position[0] + by[0], position[1] + by[1], position[2]], turned


Looks = Sequence[Sequence[Sequence[float]]]
"""Log weights of the looks from one place: [look][pose][copy]."""


def log_place(looks: Looks, pose: int) -> float:
    """ln of (1/J) sum_j prod_looks w of one pose."""
    copies = len(looks[0][pose])
    return log_mean_weight([math.fsum(look[pose][j] for look in looks) for j in range(copies)])


def belief_of_places(base: Sequence[float], places: Sequence[Looks]) -> tuple[list[float], float] | None:
    """b[p] ~ b0[p] prod_places log_place, and ln of the sum; None where it is 0."""
    return bayes(base, [math.fsum(log_place(looks, p) for looks in places) for p in range(len(base))])


def absent_after(absent: float, log_absent: float, log_evidence: float) -> float:
    """The probability of absence after a scan."""
    gone, there = absent * math.exp(log_absent), (1.0 - absent) * math.exp(log_evidence)
    return gone / (gone + there)


def log_attempts(k: int, n: int, successes: int, failures: int) -> float:
    """ln of the Beta-binomial probability of one order of outcomes, the score being Beta(k + 1/2, n - k + 1/2)."""

    def log_beta(a: float, b: float) -> float:
        return math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)

    a, b = k + 0.5, n - k + 0.5
    return log_beta(a + successes, b + failures) - log_beta(a, b)


# --------------------------------------------------------------------------------------------- grasps and looks

Scores = Sequence[Sequence[float]]
"""Q[x][p]."""


def expected_score(scores: Sequence[float], belief: Sequence[float]) -> float:
    return math.fsum(b * q for b, q in zip(belief, scores, strict=True))


def best_grasp(table: Scores, belief: Sequence[float]) -> tuple[int | None, float]:
    """x* and Qbar*: the first listed within 1e-12 of the maximum, none when that is 0."""
    expected = [expected_score(row, belief) for row in table]
    highest = max(expected)
    if highest == 0.0:
        return None, 0.0
    return next(x for x, value in enumerate(expected) if value >= highest - 1e-12), highest


def score_at(table: Scores, grasp: int | None, pose: int) -> float:
    return 0.0 if grasp is None else table[grasp][pose]


def value_of_assistance(
    table: Scores,
    belief: Sequence[float],
    log_weights: Sequence[Sequence[float]],
    distances: Sequence[Sequence[float]],
    *,
    on_no_match: str = "reject",
    definition: str = "posterior",
    sensor_belief: Sequence[float] | None = None,
) -> float:
    """VOA(a, b); `log_weights[q][p]` and `distances[q][p]`: the scan predicted for q, compared with that for p."""
    outer = belief if sensor_belief is None else sensor_belief
    grasp_before, score_before = best_grasp(table, belief)
    total = []
    for q, share in enumerate(outer):
        if share == 0.0:
            continue
        after = update(belief, log_weights[q], distances[q], 1, on_no_match=on_no_match).belief
        grasp_after, score_after = best_grasp(table, after)
        if definition == "posterior":
            total.append(share * (score_after - score_before))
        else:
            total.append(share * (score_at(table, grasp_after, q) - score_at(table, grasp_before, q)))
    return math.fsum(total)


def executed_value(table: Scores, belief: Sequence[float], after_each: Sequence[Sequence[float]]) -> float:
    """AECD: `after_each[p]` is the belief after the scan that was measured at p."""
    promised = math.fsum(b * best_grasp(table, after)[1] for b, after in zip(belief, after_each, strict=True))
    return promised - best_grasp(table, belief)[1]


def ranking(values: Sequence[float], costs: Sequence[float]) -> list[int]:
    """Indices of the sensor configurations, best net value (rounded to 1e-12) first, ties as listed."""
    net = [round(value - cost, 12) for value, cost in zip(values, costs, strict=True)]
    return sorted(range(len(net)), key=lambda a: (-net[a], a))


# ------------------------------------------------------------------------------------------------- predictions


def rotation_of(quaternion_wxyz: Sequence[float]) -> NDArray[np.float64]:
    """Column by column: the quaternion's product q v q* for each axis v."""
    w, *vector = quaternion_wxyz
    u = np.array(vector) / math.hypot(*quaternion_wxyz)
    w /= math.hypot(*quaternion_wxyz)
    columns = [axis + 2.0 * np.cross(u, np.cross(u, axis) + w * axis) for axis in np.eye(3)]
    return np.array(columns).T


def cast(
    vertices: Any,
    faces: Any,
    position: Sequence[float],
    quaternion_wxyz: Sequence[float],
    sensor: tuple[float, float, float],
    height: float,
    angles: Iterable[float],
    range_max: float,
) -> list[float]:
    """Ranges of horizontal rays from `sensor` (x, y, yaw) at `height`: Moeller-Trumbore, every ray on every face.

    A face is a closed set (to 1e-12 of its sides); one that the ray runs along is left to its neighbours.
    """
    world = np.asarray(vertices, dtype=np.float64) @ rotation_of(quaternion_wxyz).T + np.asarray(position)
    a, b, c = (world[np.asarray(faces)[:, k]] for k in range(3))
    edge_1, edge_2 = b - a, c - a
    origin = np.array([sensor[0], sensor[1], height])
    ranges = []
    for angle in angles:
        ray = np.array([math.cos(sensor[2] + angle), math.sin(sensor[2] + angle), 0.0])
        across = np.cross(ray, edge_2)
        determinant = np.einsum("ij,ij->i", edge_1, across)
        largest = np.linalg.norm(edge_1, axis=1) * np.linalg.norm(edge_2, axis=1)
        seen = np.abs(determinant) > 1e-13 * largest
        divisor = np.where(seen, determinant, 1.0)
        from_a = origin - a
        other = np.cross(from_a, edge_1)
        share_1 = np.einsum("ij,ij->i", from_a, across) / divisor
        share_2 = np.einsum("ij,j->i", other, ray) / divisor
        along = np.einsum("ij,ij->i", edge_2, other) / divisor
        slack = 1e-12
        hit = seen & (share_1 >= -slack) & (share_2 >= -slack) & (share_1 + share_2 <= 1.0 + slack) & (along >= 0.0)
        first = float(along[hit].min()) if hit.any() else NOTHING
        ranges.append(first if first <= range_max else NOTHING)
    return ranges
