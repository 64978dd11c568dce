"""Likelihoods of many scans under single copies of a pose, and bounds of them, for the rule `beam`."""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel
from voa_core.mixture import FAR_M, Mixture, flush
from voa_core.vector_math import HALVING_WIDTH, bound_of_half_to_the, half_to_the, take_logarithms

REGISTER = 4
"""Numbers that a vector register holds; loops over a multiple of them are the fastest."""
_LOG2_E = math.log2(math.e)


@frugal_kernel
def write_intervals(predicted: Floats, members: NDArray[np.intp], out: Floats) -> None:
    """Write the interval of the ranges (rows, J) that some copies predict on each beam, and 1 if some predicts none."""
    for row in range(len(predicted)):
        low, high, none = np.inf, -np.inf, 0.0
        for j in members:
            z = predicted[row, j]
            low = min(low, z)
            if z < np.inf:
                high = max(high, z)
            else:
                none = 1.0
        out[row, 0], out[row, 1], out[row, 2] = low, high, none


@frugal_kernel
def write_window(ranges: Floats, out: NDArray[np.intp]) -> None:
    """Write the bounds of the indices (2,) between which all returns among the ranges (n,) of scans lie.

    The indices between them fill whole vector registers where n does: loops over what is left would be slow.
    """
    first, last = 0, len(ranges)
    while first < last and ranges[first] >= FAR_M:
        first += 1
    while last > first and ranges[last - 1] >= FAR_M:
        last -= 1
    out[0] = first // REGISTER * REGISTER
    out[1] = min((last + REGISTER - 1) // REGISTER * REGISTER, len(ranges))


@frugal_kernel
def likelihood_bound(
    numbers: Floats,
    windows: NDArray[np.intp],
    intervals: Floats,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    out: Floats,
) -> None:
    """Upper bounds (n,) of the log-likelihood of n scans on the beams of a pose, under some of its copies.

    Args:
        numbers: (rows, 3, n) the first three of `MeasuredScans` on each beam of the pose.
        windows: (rows, 2) of the scans that return, see `write_window`.
        intervals: (rows, 4) see `write_intervals`.
        mixture: of the rule.
        product: (n,) ones, in use.
        bits: (n,) scratch.
        out: (n,) written.
    """
    out[:] = 0.0
    factors = 0
    for row in range(len(numbers)):
        own = numbers[row]
        multiply_largest(own[0], own[1], own[2], windows[row], intervals[row], mixture, product, bits)
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, out)
            factors = 0
    flush(product, bits, out)


@frugal_kernel
def multiply_largest(
    z: Floats,
    decay: Floats,
    none: Floats,
    window: NDArray[np.intp],
    interval: Floats,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
) -> None:
    """Multiply `product` (n,) by upper bounds of the densities of one beam of n scans under some copies of a pose.

    Scans outside the window do not return, and need no exponential.
    """
    low, high, may_be_none = interval[0], interval[1], interval[2]
    if low == np.inf:
        _multiply(none, product)
        return
    near, far = min(max(low, 1e-9), mixture.range_max), min(max(high, 1e-9), mixture.range_max)
    inverse = HALVING_WIDTH / max(mixture.sigma_m, mixture.noise_ratio * far)
    peak = mixture.hit_peak / max(mixture.sigma_m, mixture.noise_ratio * near) / mixture.random
    short = mixture.short / -math.expm1(-mixture.decay_per_m * near) / mixture.random
    a, b = window[0], window[1]
    own = z[a:b], decay[a:b], none[a:b]
    _multiply_bounds(*own, low, high, inverse, peak, short, may_be_none, product[a:b], bits)
    if may_be_none > 0.0:
        _multiply(none[:a], product[:a])
        _multiply(none[b:], product[b:])


@frugal_kernel
def _multiply_bounds(
    z: Floats,
    decay: Floats,
    none: Floats,
    low: float,
    high: float,
    inverse: float,
    peak: float,
    short: float,
    may_be_none: float,
    product: Floats,
    bits: NDArray[np.int64],
) -> None:
    """Multiply `product` (n,) by the largest densities under a return between two ranges, or none if it may be."""
    numbers = bits.view(np.float64)
    for i in range(len(product)):
        off = (z[i] - min(max(z[i], low), high)) * inverse
        before = short * decay[i]
        hit = peak * bound_of_half_to_the(off * off, numbers, bits, i)
        product[i] *= max(1.0 + hit + (before if z[i] <= high else 0.0), may_be_none * none[i])


@frugal_kernel
def likelihoods(
    numbers: Floats,
    windows: NDArray[np.intp],
    members: NDArray[np.intp],
    tables: tuple[Floats, Floats, Floats, Floats],
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    out: Floats,
) -> None:
    """Log-likelihoods of n scans on the beams of a pose, under each of k of its copies.

    Args:
        numbers, windows, mixture: as in `likelihood_bound`.
        members: (k,) indices of the copies.
        tables: four numbers of each beam and copy, see `mixture.tabulate`.
        product: (k n,) ones, in use.
        bits: (k n,) scratch.
        out: (k n,) written, one copy after the other.
    """
    n = numbers.shape[2]
    means, inverses, peaks, shorts = tables
    out[:] = 0.0
    factors = 0
    for row in range(len(numbers)):
        z, decay, none = numbers[row, 0], numbers[row, 1], numbers[row, 2]
        a, b = windows[row, 0], windows[row, 1]
        for index in range(len(members)):
            copy, own = members[index], product[index * n : (index + 1) * n]
            mean, inverse = means[row, copy], inverses[row, copy]
            if inverse == 0.0:
                _multiply(none, own)
            else:
                _multiply_scans(z[a:b], decay[a:b], mean, inverse, peaks[row, copy], shorts[row, copy], own[a:b], bits)
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, out)
            factors = 0
    flush(product, bits, out)


@frugal_kernel
def _multiply(values: Floats, product: Floats) -> None:
    for i in range(len(product)):
        product[i] *= values[i]


@frugal_kernel
def _multiply_scans(
    z: Floats,
    decay: Floats,
    mean: float,
    inverse: float,
    peak: float,
    short: float,
    product: Floats,
    bits: NDArray[np.int64],
) -> None:
    """Multiply `product` (n,) by the densities of one beam of n scans under a predicted return."""
    numbers = bits.view(np.float64)
    for i in range(len(product)):
        off = (z[i] - mean) * inverse
        before = short * decay[i]
        product[i] *= 1.0 + peak * half_to_the(off * off, numbers, bits, i) + (before if z[i] <= mean else 0.0)


@frugal_kernel
def log_sums_of_weights(logs: Floats, temper: float, highest: Floats, bits: NDArray[np.int64], out: Floats) -> None:
    """Write the logarithm of the sum of exp(temper L) over k copies, (n,), with L the log-likelihoods (k n,).

    `highest` is scratch of n numbers, `bits` of n.
    """
    n, numbers, scale = len(out), bits.view(np.float64), temper * _LOG2_E
    for i in range(n):
        highest[i] = logs[i]
    for index in range(1, len(logs) // n):
        own = logs[index * n : (index + 1) * n]
        for i in range(n):
            highest[i] = max(highest[i], own[i])
    out[:] = 0.0
    for index in range(len(logs) // n):
        own = logs[index * n : (index + 1) * n]
        for i in range(n):
            out[i] += half_to_the(scale * (highest[i] - own[i]), numbers, bits, i)
    take_logarithms(out, bits)
    for i in range(n):
        out[i] += temper * highest[i]
