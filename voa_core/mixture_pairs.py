"""Log-likelihoods of pairs of a scan and a single prediction under the mixture of the rule `beam`.

With p[i, j, k] the density of beam k of scan i under prediction j, as tabled in `rules.beam.Beam`, none[i, k] that
density where no return is predicted, s the probability of a no-return where a return is predicted over that where none
is, and R[j] the number of returns of prediction j,

ln L[i, j] = sum over k of ln none[i, k] + R[j] ln s + sum over k where both return of ln (p[i, j, k] / (none[i, k] s)).

So only beams on which both return need an exponential, and a product of their densities takes one logarithm.

Scans in float32 are compared in float32 where products of some densities fit it: with x standard deviations between
two returns, the logarithm of their density is then off by at most 1e-6 + 3e-7 x^2, and by 2e-5 for any x.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel, kernel
from voa_core.kernels import Array
from voa_core.mixture import Mixture, flush
from voa_core.vector_math import HALVING_WIDTH, exact_half_to_the, half_to_the_float32

_REGISTER = 8  # numbers that a vector register of float32 holds: windows that fill it leave no rest, which is slow
_AT_ONCE = 512  # tables of so many predictions fit in the cache of a processor core
_LEAST = 1e-140  # a density, or s, below this counts as 0: its inverse, and a product of two, fit a float64
_FLOAT32_BYTES = 4
_SMALL = 2e-3  # below this, a series of 1 - e^-x is off by less than 1e-15 of it
_LOG2_E = math.log2(math.e)
_LOG_RANGE, _LOG_RANGE_FLOAT32 = 600.0, 80.0  # products of densities stay within e^-600 and e^600, or e^-80 and e^80
_LEAST_FLOAT32 = 1e-9
_FEWEST_FLOAT32 = 4  # densities of which fewer fit a float32 are too uneven for it


class PredictedReturns(NamedTuple):
    """Predictions as the loops over pairs need them: n of them, neighbours next to each other, on c beams.

    Attributes:
        order: (n,) index of each prediction.
        windows: (c, 2) between which of them all returns on a beam lie.
        means: (c, n) predicted ranges, metres; 0 without a return, as the next two; all three float64 or all float32.
        inverse_widths: (c, n), see `mixture.tabulate`.
        shorts: (c, n) density of an unexpected return at range 0.
        counts: (n,) R[j], number of returns.
    """

    order: NDArray[np.intp]
    windows: NDArray[np.intp]
    means: Array
    inverse_widths: Array
    shorts: Array
    counts: Floats


def log_likelihoods(observed: Array, predicted: Array, mixture: Mixture) -> Array:
    """Log-likelihoods (m, n) of scans (m, c) under predictions (n, c), metres, without missing beams.

    A density, or a probability of a no-return where a return is predicted, of less than 1e-140 counts as 0.
    """
    returned = np.isfinite(observed)
    share = mixture.lost / mixture.nothing if mixture.lost >= _LEAST else 1.0
    decay, ratios, totals = _measured(observed, returned, share, mixture)
    uneven = _unevenness(ratios[returned], float(predicted.min(initial=mixture.range_max)), mixture)
    together, few = max(1, int(_LOG_RANGE / uneven)), int(_LOG_RANGE_FLOAT32 / uneven)
    single = observed.dtype == np.float32 and few >= _FEWEST_FLOAT32 and _numbers_fit_float32(mixture)
    dtype, few, products = (np.float32, few, together // few) if single else (np.float64, together, 1)
    scans, out = np.array(observed, dtype, order="C"), np.zeros((len(observed), len(predicted)), dtype)
    for start in range(0, len(predicted), _AT_ONCE):
        some = _predicted_returns(predicted[start : start + _AT_ONCE], mixture, dtype)
        write_log_likelihoods(
            scans,
            decay,
            ratios,
            totals,
            some,
            some.counts * math.log(share),
            mixture.random,
            mixture.hit_peak / HALVING_WIDTH,
            few,
            products,
            start,
            out,
        )
    if mixture.lost < _LEAST:  # a no-return where a return is predicted is impossible
        out[(~returned).astype(np.float32) @ np.isfinite(predicted).astype(np.float32).T > 0.0] = -np.inf
    return out.astype(observed.dtype, copy=False)


def _measured(
    observed: Array, returned: NDArray[np.bool_], share: float, mixture: Mixture
) -> tuple[Floats, Floats, Floats]:
    """Compute exp(-lambda z) and 1 / (none s), each (m, c) and 0 without a return, and the sum of ln none, (m,)."""
    at_return = np.exp(-mixture.decay_per_m * observed[returned].astype(np.float64))
    reached = -math.expm1(-mixture.decay_per_m * mixture.range_max)
    none = mixture.random + (mixture.nothing - mixture.lost) / mixture.range_max + mixture.short * at_return / reached
    possible = none >= _LEAST
    silent = math.log(mixture.nothing) if mixture.nothing >= _LEAST else -math.inf
    decay, ratios, logs = (np.full(observed.shape, number) for number in (0.0, 0.0, silent))
    decay[returned] = at_return
    ratios[returned] = 1.0 / (np.where(possible, none, 1.0) * share)
    logs[returned] = np.log(none, out=np.full(len(none), -np.inf), where=possible)
    return decay, ratios, logs.sum(axis=1)


def _predicted_returns(predicted: Array, mixture: Mixture, dtype: type[np.floating]) -> PredictedReturns:
    """Tabulate predictions (n, c) in an order in which the returns on each beam lie close together."""
    ranges, (n, beams) = np.array(predicted, np.float64, order="C"), predicted.shape
    windows, counts, middles = np.zeros((beams, 2), dtype=np.intp), np.zeros(n), np.zeros(n)
    find_middles(ranges, counts, middles)
    order = np.argsort(middles, kind="stable")
    means, inverse_widths, shorts = (np.zeros((beams, n)) for _ in range(3))
    tabulate_returns(ranges, order, mixture, windows, means, inverse_widths, shorts)
    means, inverse_widths, shorts = (table.astype(dtype, copy=False) for table in (means, inverse_widths, shorts))
    return PredictedReturns(order, windows, means, inverse_widths, shorts, counts[order])


@kernel
def find_middles(predicted: Floats, counts: Floats, middles: Floats) -> None:
    """Write the number of returns of each of n predictions (n, c), and the beam in the middle of them, each (n,).

    Beams run around the lidar: those of an object that it sees across its last beam begin where fewest return.
    """
    n, beams = predicted.shape
    on_beam = np.zeros(beams, dtype=np.intp)
    for j in range(n):
        for k in range(beams):
            on_beam[k] += predicted[j, k] < np.inf
    first = 0
    for k in range(beams):
        first = k if on_beam[k] < on_beam[first] else first
    for j in range(n):
        count, total = 0, 0
        for k in range(beams):
            returned = predicted[j, k] < np.inf
            count += returned
            total += (k - first if k >= first else k - first + beams) * returned
        counts[j] = count
        middles[j] = total / max(count, 1)


@kernel
def tabulate_returns(
    predicted: Floats,
    order: NDArray[np.intp],
    mixture: Mixture,
    windows: NDArray[np.intp],
    means: Floats,
    inverse_widths: Floats,
    shorts: Floats,
) -> None:
    """Write the tables of `PredictedReturns` for predictions (n, c) in an order (n,).

    Numbers outside the windows (c, 2) mean nothing.
    """
    n, beams = predicted.shape
    bits = np.zeros(n, dtype=np.int64)
    for j in range(n):
        for k in range(beams):
            means[k, j] = predicted[order[j], k]
    for k in range(beams):
        first, last = n, 0
        for j in range(n):
            if means[k, j] < np.inf:
                first, last = min(first, j), j + 1
        if first < last:
            first = first // _REGISTER * _REGISTER
            last = min((last + _REGISTER - 1) // _REGISTER * _REGISTER, n)
            windows[k, 0], windows[k, 1] = first, last
            _tabulate(mixture, means[k, first:last], inverse_widths[k, first:last], shorts[k, first:last], bits)


@frugal_kernel
def _tabulate(mixture: Mixture, means: Floats, inverse_widths: Floats, shorts: Floats, bits: NDArray[np.int64]) -> None:
    """Compute the numbers of the density of each predicted range (w,), see `mixture.tabulate`, within 1e-12 of them."""
    numbers = bits.view(np.float64)
    for j in range(len(means)):
        returns = means[j] < np.inf
        z = means[j] if returns else 0.0
        within = min(max(z, 1e-9), mixture.range_max)
        x = mixture.decay_per_m * within
        series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0))))
        reached = series if x < _SMALL else 1.0 - exact_half_to_the(_LOG2_E * x, numbers, bits, j)
        means[j] = z
        inverse_widths[j] = HALVING_WIDTH / max(mixture.sigma_m, mixture.noise_ratio * within) if returns else 0.0
        shorts[j] = mixture.short / reached if returns else 0.0


def _unevenness(ratios: Floats, nearest: float, mixture: Mixture) -> float:
    """Largest magnitude of the logarithm of p / (none s), at least 1; inf where nothing bounds it.

    Args:
        ratios: 1 / (none s) of every return.
        nearest: smallest range that is predicted, metres.
        mixture: of the rule.
    """
    if mixture.random < _LEAST or len(ratios) == 0:
        return math.inf
    short = mixture.short / -math.expm1(-mixture.decay_per_m * min(max(nearest, 1e-9), mixture.range_max))
    highest = (mixture.random + mixture.hit_peak / mixture.sigma_m + short) * ratios.max()
    return max(-math.log(mixture.random * ratios.min()), math.log(highest), 1.0)


def _numbers_fit_float32(mixture: Mixture) -> bool:
    """Whether the numbers of the mixture lie well within the range of float32."""
    return min(mixture.sigma_m, mixture.random, mixture.range_max) >= _LEAST_FLOAT32


@kernel
def write_log_likelihoods(
    observed: Array,
    decay: Floats,
    ratios: Floats,
    totals: Floats,
    predicted: PredictedReturns,
    rests: Floats,
    random: float,
    peak: float,
    few: int,
    products: int,
    start: int,
    out: Array,
) -> None:
    """Write the log-likelihoods of m scans under n predictions, see the top of this file.

    Args:
        observed: (m, c) ranges, metres, in the type of the tables; inf is a no-return.
        decay: (m, c) exp(-lambda z) of the observed range; 0 without one.
        ratios: (m, c) 1 / (none[i, k] s).
        totals: (m,) sum over k of ln none[i, k].
        predicted: tables of the predictions.
        rests: (n,) R[j] ln s.
        random: density of a random return, 1/m.
        peak: density of a hit at the predicted range itself over its `inverse_widths`.
        few: how many densities a product in the type of the tables holds.
        products: how many such products fit a float64; then the logarithm is taken.
        start: first of the columns of `out` that are written.
        out: (m, at least start + n) written, in the type of the tables.
    """
    n = len(rests)
    product, some, log, bits = np.ones(n), np.ones(n, predicted.means.dtype), np.zeros(n), np.zeros(n, dtype=np.int64)
    for i in range(len(observed)):
        for j in range(n):  # numba takes seconds to compile `log[:] = rests`
            log[j] = rests[j]
        multiplied, carried, low, high = 0, 0, n, 0
        for k in range(observed.shape[1]):
            z, a, b = observed[i, k], predicted.windows[k, 0], predicted.windows[k, 1]
            if z == np.inf or a == b:
                continue
            means, inverse_widths = predicted.means[k, a:b], predicted.inverse_widths[k, a:b]
            shorts, own, ratio = predicted.shorts[k, a:b], some[a:b], ratios[i, k]
            numbers = random * ratio, peak * ratio, decay[i, k] * ratio
            if some.itemsize == _FLOAT32_BYTES:
                _multiply_float32(z, numbers, means, inverse_widths, shorts, own, bits)
            else:
                _multiply_float64(z, numbers, means, inverse_widths, shorts, own, bits)
            multiplied, low, high = multiplied + 1, min(low, a), max(high, b)
            if multiplied == few:
                _carry(some[low:high], product[low:high])
                multiplied, carried = 0, carried + 1
            if carried == products:
                flush(product[low:high], bits, log[low:high])
                carried, low, high = 0, n, 0
        if high > low:
            _carry(some[low:high], product[low:high])
            flush(product[low:high], bits, log[low:high])
        for j in range(n):
            out[i, start + predicted.order[j]] = log[j] + totals[i]


@frugal_kernel
def _carry(some: Array, product: Floats) -> None:
    """Multiply `product` (w,) by `some`, and begin that again with 1."""
    for j in range(len(product)):
        product[j] *= some[j]
        some[j] = 1.0


@frugal_kernel
def _multiply_float64(
    z: float,
    numbers: tuple[float, float, float],
    means: Floats,
    inverse_widths: Floats,
    shorts: Floats,
    product: Floats,
    bits: NDArray[np.int64],
) -> None:
    """Multiply `product` (w,) by the densities of a return at z under w predictions; by 1 where none is predicted.

    `numbers` are the densities of a random return, of a hit, and of an unexpected return, over those in the tables.
    """
    random, peak, decay = numbers
    halves = bits.view(np.float64)
    for j in range(len(product)):
        off = (z - means[j]) * inverse_widths[j]
        hit = exact_half_to_the(off * off, halves, bits, j)
        before = shorts[j] * decay if z <= means[j] else 0.0
        density = random + peak * inverse_widths[j] * hit + before
        product[j] *= density if inverse_widths[j] > 0.0 else 1.0


@frugal_kernel
def _multiply_float32(
    z: np.float32,
    numbers: tuple[float, float, float],
    means: NDArray[np.float32],
    inverse_widths: NDArray[np.float32],
    shorts: NDArray[np.float32],
    product: NDArray[np.float32],
    bits: NDArray[np.int64],
) -> None:
    """Multiply as `_multiply_float64`, with every number a float32."""
    random, peak, decay = np.float32(numbers[0]), np.float32(numbers[1]), np.float32(numbers[2])
    none, one = np.float32(0.0), np.float32(1.0)
    halves, whole = bits.view(np.float32), bits.view(np.int32)
    for j in range(len(product)):
        off = (z - means[j]) * inverse_widths[j]
        hit = half_to_the_float32(off * off, halves, whole, j)
        before = shorts[j] * decay if z <= means[j] else none
        density = random + peak * inverse_widths[j] * hit + before
        product[j] *= density if inverse_widths[j] > none else one
