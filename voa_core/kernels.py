"""Loops over pairs of scans, compiled: one statistic per (observed, predicted) pair, a sum over beams.

`observed` is (m, c), `predicted` (n, c), `out` (m, n), all of one float type.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel, sum_kernel

Array = NDArray[Any]
"""Float arrays of either size: float64 for updates, float32 for large rankings."""

_MARGIN_SLACK_M = 1e-9
_TILE = 16
_LEAST = -700.0  # exp of less is not worth a float64's last exponents
_LN_2, _LOG2_E = math.log(2.0), math.log2(math.e)
_EXP = tuple(1.0 / math.factorial(power) for power in range(14))


@sum_kernel
def squared_distances(observed: Array, predicted: Array, out: Array) -> None:
    """Sum the squared differences of each pair of scans, metres squared.

    The expansion by a matrix product would be off by centimetres in float32.
    """
    for i in range(observed.shape[0]):
        for j in range(predicted.shape[0]):
            total = observed.dtype.type(0.0)
            for k in range(observed.shape[1]):
                difference = observed[i, k] - predicted[j, k]
                total += difference * difference
            out[i, j] = total


@sum_kernel
def squared_distances_among(scans: Array, out: Array) -> None:
    """Sum the squared differences of each pair of `scans` (n, c), computing one triangle of (n, n) and copying it."""
    n, c = scans.shape
    columns = np.zeros(((c + 3) // 4 * 4, n), dtype=scans.dtype)  # in fours: rows of `out` are gone over less often
    columns[:c] = scans.T
    for i in range(n):
        row = out[i, i:]
        row[:] = 0.0
        for k in range(0, len(columns), 4):
            z0, z1, z2, z3 = columns[k, i], columns[k + 1, i], columns[k + 2, i], columns[k + 3, i]
            c0, c1, c2, c3 = columns[k, i:], columns[k + 1, i:], columns[k + 2, i:], columns[k + 3, i:]
            for j in range(len(row)):
                d0, d1, d2, d3 = z0 - c0[j], z1 - c1[j], z2 - c2[j], z3 - c3[j]
                row[j] += d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3
    _mirror(out)


@kernel
def _mirror(square: Array) -> None:
    """Copy the upper triangle to the lower, in tiles: whole columns would miss the cache at every entry."""
    n = len(square)
    for top in range(0, n, _TILE):
        for left in range(top, n, _TILE):
            for i in range(top, min(top + _TILE, n)):
                for j in range(max(left, i + 1), min(left + _TILE, n)):
                    square[j, i] = square[i, j]


@kernel
def disagreements(observed: Array, predicted: Array, margin: float, out: Array) -> None:
    """Count the beams of each pair of scans that differ by more than `margin` metres (and a nanometre for rounding)."""
    for i in range(observed.shape[0]):
        for j in range(predicted.shape[0]):
            count = 0
            for k in range(observed.shape[1]):
                if abs(observed[i, k] - predicted[j, k]) > margin + _MARGIN_SLACK_M:
                    count += 1
            out[i, j] = count


@kernel
def mixture_likelihoods(
    observed: Array,
    short_decay: Floats,
    if_none: Floats,
    unseen: Floats,
    start: NDArray[np.int64],
    poses: NDArray[np.int64],
    predicted: Floats,
    inverse_sigma: Floats,
    hit_peak: Floats,
    short_peak: Floats,
    random_density: float,
    beams_per_logarithm: int,
    products: Floats,
    logs: Floats,
) -> None:
    """Likelihoods of whole scans under the mixture of `rules.beam.Beam`, as `products * exp(logs)`.

    Each beam multiplies a row of densities, one for every predicted scan, into a row of `products`. The normal
    density is needed only where a return is predicted: those h returns are given separately, beam after beam.

    Args:
        observed: (m, c) ranges; inf is a no-return.
        short_decay: (m, c) exp(-lambda z) of the observed range.
        if_none: (m, c) density of the observed return where none is predicted.
        unseen: (c, n) probability of a no-return.
        start: (c + 1,) index of the first predicted return of each beam.
        poses: (h,) index of the scan, of n, that predicts each return.
        predicted: (h,) their ranges.
        inverse_sigma: (h,) 1 / standard deviation.
        hit_peak: (h,) density of a hit at the predicted range itself.
        short_peak: (h,) factor of `short_decay` in the density of a return before the predicted one.
        random_density: density of a return anywhere.
        beams_per_logarithm: how many densities a product holds; then its logarithm goes to `logs`.
        products, logs: (m, n), written.
    """
    row = np.zeros(unseen.shape[1])
    bits, normal = np.zeros(len(row), dtype=np.int64), np.zeros(len(row))
    for i in range(len(observed)):
        product, log = products[i], logs[i]
        product[:] = 1.0
        log[:] = 0.0
        for k in range(observed.shape[1]):
            z, a, b = observed[i, k], start[k], start[k + 1]
            if z == np.inf:
                _multiply(product, unseen[k])
            else:
                _normal(z, predicted[a:b], inverse_sigma[a:b], bits, normal)
                _mix(z, short_decay[i, k], random_density, predicted[a:b], hit_peak[a:b], short_peak[a:b], normal)
                row[:] = if_none[i, k]
                where = poses[a:b]
                for h in range(len(where)):
                    row[where[h]] = normal[h]
                _multiply(product, row)
            if (k + 1) % beams_per_logarithm == 0:
                for j in range(len(product)):
                    log[j] += np.log(product[j])
                product[:] = 1.0


@kernel
def _multiply(product: Floats, row: Floats) -> None:
    """Multiply `product` by `row` in place, (n,) each; numba would make a temporary array of `product *= row`."""
    for j in range(len(product)):
        product[j] *= row[j]


@sum_kernel
def _mix(
    z: float,
    short_decay: float,
    random_density: float,
    predicted: Floats,
    hit_peak: Floats,
    short_peak: Floats,
    normal: Floats,
) -> None:
    """Compute the density of one return under each of (h,) predicted ones, over the normal densities in `normal`."""
    for h in range(len(predicted)):
        short = short_decay if z <= predicted[h] else 0.0
        normal[h] = random_density + hit_peak[h] * normal[h] + short_peak[h] * short


@sum_kernel
def _normal(z: float, mean: Floats, inverse_sigma: Floats, bits: NDArray[np.int64], out: Floats) -> None:
    """Compute exp(-((z - mean) / sigma)^2 / 2) for (h,) means, in vector registers; below exp(-700) it is 0.

    exp(x) = 2^k exp(r), with r = x - k ln 2 small enough for a short series, and 2^k written as the bits of a
    float64. `bits` is scratch.
    """
    powers = bits.view(np.float64)
    for h in range(len(mean)):
        off = (z - mean[h]) * inverse_sigma[h]
        x = -0.5 * off * off
        k = math.floor(max(x, _LEAST) * _LOG2_E + 0.5)
        r = max(x, _LEAST) - k * _LN_2
        p = _EXP[13]
        p = p * r + _EXP[12]
        p = p * r + _EXP[11]
        p = p * r + _EXP[10]
        p = p * r + _EXP[9]
        p = p * r + _EXP[8]
        p = p * r + _EXP[7]
        p = p * r + _EXP[6]
        p = p * r + _EXP[5]
        p = p * r + _EXP[4]
        p = p * r + _EXP[3]
        p = p * r + _EXP[2]
        p = p * r + _EXP[1]
        p = p * r + _EXP[0]
        out[h] = p if x > _LEAST else 0.0
        bits[h] = (k + 1023) << 52
    for h in range(len(mean)):
        out[h] *= powers[h]
