"""Beams of a scan that could see the object, and those that do: to notice a scan in which the object is missing."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.displaced_scans import DisplacedScans
from voa_core.jit import kernel
from voa_core.outlines import Ints
from voa_core.prediction import Prediction

BEHIND_M = 0.1
"""Without a workspace, a return this far behind the farthest prediction of its beam still sees the object."""
_FEWEST_RETURNS = 3
_SLACK_M = 1e-9


class Returns(NamedTuple):
    """The farthest return that a displaced copy of each of n poses predicts, on all beams on which one returns.

    The arrays are read-only: kernels are compiled for such arrays alone.

    Attributes:
        start: (n + 1,) first row of each pose, and the end.
        first: (n,) index in `beams` of the first row of each pose; the others follow. Poses may share their beams.
        beams: (b,) indices of beams.
        farthest: (h,) metres, for each row; inf or -inf where no copy returns.
    """

    start: NDArray[np.int64]
    first: NDArray[np.int64]
    beams: NDArray[np.intp] | Ints
    farthest: Floats


@dataclass(frozen=True, eq=False)
class Sight:
    """Beams of one scan that could see the object, and those that do: for scans in which the object is missing.

    Attributes:
        beams: (r,) the scan, metres, as `scans.classify` gives it.
        returns: predicted for n poses.
        behind_m: a return so far behind the farthest prediction of its beam still sees the object, metres; inf where
            the workspace bounds the returns.
        fewest: (n,) the fewest of the compared beams on which a displaced copy of each pose returns.
    """

    beams: Floats
    returns: Returns
    behind_m: float
    fewest: NDArray[np.intp]

    @property
    def is_blind(self) -> bool:
        """True if none of the compared beams can meet a pose."""
        return bool(np.isnan(self.beams[self.returns.beams]).all())

    def hits(self, pose: int) -> Floats:
        """Measured ranges, (h,) metres, on the h beams on which both the scan and a copy of the pose return."""
        start, first, beams, farthest = self.returns
        rows = slice(start[pose], start[pose + 1])
        measured = self.beams[beams[first[pose] : first[pose] + rows.stop - rows.start]]
        hit: Floats = measured[np.isfinite(measured) & np.isfinite(farthest[rows])]
        return hit

    def misses_object(self, possible: NDArray[np.bool_]) -> bool:
        """True if too few beams see the object for it to lie at one of the possible poses, flags (n,).

        With m the fewest returns that a copy of a possible pose predicts, the scan misses the object if m >= 3 and
        fewer than m / 3 of the beams on which such a copy returns see it. Two returns or fewer decide nothing.
        """
        return bool(_miss(self.beams, possible, *self.returns, self.behind_m, self.fewest))


def sight_of(beams: Floats, prediction: Prediction, behind_m: float) -> Sight:
    """Find the classified beams (r,) that could see some poses, each exactly where it is listed.

    Args:
        beams: metres, as `scans.classify` gives them.
        prediction: of the poses.
        behind_m: see `Sight`.
    """
    poses, columns = prediction.ranges.shape
    start, first = frozen(np.arange(poses + 1) * columns), frozen(np.zeros(poses, dtype=np.int64))
    returns = Returns(start, first, prediction.columns, prediction.ranges.reshape(-1))
    fewest = np.zeros(poses, dtype=np.intp)
    _count_returns(prediction.ranges, ~np.isnan(beams[prediction.columns]), fewest)
    return Sight(beams, returns, behind_m, fewest)


def sight_of_copies(beams: Floats, copies: DisplacedScans, behind_m: float) -> Sight:
    """Find the classified beams (r,) that could see some poses in any of their displaced copies.

    Args:
        beams: metres, as `scans.classify` gives them.
        copies: of the poses.
        behind_m: see `Sight`.
    """
    returns = Returns(copies.start, copies.start[:-1], copies.beams, copies.farthest)
    return Sight(beams, returns, behind_m, copies.fewest_returns(np.isnan(beams)))


def joined(parts: Sequence[Sight]) -> Sight:
    """Join what one scan shows of some poses, and of others, in their order."""
    if len(parts) == 1:
        return parts[0]
    rows = np.cumsum([0, *(len(part.returns.farthest) for part in parts)])
    beams = np.cumsum([0, *(len(part.returns.beams) for part in parts)])
    starts = [part.returns.start[:-1] + row for part, row in zip(parts, rows, strict=False)]
    returns = Returns(
        frozen(np.concatenate([*starts, rows[-1:]])),
        frozen(np.concatenate([part.returns.first + beam for part, beam in zip(parts, beams, strict=False)])),
        frozen(np.concatenate([part.returns.beams for part in parts])),
        frozen(np.concatenate([part.returns.farthest for part in parts])),
    )
    return replace(parts[0], returns=returns, fewest=np.concatenate([part.fewest for part in parts]))


@kernel
def _count_returns(ranges: Floats, compared: NDArray[np.bool_], fewest: NDArray[np.intp]) -> None:
    """Count the returns of each prediction (n, c) on the columns that are compared, flags (c,), to `fewest` (n,)."""
    for pose in range(len(ranges)):
        for column in range(len(compared)):
            fewest[pose] += compared[column] and ranges[pose, column] < np.inf


@kernel
def _miss(
    measured: Floats,
    possible: NDArray[np.bool_],
    start: NDArray[np.int64],
    first: NDArray[np.int64],
    beams: NDArray[np.intp] | Ints,
    farthest: Floats,
    behind_m: float,
    fewest: NDArray[np.intp],
) -> bool:
    """True if a scan misses the object (`Sight.misses_object`); the arguments are those of `Sight` and `Returns`.

    The loop ends as soon as enough beams see the object: for most scans, after the first few poses.
    """
    least = np.iinfo(np.int64).max
    for pose in range(len(possible)):
        if possible[pose]:
            least = min(least, fewest[pose])
    if least < _FEWEST_RETURNS:
        return False
    sees, count = np.zeros(len(measured), dtype=np.bool_), 0
    for pose in range(len(possible)):
        if not possible[pose]:
            continue
        for row in range(start[pose], start[pose + 1]):
            beam, far = beams[first[pose] + row - start[pose]], farthest[row]
            if -np.inf < far < np.inf and measured[beam] < np.inf and measured[beam] <= far + behind_m + _SLACK_M:
                count += not sees[beam]
                sees[beam] = True
        if 3 * count >= least:
            return False
    return True
