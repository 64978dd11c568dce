"""Likelihoods of many scans under single copies of a pose, and bounds of them, for the rule `beam`."""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel, sum_kernel
from voa_core.mixture import Mixture, flush
from voa_core.vector_math import bound_of_exp, exp_of_negative


@kernel
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


@kernel
def likelihood_bound(
    numbers: Floats,
    rows: int,
    intervals: Floats,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    out: Floats,
) -> None:
    """Upper bounds (n,) of the log-likelihood of n scans on the beams of a pose, under some of its copies."""
    n = len(out)
    out[:] = 0.0
    factors = 0
    for row in range(rows):
        own = numbers[row]
        multiply_largest(own[0, :n], own[1, :n], own[2, :n], own[3, :n], intervals[row], mixture, product)
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, out)
            factors = 0
    flush(product, bits, out)


@kernel
def multiply_largest(
    z: Floats, base: Floats, decay: Floats, none: Floats, interval: Floats, mixture: Mixture, product: Floats
) -> None:
    """Multiply `product` (n,) by upper bounds of the densities of one beam of n scans under some copies of a pose."""
    low, high = interval[0], interval[1]
    if low == np.inf:
        _multiply(none, product)
        return
    near, far = min(max(low, 1e-9), mixture.range_max), min(max(high, 1e-9), mixture.range_max)
    inverse = 1.0 / max(mixture.sigma_m, mixture.noise_ratio * far)
    peak = mixture.hit_peak / max(mixture.sigma_m, mixture.noise_ratio * near)
    short = mixture.short / -math.expm1(-mixture.decay_per_m * near)
    _multiply_bounds(z, base, decay, none, low, high, inverse, peak, short, interval[2], product)


@sum_kernel
def _multiply_bounds(
    z: Floats,
    base: Floats,
    decay: Floats,
    none: Floats,
    low: float,
    high: float,
    inverse: float,
    peak: float,
    short: float,
    may_be_none: float,
    product: Floats,
) -> None:
    for i in range(len(product)):
        off = (z[i] - min(max(z[i], low), high)) * inverse
        before = short * decay[i]
        density = base[i] + peak * bound_of_exp(-0.5 * off * off) + (before if z[i] <= high else 0.0)
        product[i] *= max(density, may_be_none * none[i])


@kernel
def likelihood(
    numbers: Floats,
    rows: int,
    tables: tuple[Floats, Floats, Floats, Floats],
    copy: int,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    out: Floats,
) -> None:
    """Log-likelihood (n,) of n scans on the beams of a pose, under one of its copies."""
    n = len(out)
    means, inverses, peaks, shorts = tables
    out[:] = 0.0
    factors = 0
    for row in range(rows):
        own, inverse = numbers[row], inverses[row, copy]
        if inverse == 0.0:
            _multiply(own[3, :n], product)
        else:
            mean, peak, short = means[row, copy], peaks[row, copy], shorts[row, copy]
            _multiply_scans(own[0, :n], own[1, :n], own[2, :n], mean, inverse, peak, short, product)
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, out)
            factors = 0
    flush(product, bits, out)


@sum_kernel
def _multiply(values: Floats, product: Floats) -> None:
    for i in range(len(product)):
        product[i] *= values[i]


@sum_kernel
def _multiply_scans(
    z: Floats, base: Floats, decay: Floats, mean: float, inverse: float, peak: float, short: float, product: Floats
) -> None:
    """Multiply `product` (n,) by the densities of one beam of n scans under a predicted return."""
    for i in range(len(product)):
        off = (z[i] - mean) * inverse
        before = short * decay[i]
        product[i] *= base[i] + peak * exp_of_negative(-0.5 * off * off) + (before if z[i] <= mean else 0.0)
