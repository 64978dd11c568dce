"""The loops over pairs of scans: one statistic per (observed, predicted) pair, a sum over beams.

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


@sum_kernel
def squared_distances(observed: Array, predicted: Array, out: Array) -> None:
    """Sum of squared differences, directly: the expansion by a matrix product is off by centimetres in float32."""
    for i in range(observed.shape[0]):
        for j in range(predicted.shape[0]):
            total = observed.dtype.type(0.0)
            for k in range(observed.shape[1]):
                difference = observed[i, k] - predicted[j, k]
                total += difference * difference
            out[i, j] = total


@sum_kernel
def squared_distances_among(scans: Array, out: Array) -> None:
    """`squared_distances(scans, scans)` by one triangle."""
    for i in range(scans.shape[0]):
        out[i, i] = 0.0
        for j in range(i + 1, scans.shape[0]):
            total = scans.dtype.type(0.0)
            for k in range(scans.shape[1]):
                difference = scans[i, k] - scans[j, k]
                total += difference * difference
            out[i, j] = total
            out[j, i] = total


@kernel
def disagreements(observed: Array, predicted: Array, margin: float, out: Array) -> None:
    """Number of beams that differ by more than `margin` (and a nanometre, for rounding)."""
    for i in range(observed.shape[0]):
        for j in range(predicted.shape[0]):
            count = 0
            for k in range(observed.shape[1]):
                if abs(observed[i, k] - predicted[j, k]) > margin + _MARGIN_SLACK_M:
                    count += 1
            out[i, j] = count


@kernel
def mixture_log_likelihoods(
    observed: Array,
    predicted: Array,
    short_decay: Floats,
    log_if_none: Floats,
    inverse_sigma: Floats,
    hit_peak: Floats,
    short_peak: Floats,
    log_lost: float,
    random_density: float,
    log_both_none: float,
    out: Array,
) -> None:
    """Sum over beams of the logarithm of the mixture that `rules.Beam` states; inf is a no-return.

    Args:
        observed: (m, c) ranges.
        predicted: (n, c) ranges.
        short_decay: (m, c) exp(-lambda z) of the observed range.
        log_if_none: (m, c) log-density of the observed return where none is predicted.
        inverse_sigma: (n, c) 1 / standard deviation of the predicted range.
        hit_peak: (n, c) density of a hit at the predicted range itself.
        short_peak: (n, c) factor of `short_decay` in the density of a return before the predicted one.
        log_lost: log-probability of a no-return where a return is predicted.
        random_density: density of a return anywhere.
        log_both_none: log-probability of a no-return where none is predicted.
        out: (m, n).
    """
    for i in range(observed.shape[0]):
        for j in range(predicted.shape[0]):
            total = 0.0
            product = 1.0  # of densities: one logarithm for many beams
            for k in range(observed.shape[1]):
                z, expected = observed[i, k], predicted[j, k]
                if expected == np.inf:
                    total += log_both_none if z == np.inf else log_if_none[i, k]
                elif z == np.inf:
                    total += log_lost
                else:
                    off = (z - expected) * inverse_sigma[j, k]
                    density = random_density + hit_peak[j, k] * math.exp(-0.5 * off * off)
                    if z <= expected:
                        density += short_peak[j, k] * short_decay[i, k]
                    if density < 1e-100:  # the product might underflow, its logarithm does not
                        total += math.log(density) if density > 0.0 else -math.inf
                        continue
                    product *= density
                    if not 1e-100 < product < 1e100:
                        total += math.log(product)
                        product = 1.0
            out[i, j] = total + math.log(product)
