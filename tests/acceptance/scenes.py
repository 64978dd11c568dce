"""Worlds of the table: random objects with fins, and scenes that were designed to separate ways of choosing a look."""

import math
from collections.abc import Sequence

import numpy as np

from tests.acceptance.casting import Floats
from tests.acceptance.shapes import Fin, quaternion, round_body
from tests.acceptance.worlds import Place, Pose, World

HIGH, LOW = 0.9, 0.0


def ring(prefix: str, count: int, distance: float, height: float, first: float = 0.0, cost: float = 0.0) -> list[Place]:
    """Places on a circle around the origin, which look at it, `first` radians from the x axis on."""
    places = []
    for index in range(count):
        bearing = first + 2.0 * math.pi * index / count
        x, y = distance * math.cos(bearing), distance * math.sin(bearing)
        yaw = math.remainder(bearing + math.pi, 2.0 * math.pi)
        places.append(Place(f"{prefix}{index}", round(x, 4), round(y, 4), round(yaw, 5), height, cost))
    return places


def by_class(classes: Sequence[int]) -> Floats:
    """Scores (classes, n): one grasp for each class of poses, which succeeds with 0.9 there and never elsewhere."""
    scores: Floats = np.where(np.arange(max(classes) + 1)[:, None] == np.array(classes), HIGH, LOW)
    return scores


def finned(seed: int) -> World:
    """Random object of the table: round body, 2 to 4 fins, 8 to 14 poses in 2 to 4 grasp classes, 12 places."""
    rng = np.random.default_rng([seed, 1])
    radius, height = rng.uniform(0.025, 0.04), rng.uniform(0.1, 0.16)
    fins = []
    for bearing in rng.uniform(0.0, 2.0 * math.pi, rng.integers(2, 5)):
        low = rng.uniform(0.02, 0.5) * height
        high = low + rng.uniform(0.3, 0.48) * height
        fins.append(Fin(bearing, rng.uniform(0.02, 0.05), rng.uniform(0.006, 0.015), low, high))
    count, kinds = int(rng.integers(8, 15)), int(rng.integers(2, 5))
    classes = rng.permutation(np.concatenate([np.arange(kinds), rng.integers(0, kinds, count - kinds)]))
    poses = [
        Pose(f"P{index}", (round(float(x), 4), round(float(y), 4), 0.0), quaternion(float(yaw)))
        for index, (x, y, yaw) in enumerate(
            zip(*rng.uniform(-0.02, 0.02, (2, count)), rng.uniform(0.0, 2.0 * math.pi, count), strict=True)
        )
    ]
    right, wrong = rng.uniform(0.7, 0.95, (kinds, count)), rng.uniform(0.0, 0.3, (kinds, count))
    scores = np.where(np.arange(kinds)[:, None] == classes, right, wrong).round(3)
    places = []
    for level, share in enumerate(rng.uniform((0.15, 0.42, 0.7), (0.3, 0.58, 0.9))):
        first = rng.uniform(0.0, math.pi / 2)
        places += ring(f"L{level}-", 4, rng.uniform(0.35, 0.6), round(share * height, 4), first)
    return World(f"finned-{seed}", round_body(radius, height, fins), poses, places, scores)


