"""Loops over scans, beams and displaced copies, for rules whose statistic is a sum of simple differences.

A scan is compared on the beams that meet a pose; on all others the pose predicts a no-return whatever the copy, and
their share comes from a sum that is computed once for each scan. A negative `margin_m` stands for squared differences;
else beams that differ by more are counted.
"""

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel, sum_kernel
from voa_core.outlines import Ints
from voa_core.vector_math import exp_of_negative, take_logarithms

_SLACK_M = 1e-9


@kernel
def differences_of_pairs(
    observed: Floats,
    scans: NDArray[np.intp],
    poses: NDArray[np.intp],
    start: NDArray[np.int64],
    beams: Ints,
    predicted: Floats,
    no_return_m: float,
    margin_m: float,
    out: Floats,
) -> None:
    """Add up the differences between the scan and each displaced copy of the pose, for pairs of a scan and a pose.

    Args:
        observed: (N, r) coded ranges, metres; NaN for a missing beam.
        scans, poses: (P,) indices of each pair.
        start, beams, predicted: as in `DisplacedScans`, the ranges coded.
        no_return_m: code of a no-return, metres.
        margin_m: metres; negative for squared differences.
        out: (P, J) written.
    """
    inside = np.zeros(observed.shape[1], dtype=np.bool_)
    for pair in range(len(scans)):
        ranges, first, last = observed[scans[pair]], start[poses[pair]], start[poses[pair] + 1]
        inside[beams[first:last]] = True
        outside = 0.0
        for beam in range(len(ranges)):
            if not inside[beam] and not np.isnan(ranges[beam]):
                outside += _difference(ranges[beam] - no_return_m, margin_m)
        inside[beams[first:last]] = False
        sums = out[pair]
        sums[:] = outside
        for row in range(first, last):
            z = ranges[beams[row]]
            if not np.isnan(z):
                _add_scan(z, predicted[row], margin_m, sums)


@kernel
def _difference(off: float, margin_m: float) -> float:
    if margin_m < 0.0:
        return off * off
    return 1.0 if abs(off) > margin_m + _SLACK_M else 0.0


@sum_kernel
def _add_scan(z: float, predicted: Floats, margin_m: float, sums: Floats) -> None:
    """Add the differences of one beam of a scan and all copies of a pose, (J,)."""
    if margin_m < 0.0:
        for j in range(len(sums)):
            off = z - predicted[j]
            sums[j] += off * off
    else:
        for j in range(len(sums)):
            sums[j] += 1.0 if abs(z - predicted[j]) > margin_m + _SLACK_M else 0.0


@kernel
def differences_of_copies(
    observed: Floats,
    start: NDArray[np.int64],
    beams: Ints,
    predicted: Floats,
    no_return_m: float,
    margin_m: float,
    out: Floats,
) -> None:
    """Add up the differences between every scan and every displaced copy of some poses.

    Args:
        observed: (r, N) coded ranges, metres; NaN for a missing beam.
        start: (k + 1,) first row of each of the k poses, and the end.
        beams, predicted: as in `DisplacedScans`, the ranges coded.
        no_return_m: code of a no-return, metres.
        margin_m: metres; negative for squared differences.
        out: (k, J, N) written.
    """
    total, others = np.zeros(observed.shape[1]), np.zeros(observed.shape[1])
    for beam in range(len(observed)):
        _add_copy(observed[beam], no_return_m, margin_m, total)
        _count_others(observed[beam], no_return_m, 1.0, others)
    outside, beyond = np.zeros(len(total)), np.zeros(len(total))
    within = np.zeros(len(total))
    for pose in range(len(start) - 1):
        first, last = start[pose], start[pose + 1]
        within[:] = 0.0
        beyond[:] = others
        for row in range(first, last):
            _add_copy(observed[beams[row]], no_return_m, margin_m, within)
            _count_others(observed[beams[row]], no_return_m, -1.0, beyond)
        for i in range(len(outside)):  # where nothing but the pose's beams differs, no rounding is left over
            outside[i] = max(total[i] - within[i], 0.0) if beyond[i] > 0.5 else 0.0
        for j in range(out.shape[1]):
            sums = out[pose, j]
            sums[:] = outside
            row = first
            while row + 4 <= last and margin_m < 0.0:
                _add_four(
                    observed[beams[row]],
                    observed[beams[row + 1]],
                    observed[beams[row + 2]],
                    observed[beams[row + 3]],
                    predicted[row, j],
                    predicted[row + 1, j],
                    predicted[row + 2, j],
                    predicted[row + 3, j],
                    sums,
                )
                row += 4
            while row < last:
                _add_copy(observed[beams[row]], predicted[row, j], margin_m, sums)
                row += 1


@sum_kernel
def _add_copy(z: Floats, predicted: float, margin_m: float, sums: Floats) -> None:
    """Add the differences of one beam of all scans, (N,), and one copy of a pose; missing beams differ by nothing."""
    if margin_m < 0.0:
        for i in range(len(sums)):
            off = z[i] - predicted
            off = off if z[i] == z[i] else 0.0
            sums[i] += off * off
    else:
        for i in range(len(sums)):
            sums[i] += 1.0 if abs(z[i] - predicted) > margin_m + _SLACK_M else 0.0


@sum_kernel
def _count_others(z: Floats, no_return_m: float, sign: float, counts: Floats) -> None:
    for i in range(len(counts)):
        counts[i] += sign if z[i] < no_return_m else 0.0


@sum_kernel
def _add_four(
    z0: Floats, z1: Floats, z2: Floats, z3: Floats, p0: float, p1: float, p2: float, p3: float, sums: Floats
) -> None:
    """Add the squared differences of four beams of all scans, (N,) each, and one copy of a pose."""
    for i in range(len(sums)):
        d0, d1, d2, d3 = z0[i] - p0, z1[i] - p1, z2[i] - p2, z3[i] - p3
        d0 = d0 if z0[i] == z0[i] else 0.0
        d1 = d1 if z1[i] == z1[i] else 0.0
        d2 = d2 if z2[i] == z2[i] else 0.0
        d3 = d3 if z3[i] == z3[i] else 0.0
        sums[i] += d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3


@sum_kernel
def add_inverse_roots(squares: Floats, per_beam: Floats, floor_m: float, sums: Floats) -> None:
    """Add 1 / max(sqrt(d^2 / beams), floor_m) of squares d^2 (J, N) over the copies; `per_beam` (N,) is 1 / beams."""
    for j in range(len(squares)):
        row = squares[j]
        for i in range(len(sums)):
            sums[i] += 1.0 / np.sqrt(max(row[i] * per_beam[i], floor_m * floor_m))


@sum_kernel
def log_sums_of_exp(exponents: Floats, highest: Floats, bits: NDArray[np.int64], out: Floats) -> None:
    """Logarithm of the sum of exp(`exponents`) (J, N) over the copies, (N,); -inf where all are -inf.

    `highest` and `bits` are scratch of N numbers.
    """
    highest[:] = -np.inf
    for j in range(len(exponents)):
        row = exponents[j]
        for i in range(len(out)):
            highest[i] = max(highest[i], row[i])
    out[:] = 0.0
    for i in range(len(out)):
        highest[i] = highest[i] if highest[i] > -np.inf else 0.0
    for j in range(len(exponents)):
        row = exponents[j]
        for i in range(len(out)):
            some = exp_of_negative(row[i] - highest[i])
            out[i] += some if row[i] > -np.inf else 0.0
    take_logarithms(out, bits)
    for i in range(len(out)):
        out[i] += highest[i]
