"""Proposals of grasps for an object's poses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import GripperSetting
from voa_fleet.world.ur5e import BASE
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.scenarios import Pose
from voa_setup.grasps.candidates import CLEARANCE_M, antipodal_pairs
from voa_setup.grasps.cover import Ranked, choose
from voa_setup.grasps.hands import Hands, inverse, joined
from voa_setup.grasps.names import grasp_names
from voa_setup.grasps.reach import Reach, within_bounds
from voa_setup.grasps.resting_hands import Trials, merits, resting_hands
from voa_setup.grasps.scoring import FRICTION
from voa_setup.grasps.shares import displacements
from voa_setup.grasps.surface import sample_surface
from voa_setup.motions import matrices_of_poses

_SPREAD = (0.005, 0.052)
"""Displacements with which candidates are compared: standard deviations in metres and radians."""
_POINTS, _MOVES = 3000, 16
_CANDIDATES, _FEWEST_PER_POSE, _MOST_PER_POSE = 800, 4, 32
"""Candidates that are compared at all poses: the work grows with their number times that of the poses."""


_OUT_OF_REACH = (
    "the gripper could hold the object, but the simulated arm, whose base stands at x = {:g}, y = {:g} m, does not "
    "reach it at any pose: choose --positions near 0,0"
).format(*BASE)


class NoGrasp(ValueError):
    """An object of which the gripper finds nothing to hold at any pose; the message says what was tried."""


@dataclass(frozen=True)
class ProposedGrasp:
    """A grasp that was derived from the object's shape.

    Attributes:
        name: unique among the proposals; says from where the hand comes.
        geometry: of the hand, in the world frame.
    """

    name: str
    geometry: GraspGeometry


def propose_grasps(
    mesh: Mesh,
    poses: Sequence[Pose],
    prior: Sequence[float],
    gripper: GripperSetting,
    *,
    count: int = 12,
    friction: float = FRICTION,
    seed: int = 0,
) -> list[ProposedGrasp]:
    """Propose grasps that cover an object's poses: for every pose one that works well, if there is one.

    Candidates come from antipodal pairs of surface points: the friction cones at both contacts contain the line
    between them. Hands approach from above, from the side or between; open fingers and palm stay clear of table and
    object on the way. Of the candidates those are chosen that add most to the expected best score, then those most
    unlike the others. All are within reach of the fleet's arm.

    Args:
        mesh: of the object.
        poses: with position and orientation.
        prior: probability of each pose.
        gripper: opening and sizes of the fingers.
        count: most grasps to propose.
        friction: coefficient of both contacts.
        seed: of all samples; equal arguments give equal proposals.

    Raises:
        NoGrasp: the gripper can hold the object at no pose.
        ValueError: there is no pose, a pose has no position or no orientation, or `prior` has another length.
    """
    if not poses or len(poses) != len(prior):
        raise ValueError(f"expected one share of the prior per pose, got {len(poses)} poses and {len(prior)} shares")
    matrices = matrices_of_poses(poses)
    moves = displacements(_MOVES, *_SPREAD, seed)
    trials = Trials(sample_surface(mesh, seed, _POINTS), gripper, friction, moves)
    candidates = _candidates(trials, matrices, seed)
    if candidates is None:
        raise NoGrasp(_nothing_to_hold(gripper))
    if not len(candidates.hands):
        raise NoGrasp(_OUT_OF_REACH)
    preferences = merits(candidates.hands, matrices[:, :2, 3].mean(axis=0))
    ranked = Ranked(trials.shares(matrices, candidates.hands), preferences, candidates.features)
    centre = float(np.mean(matrices[:, 0, 3])), float(np.mean(matrices[:, 1, 3]))
    chosen = _reachable(ranked, candidates, np.asarray(prior, dtype=np.float64), count, Reach.of(gripper))
    if not chosen:
        raise NoGrasp(_OUT_OF_REACH if ranked.scores.any() else _nothing_to_hold(gripper))
    return [ProposedGrasp(name, grasp) for name, grasp in zip(grasp_names(chosen, centre), chosen, strict=True)]


def _nothing_to_hold(gripper: GripperSetting) -> str:
    widest = 1e3 * (gripper.opening_m - 2.0 * CLEARANCE_M)
    return (
        f"the gripper can hold the object at no pose: it needs a part between two nearly parallel faces that is 1.5 to "
        f"{widest:.0f} mm wide and that the fingers reach without meeting the table or the object; try a wider "
        "gripper (--gripper) or longer fingers, or other rests (--least-probability 0)"
    )


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Hands in the world frame, what lies between their fingers, and the coordinates in which kinds differ."""

    hands: Hands
    widths_m: Floats
    features: Floats

    def geometry(self, index: int) -> GraspGeometry:
        """Geometry of a candidate, rounded to a tenth of a millimetre."""
        closing, _, approach = self.hands.rotations[index].T.round(6).tolist()
        # An equal hand, turned by half a turn about its approach, closes along the opposite direction.
        if tuple(closing) < (0.0, 0.0, 0.0):
            closing = [-part for part in closing]
        return GraspGeometry(
            tool_centre_point=tuple((self.hands.tips[index].round(4) + 0.0).tolist()),
            approach=tuple(part + 0.0 for part in approach),
            closing=tuple(part + 0.0 for part in closing),
            width_m=round(float(self.widths_m[index]), 4),
        )


def _candidates(trials: Trials, poses: Floats, seed: int) -> _Candidates | None:
    """Good hands of each way to rest, at every pose that rests so and is within reach; None if no rest has any."""
    rng = np.random.default_rng(seed)
    widest = trials.gripper.opening_m - 2.0 * CLEARANCE_M
    pairs = antipodal_pairs(trials.surface, widest, trials.friction, rng)
    most = max(_FEWEST_PER_POSE, min(_MOST_PER_POSE, _CANDIDATES // len(poses)))
    any_hand = False
    hands: list[Hands] = []
    widths: list[Floats] = []
    features: list[Floats] = []
    for members in _rests(poses):
        first = poses[members[0]]
        good = resting_hands(trials, first, pairs, rng, most)
        any_hand |= len(good) > 0
        width, feature = trials.widths(first, good), trials.features(first, good)
        for pose in poses[members]:
            moved = good.moved(pose @ inverse(first))
            near = within_bounds(moved, trials.gripper)
            hands.append(moved[near])
            widths.append(width[near])
            features.append(feature[near])
    return _Candidates(joined(hands), np.concatenate(widths), np.concatenate(features)) if any_hand else None


def _rests(poses: Floats) -> list[list[int]]:
    """Groups of poses that differ by a motion in the plane, as indices."""
    groups: list[list[int]] = []
    for index, pose in enumerate(poses):
        for group in groups:
            first = poses[group[0]]
            if np.allclose(first[2], pose[2], atol=1e-4):
                group.append(index)
                break
        else:
            groups.append([index])
    return groups


def _reachable(ranked: Ranked, candidates: _Candidates, prior: Floats, count: int, reach: Reach) -> list[GraspGeometry]:
    """Choose grasps, and choose again without those that the arm cannot reach."""
    scores = ranked.scores.copy()
    known: dict[int, bool] = {}
    while True:
        chosen = choose(Ranked(scores, ranked.merits, ranked.features), prior, count)
        for index in chosen:
            if index not in known:
                known[index] = reach.includes(candidates.geometry(index))
        out = [index for index in chosen if not known[index]]
        if not out:
            return [candidates.geometry(index) for index in chosen]
        scores[out] = 0.0