def poses_against_grasps(seed: int) -> World:
    """Object whose middle shows its yaw, and whose foot shows only which end is up.

    The grasp depends on the latter alone. Places `pose-*` look at the middle, `grasp-*` at the foot.
    """
    rng = np.random.default_rng([seed, 2])
    radius, height = rng.uniform(0.025, 0.035), rng.uniform(0.12, 0.16)
    middle = Fin(0.0, rng.uniform(0.04, 0.06), rng.uniform(0.01, 0.016), 0.4 * height, 0.6 * height)
    foot = radius + rng.uniform(0.018, 0.028)
    mesh = round_body(radius, height, [middle], [(foot, 0.0, 0.25 * height)])
    yaws = rng.uniform(0.0, 2.0 * math.pi) + 2.0 * math.pi * np.arange(5) / 5
    poses = [Pose(f"up-{index}", (0.0, 0.0, 0.0), quaternion(float(yaw))) for index, yaw in enumerate(yaws)]
    poses += [
        Pose(f"down-{index}", (0.0, 0.0, round(height, 6)), quaternion(float(yaw), flipped=True))
        for index, yaw in enumerate(yaws)
    ]
    distance = rng.uniform(0.3, 0.45)
    places = ring("pose-", 4, distance, round(0.5 * height, 4), rng.uniform(0.0, 1.5))
    places += ring("grasp-", 4, distance, round(0.12 * height, 4), rng.uniform(0.0, 1.5))
    return World(f"poses-against-grasps-{seed}", mesh, poses, places, by_class([0] * 5 + [1] * 5))


def worthless_nearby(seed: int) -> World:
    """Object whose foot shows only where it lies, which a robot that errs by centimetres cannot use.

    Its fin, higher up, points to one side or the other, and only farther places see it. Where it points decides the
    grasp, and the object lies a little to that side. Places `near-*` see the foot, `far-*` the fin.
    """
    rng = np.random.default_rng([seed, 3])
    radius, height = rng.uniform(0.03, 0.04), rng.uniform(0.12, 0.16)
    fin = Fin(0.0, rng.uniform(0.05, 0.065), rng.uniform(0.012, 0.018), 0.55 * height, 0.95 * height)
    shift, to = rng.uniform(0.006, 0.009), rng.uniform(0.0, 2.0 * math.pi)
    poses = []
    for side in (0, 1):
        for index, turn in enumerate(rng.uniform(-0.12, 0.12, 4)):
            bearing = to + math.pi * side + turn
            x, y = shift * math.cos(bearing), shift * math.sin(bearing)
            poses.append(Pose(f"{'ab'[side]}{index}", (round(x, 4), round(y, 4), 0.0), quaternion(bearing)))
    places = ring("near-", 4, rng.uniform(0.22, 0.26), round(0.25 * height, 4), to + math.pi / 4)
    places += ring("far-", 4, rng.uniform(0.42, 0.5), round(0.75 * height, 4), to + math.pi / 4)
    return World(
        f"worthless-nearby-{seed}", round_body(radius, height, [fin]), poses, places, by_class([0] * 4 + [1] * 4)
    )


def exclusive_or(seed: int, cost: float) -> World:
    """Object that stands upright or upside down, its fin to one side or the other: the grasp needs to know both.

    Places `foot-*` see the one, `fin-*` the other; a look costs `cost`.
    """
    rng = np.random.default_rng([seed, 4])
    radius, height = rng.uniform(0.025, 0.035), rng.uniform(0.12, 0.16)
    fin = Fin(0.0, rng.uniform(0.045, 0.06), rng.uniform(0.012, 0.018), 0.4 * height, 0.6 * height)
    collar = radius + rng.uniform(0.02, 0.028), 0.0, 0.25 * height
    to = rng.uniform(0.0, 2.0 * math.pi)
    poses = []
    for name, z, flipped in (("up", 0.0, False), ("down", round(height, 6), True)):
        poses += [
            Pose(f"{name}-{side}", (0.0, 0.0, z), quaternion(to + math.pi * side, flipped=flipped)) for side in (0, 1)
        ]
    distance = rng.uniform(0.32, 0.42)
    places = ring("foot-", 3, distance, round(0.12 * height, 4), rng.uniform(0.0, 2.0), cost)
    places += ring("fin-", 2, distance, round(0.5 * height, 4), to + math.pi / 2, cost)
    return World(
        f"exclusive-or-{seed}-{cost}",
        round_body(radius, height, [fin], [collar]),
        poses,
        places,
        by_class([0, 1, 1, 0]),
    )
