"""Beams of a scan that could see the object, and those that do: to notice a scan in which the object is missing."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.jit import kernel
from voa_core.prediction import Prediction

BEHIND_M = 0.1
"""Without a workspace, a return this far behind the farthest prediction of its beam still sees the object."""
_FEWEST_RETURNS = 3
_SLACK_M = 1e-9


@dataclass(frozen=True, eq=False)
class Sight:
    """Beams of one scan that could see the object, and those that do: for scans in which the object is missing.

    Attributes:
        measured: (u,) the scan's ranges, metres, on the compared beams on which some copy of a pose returns.
        reach: (n, u) largest range, metres, of a return that sees the object at each pose, in any of its displaced
            copies; -inf where no copy returns. With a workspace it is inf elsewhere: its edge bounds the returns.
        fewest: (n,) the fewest of the compared beams on which a displaced copy of each pose returns.
    """

    measured: Floats
    reach: Floats
    fewest: NDArray[np.intp]

    def hits(self, pose: int) -> Floats:
        """Measured ranges, (h,) metres, on the h beams on which both the scan and a copy of the pose return."""
        hit: Floats = self.measured[np.isfinite(self.measured) & (self.reach[pose] > -np.inf)]
        return hit

    def misses_object(self, possible: NDArray[np.bool_]) -> bool:
        """True if too few beams see the object for it to lie at one of the possible poses, flags (n,).

        With m the fewest returns that a copy of a possible pose predicts, the scan misses the object if m >= 3 and
        fewer than m / 3 of the beams on which such a copy returns see it. Two returns or fewer decide nothing.
        """
        fewest = int(self.fewest.min(where=possible, initial=np.iinfo(np.intp).max))
        if fewest < _FEWEST_RETURNS:
            return False
        seen = (self.measured <= _farthest(self.reach, possible) + _SLACK_M) & np.isfinite(self.measured)
        return 3 * int(np.count_nonzero(seen)) < fewest


@dataclass(frozen=True, eq=False)
class SightOfSome:
    """Sight of consecutive poses alone, and the beams that it is about: `columns` (u,), ascending indices."""

    columns: NDArray[np.intp]
    sight: Sight


def sight_of(beams: Floats, prediction: Prediction, behind_m: float) -> Sight:
    """Find the classified beams (r,) that could see some poses, each exactly where it is listed.

    A return at most `behind_m` behind the farthest prediction of its beam sees the object.

    Args:
        beams: metres, as `scans.classify` gives them.
        prediction: of the poses.
        behind_m: metres; inf where the workspace bounds the returns.
    """
    columns = prediction.columns[~np.isnan(beams[prediction.columns])]
    entry = np.full(len(beams), -1)
    entry[columns] = np.arange(len(columns))
    poses = len(prediction.ranges)
    reach, fewest = np.full((poses, len(columns)), -np.inf), np.full(poses, len(beams))
    _enter(prediction.ranges, entry[prediction.columns], behind_m, reach, fewest)
    return Sight(beams[columns], reach, fewest)


def sight_of_copies(beams: Floats, copies: DisplacedScans, behind_m: float) -> SightOfSome:
    """Find the classified beams (r,) that could see some poses in any of their displaced copies.

    Args:
        beams: metres, as `scans.classify` gives them.
        copies: of consecutive poses.
        behind_m: as for `sight_of`.
    """
    compared = ~np.isnan(beams)
    columns = np.unique(copies.beams[compared[copies.beams]]).astype(np.intp)
    seen = compared[copies.beams] & (copies.farthest > -np.inf)
    of_row = np.repeat(np.arange(len(copies)), np.diff(copies.start))
    reach = np.full((len(copies), len(columns)), -np.inf)
    reach[of_row[seen], np.searchsorted(columns, copies.beams[seen])] = copies.farthest[seen] + behind_m
    return SightOfSome(columns, Sight(beams[columns], reach, copies.fewest_returns(~compared)))


def joined(beams: Floats, parts: Sequence[SightOfSome]) -> Sight:
    """Join the sights of consecutive poses, in their order, on the classified beams (r,) of one scan."""
    if len(parts) == 1:
        return parts[0].sight
    columns = np.unique(np.concatenate([part.columns for part in parts]))
    fewest = np.concatenate([part.sight.fewest for part in parts])
    reach, first = np.full((len(fewest), len(columns)), -np.inf), 0
    for part in parts:
        last = first + len(part.sight.fewest)
        reach[first:last, np.searchsorted(columns, part.columns)] = part.sight.reach
        first = last
    return Sight(beams[columns], reach, fewest)


@kernel
def _enter(ranges: Floats, entry: NDArray[np.intp], behind_m: float, reach: Floats, fewest: NDArray[np.intp]) -> None:
    """Enter the predictions (n, c) of the poses into `reach` (n, u) and `fewest` (n,).

    `entry` (c,) is the index among the u beams of each column; -1 for a column that is not compared.
    """
    for pose in range(len(ranges)):
        returns = 0
        for column in range(len(entry)):
            if entry[column] >= 0 and ranges[pose, column] < np.inf:
                returns += 1
                reach[pose, entry[column]] = ranges[pose, column] + behind_m
        fewest[pose] = returns


@kernel
def _farthest(reach: Floats, possible: NDArray[np.bool_]) -> Floats:
    """The greatest of `reach` (n, u) over the possible poses (n,), for each beam, (u,)."""
    farthest = np.full(reach.shape[1], -np.inf)
    for pose in range(len(reach)):
        if possible[pose]:
            for beam in range(len(farthest)):
                farthest[beam] = max(farthest[beam], reach[pose, beam])
    return farthest
