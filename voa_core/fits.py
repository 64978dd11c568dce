"""Fit of one scan by the scan predicted for each pose, in one loop over the poses, for every update of a belief."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.jit import sum_kernel
from voa_core.outlines import Ints
from voa_core.prediction import Prediction


class Fits(NamedTuple):
    """Fits of one scan by J displaced copies of each of n poses; see `rules.distances` for d.

    Attributes:
        squares: (n, J) d^2 of each copy, square metres.
        distances: (n,) d of each pose, metres: that of the copy with the smallest, the first of equals.
        hit_rmsds: (n,) RMSD over the beams on which both return, metres, of that copy; NaN where there is none.
    """

    squares: Floats
    distances: Floats
    hit_rmsds: Floats


def fits_of_poses(beams: Floats, prediction: Prediction, no_return_m: float) -> Fits:
    """Compare a scan with the scan predicted for each of n poses, which lie exactly where they are listed.

    Args:
        beams: (r,) metres, as `scans.classify` gives them.
        prediction: of the poses.
        no_return_m: range that stands for a no-return, and upper limit of every return, metres.
    """
    poses = len(prediction.ranges)
    squares, hit_rmsds = np.zeros(poses), np.full(poses, np.nan)
    _fit_poses(beams, prediction.columns, prediction.ranges, no_return_m, squares, hit_rmsds)
    return Fits(squares[:, None], np.sqrt(squares), hit_rmsds)


def fits_of_copies(beams: Floats, copies: DisplacedScans, no_return_m: float) -> Fits:
    """Compare a scan with the scans predicted for J displaced copies of each of n poses.

    Args:
        beams: (r,) metres, as `scans.classify` gives them.
        copies: of the poses.
        no_return_m: range that stands for a no-return, and upper limit of every return, metres.
    """
    poses = len(copies)
    fits = Fits(np.zeros((poses, copies.copies)), np.zeros(poses), np.full(poses, np.nan))
    _fit_copies(beams, copies.start, copies.beams, copies.ranges, no_return_m, *fits)
    return fits


@sum_kernel
def _fit_poses(
    beams: Floats,
    columns: NDArray[np.intp],
    predicted: Floats,
    no_return_m: float,
    squares: Floats,
    hit_rmsds: Floats,
) -> None:
    """Compare a scan (r,) with the ranges (n, c) that n poses predict on c of its beams; on all others none returns."""
    coded, returned, compared = np.zeros(len(columns)), np.zeros(len(columns)), np.zeros(len(columns))
    inside = np.zeros(len(beams), dtype=np.bool_)
    for column in range(len(columns)):
        z = beams[columns[column]]
        inside[columns[column]] = True
        if not np.isnan(z):
            coded[column] = min(z, no_return_m)
            returned[column] = 1.0 if z < np.inf else 0.0
            compared[column] = 1.0
    outside = 0.0
    for beam in range(len(beams)):
        if beams[beam] < no_return_m and not inside[beam]:
            outside += (beams[beam] - no_return_m) ** 2
    for pose in range(len(predicted)):
        total, of_hits, hits = outside, 0.0, 0.0
        for column in range(len(columns)):
            z = predicted[pose, column]
            both = returned[column] if z < np.inf else 0.0
            off = (coded[column] - (z if z < no_return_m else no_return_m)) * compared[column]
            total += off * off
            of_hits += off * off * both
            hits += both
        squares[pose] = total
        if hits > 0.0:
            hit_rmsds[pose] = np.sqrt(of_hits / hits)


@sum_kernel
def _fit_copies(
    beams: Floats,
    start: NDArray[np.int64],
    beam_of_row: Ints,
    predicted: Floats,
    no_return_m: float,
    squares: Floats,
    distances: Floats,
    hit_rmsds: Floats,
) -> None:
    """Compare a scan (r,) with the ranges of displaced copies, as in `DisplacedScans`; the results are `Fits`."""
    near = np.flatnonzero(beams < no_return_m)
    inside = np.zeros(len(beams), dtype=np.bool_)
    for pose in range(len(squares)):
        first, last, sums = start[pose], start[pose + 1], squares[pose]
        inside[beam_of_row[first:last]] = True
        outside = 0.0
        for beam in near:
            if not inside[beam]:
                outside += (beams[beam] - no_return_m) ** 2
        inside[beam_of_row[first:last]] = False
        sums[:] = outside
        for row in range(first, last):
            z, own = beams[beam_of_row[row]], predicted[row]
            if not np.isnan(z):
                coded = min(z, no_return_m)
                for j in range(len(sums)):
                    off = coded - (own[j] if own[j] < no_return_m else no_return_m)
                    sums[j] += off * off
        best = sums.argmin()
        of_hits, hits = 0.0, 0.0
        for row in range(first, last):
            z, own_best = beams[beam_of_row[row]], predicted[row, best]
            if z < np.inf and own_best < np.inf:
                of_hits += (min(z, no_return_m) - min(own_best, no_return_m)) ** 2
                hits += 1.0
        distances[pose] = np.sqrt(sums[best])
        if hits > 0.0:
            hit_rmsds[pose] = np.sqrt(of_hits / hits)
