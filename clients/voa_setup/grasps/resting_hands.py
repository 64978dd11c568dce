"""Good hands for one way of the object to rest: found at one pose, they hold at every pose that rests so."""

from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import Floats
from voa_fleet.world.objects import GripperSetting
from voa_setup.grasps.candidates import CLEARANCE_M, candidate_hands
from voa_setup.grasps.closing import close_hands
from voa_setup.grasps.cover import thin
from voa_setup.grasps.hands import TABLE_CLEARANCE_M, Hands, heights, inverse, joined
from voa_setup.grasps.kinds import kind_features
from voa_setup.grasps.shares import gripped_shares
from voa_setup.grasps.surface import Surface

_VARIED = 200
"""Hands that are compared under displacements."""
_SCOUTS = 4
_VARIANTS = 8
_TURN_RAD, _SHIFT_M = 0.15, (0.004, 0.006)
"""Standard deviations of a variant's turn about the vertical, and of its shift across and along the approach."""


@dataclass(frozen=True, eq=False)
class Trials:
    """Object and gripper with which hands are tried.

    Attributes:
        surface: of the object.
        gripper: opening and sizes of the fingers.
        friction: coefficient of both contacts.
        moves: (j, 3), displacements of the object under which hands are compared.
    """

    surface: Surface
    gripper: GripperSetting
    friction: float
    moves: Floats

    def shares(self, poses: Floats, hands: Hands) -> Floats:
        """Compute the share of displaced copies that each hand grips at each pose (n, 4, 4), as (h, n)."""
        return gripped_shares(self.surface, poses, hands, self.gripper, self.moves, self.friction, _SCOUTS)

    def widths(self, pose: Floats, hands: Hands) -> Floats:
        """Measure the object between the fingers at a pose (4, 4), metres, (h,)."""
        return close_hands(self.surface, hands.moved(inverse(pose)), self.gripper, self.friction).widths_m

    def centred(self, pose: Floats, hands: Hands) -> tuple[Hands, Floats]:
        """Move hands so that the object is midway between their fingers.

        Returns:
            The hands, and for each 1 if it then grips the object at that pose with some room on all sides, else 0.
        """
        back = inverse(pose)
        closed = close_hands(self.surface, hands.moved(back), self.gripper, self.friction)
        moved = hands.shifted(np.where(closed.holds, closed.middles_m, 0.0), axis=0)
        again = close_hands(self.surface, moved.moved(back), self.gripper, self.friction, CLEARANCE_M)
        clear = again.holds & (heights(moved, self.gripper) >= TABLE_CLEARANCE_M - 1e-9)
        return moved, clear.astype(np.float64)

    def features(self, pose: Floats, hands: Hands) -> Floats:
        """Compute the coordinates of the hands' kinds at a pose, (h, f)."""
        return kind_features(self.surface, pose, hands, self.widths(pose, hands), self.gripper)


def merits(hands: Hands, middle: Floats) -> Floats:
    """Small preferences between equal hands, (h,): straight from above or from the side, and near `middle`, x and y."""
    down = -hands.rotations[:, 2, 2]
    straight = 0.15 * (down > 0.9) + 0.12 * (down < 0.3)
    preferences: Floats = straight - 0.2 * np.linalg.norm(hands.tips[:, :2] - middle, axis=1)
    return preferences


def resting_hands(
    trials: Trials, pose: Floats, pairs: tuple[Floats, Floats], rng: np.random.Generator, most: int
) -> Hands:
    """Return good hands of all kinds at a pose, improved by small variations.

    Args:
        trials: object and gripper.
        pose: of the object, (4, 4).
        pairs: antipodal points in the object's frame, (p, 3) each.
        rng: draws the variations.
        most: hands to return.
    """
    first, second = (points @ pose[:3, :3].T + pose[:3, 3] for points in pairs)
    hands, clear = trials.centred(pose, candidate_hands(first, second, trials.gripper))
    hands = hands[clear > 0.0]
    if not len(hands):
        return hands
    varied = hands[np.array(thin(np.ones(len(hands)), trials.features(pose, hands), _VARIED))]
    quality = _quality(trials, pose, varied)
    kept = varied[np.array(thin(quality**2, trials.features(pose, varied), most))]
    return _improved(trials, pose, kept, rng)


def _quality(trials: Trials, pose: Floats, hands: Hands) -> Floats:
    return np.maximum(0.0, trials.shares(pose[None], hands)[:, 0] + merits(hands, pose[:2, 3]))


def _improved(trials: Trials, pose: Floats, hands: Hands, rng: np.random.Generator) -> Hands:
    """Hands, each replaced by the best of its variants."""
    count = len(hands)
    versions = [hands]
    for _ in range(_VARIANTS):
        variant, clear = trials.centred(pose, _varied(hands, rng))
        kept = clear > 0.0
        versions.append(
            Hands(
                np.where(kept[:, None, None], variant.rotations, hands.rotations),
                np.where(kept[:, None], variant.tips, hands.tips),
            )
        )
    everything = joined(versions)
    quality = _quality(trials, pose, everything).reshape(-1, count)
    return everything[quality.argmax(axis=0) * count + np.arange(count)]


def _varied(hands: Hands, rng: np.random.Generator) -> Hands:
    turn = rng.normal(0.0, _TURN_RAD, len(hands))
    about = np.zeros((len(hands), 3, 3))
    about[:, 0, 0] = about[:, 1, 1] = np.cos(turn)
    about[:, 1, 0], about[:, 0, 1] = np.sin(turn), -np.sin(turn)
    about[:, 2, 2] = 1.0
    turned = Hands(about @ hands.rotations, hands.tips)
    across, along = rng.normal(0.0, _SHIFT_M, (len(hands), 2)).T
    return turned.shifted(across, axis=1).shifted(along, axis=2)
