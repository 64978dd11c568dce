"""Rests: the ways in which the object can lie on the table, with names that a person understands."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from voa_core.checks import Floats
from voa_core.geometry import matrices_of_quaternions, turn
from voa_msgs.objects import StablePose
from voa_setup.symmetry import Symmetry

UPRIGHT, UPSIDE_DOWN, RESTING = "upright", "upside down", "resting"
_UPRIGHT_COSINE = np.cos(np.radians(20.0))
_SIDE_SINE = np.sin(np.radians(30.0))


@dataclass(frozen=True, eq=False)
class NamedRest:
    """A way of the object to rest on the table, or several that look the same.

    Attributes:
        name: `upright`, `upside down`, `on side A`, `leaning A`, by the direction of the mesh's z axis; `resting`
            of a ball.
        transform: (4, 4) pose of the object's frame at yaw 0, its centre of mass over the world's origin. At yaw 0 the
            x axis of an upright or upside-down mesh points along the world's x axis; of any other, its z axis does.
        probability: that the object, dropped at random, rests this way.
        ups: directions in the object's frame that point up, one for each of the rests that look the same.
    """

    name: str
    transform: Floats
    probability: float
    ups: tuple[tuple[float, float, float], ...]

    def at(self, yaw_rad: float, x: float, y: float) -> Floats:
        """Pose (4, 4) of this rest turned by a yaw about its centre of mass, which lies over (x, y), metres."""
        moved = np.eye(4)
        moved[:3, :3] = turn(yaw_rad)
        moved[:2, 3] = x, y
        pose: Floats = moved @ self.transform
        return pose


def name_rests(stable: Sequence[StablePose], symmetry: Symmetry, *, ball: bool = False) -> list[NamedRest]:
    """Merge the rests that look the same, and name the others, the most probable first.

    Args:
        stable: the stable poses of the service.
        symmetry: of the mesh.
        ball: True if the object is a ball, whose only rest has no direction.
    """
    distinct: list[NamedRest] = []
    for pose in sorted(stable, key=lambda each: -each.probability):
        rest = _rest_of(pose)
        for index, known in enumerate(distinct):
            if _look_the_same(known, rest, symmetry):
                distinct[index] = _merged(known, rest)
                break
        else:
            distinct.append(rest)
    if ball:
        return [replace(distinct[0], name=RESTING, probability=1.0)]
    return _named(sorted(distinct, key=lambda each: -each.probability))


def _rest_of(pose: StablePose) -> NamedRest:
    """Turn a stable pose to its yaw 0; it has no name yet."""
    rotation = matrices_of_quaternions(np.array([pose.quaternion_wxyz]))[0]
    axis = rotation[:, 0] if abs(rotation[2, 2]) > _UPRIGHT_COSINE else rotation[:, 2]
    back = turn(-float(np.arctan2(axis[1], axis[0])))
    transform = np.eye(4)
    transform[:3, :3] = back @ rotation
    transform[:3, 3] = back @ np.array(pose.position)
    up = np.round(rotation[2], 6) + 0.0
    return NamedRest("", transform, pose.probability, ((float(up[0]), float(up[1]), float(up[2])),))


def _merged(known: NamedRest, rest: NamedRest) -> NamedRest:
    """Join two rests that look the same into one, which lies as the upright of the two, or else as the first."""
    probability = known.probability + rest.probability
    if rest.ups[0][2] > _UPRIGHT_COSINE:
        return replace(rest, probability=probability, ups=rest.ups + known.ups)
    return replace(known, probability=probability, ups=known.ups + rest.ups)


def _look_the_same(first: NamedRest, other: NamedRest, symmetry: Symmetry) -> bool:
    """True if the mesh at one rest lies as at the other, at yaw 0 or after a turn that aligns their surfaces."""
    turns = [0.0]
    mine, its = (_principal_yaw(symmetry.samples, rest.transform) for rest in (first, other))
    if mine is not None and its is not None:
        turns += [mine - its, mine - its + np.pi]
    return any(symmetry.alike(first.transform, other.at(yaw, 0.0, 0.0)) for yaw in turns)


def _principal_yaw(points: Floats, transform: Floats) -> float | None:
    """Direction in the plane in which the points (k, 3) of a placed surface vary most, radians; None: no direction."""
    plane = (points @ transform[:3, :3].T)[:, :2]
    values, vectors = np.linalg.eigh(np.cov(plane.T))
    if values[1] - values[0] < 0.02 * values[1]:
        return None
    return float(np.arctan2(vectors[1, 1], vectors[0, 1]))


def _named(rests: Sequence[NamedRest]) -> list[NamedRest]:
    """Name the rests by the direction of the mesh's z axis; letters follow the order."""
    used: dict[str, int] = {}
    named = []
    for rest in rests:
        z = rest.ups[0][2]
        kind = "on side" if abs(z) < _SIDE_SINE else "leaning"
        whole = UPRIGHT if z > _UPRIGHT_COSINE else UPSIDE_DOWN if z < -_UPRIGHT_COSINE else None
        if whole is not None and whole not in used:
            used[whole] = 1
            named.append(replace(rest, name=whole))
            continue
        index = used[kind] = used.get(kind, 0) + 1
        named.append(replace(rest, name=f"{kind} {_letters(index)}"))
    return named


def _letters(index: int) -> str:
    """Write 1, 2, ... as A, B, ..., Z, AA, AB, ..."""
    letters = ""
    while index > 0:
        index, place = divmod(index - 1, 26)
        letters = chr(ord("A") + place) + letters
    return letters
