"""Mixture of the rule `beam` for many displaced copies: its numbers, and the tables that loops share.

Densities are those of `rules.beam.Beam`. A scan is compared on the beams that meet a pose; on all others each copy
predicts a no-return, and the density of that counts once for the scan.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel, kernel, sum_kernel
from voa_core.outlines import Ints
from voa_core.vector_math import HALVING_WIDTH, exp_of_negative, half_to_the, take_logarithms

_SMALL = 1e-3
FAR_M = 1e30
"""Range of a scan that stands for no return, metres."""


class Mixture(NamedTuple):
    """Numbers of the mixture of the rule `beam`.

    Attributes:
        hit_peak: density of a hit with a standard deviation of 1 m at the predicted range.
        short: density of an unexpected return at range 0 before an object at infinity, 1/m.
        random: density of a random return, 1/m.
        lost: probability of a no-return where a return is predicted.
        nothing: probability of a no-return where none is predicted.
        decay_per_m: decay of unexpected returns with range.
        sigma_m, noise_ratio: standard deviation of a hit: the larger of the first, and of the second times the range.
        range_max: metres.
        temper: exponent of the product over beams.
        factors: densities whose product surely fits a float64.
    """

    hit_peak: float
    short: float
    random: float
    lost: float
    nothing: float
    decay_per_m: float
    sigma_m: float
    noise_ratio: float
    range_max: float
    temper: float
    factors: int


class MeasuredScans(NamedTuple):
    """Scans as the mixture needs them, the first four arrays of one shape: (N, r), or (r, N) where lanes are scans.

    Densities are over that of the beam apart from hits and unexpected returns, so that each is at least 1, and is 1
    where a return is predicted and none is measured.

    Attributes:
        ranges: metres; very far for a no-return and for a missing beam.
        decay: exp(-decay_per_m z); 0 without a return.
        none: density where no return is predicted; 1 for a missing beam.
        log_none: its logarithm.
        silent: (N,) log-likelihood of each scan where no return is predicted on any beam.
    """

    ranges: Floats
    decay: Floats
    none: Floats
    log_none: Floats
    silent: Floats

    def by_beam(self, order: NDArray[np.intp]) -> "MeasuredScans":
        """Sort scans (N, r) into an order (N,), and by their beams: (r, N)."""
        ranges, decay, none, log_none = (np.ascontiguousarray(each[order].T) for each in self[:4])
        return MeasuredScans(ranges, decay, none, log_none, self.silent[order])


def measured_scans(observed: Floats, mixture: Mixture) -> MeasuredScans:
    """Prepare classified scans (N, r) for the loops below."""
    missing, returned = np.isnan(observed), np.isfinite(observed)
    ranges = np.where(returned, observed, FAR_M)
    decay = np.where(returned, np.exp(-mixture.decay_per_m * np.where(returned, observed, 0.0)), 0.0)
    reached = -math.expm1(-mixture.decay_per_m * mixture.range_max)
    background = mixture.random + (mixture.nothing - mixture.lost) / mixture.range_max
    none = np.where(returned, background + mixture.short * decay / reached, mixture.nothing)
    none[missing] = 1.0
    base = np.where(missing, 1.0, np.where(returned, mixture.random, mixture.lost))
    return MeasuredScans(ranges, decay, none / base, np.log(none / base), np.log(none).sum(axis=1))


@sum_kernel
def tabulate(
    predicted: Floats, mixture: Mixture, means: Floats, inverse_widths: Floats, peaks: Floats, shorts: Floats
) -> None:
    """Compute the four numbers of the density of each predicted range (h,); without a return all are 0.

    A hit has the density `peaks` 2^-(`inverse_widths` (z - `means`))^2, see `vector_math.HALVING_WIDTH`. Densities are
    over that of a random return.
    """
    peak, short = mixture.hit_peak / mixture.random, mixture.short / mixture.random
    for h in range(len(predicted)):
        returns = predicted[h] < np.inf
        z = predicted[h] if returns else 0.0
        within = min(max(z, 1e-9), mixture.range_max)
        inverse = 1.0 / max(mixture.sigma_m, mixture.noise_ratio * within)
        x = mixture.decay_per_m * within
        series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)))
        reached = series if x < _SMALL else 1.0 - exp_of_negative(-x)
        means[h] = z
        inverse_widths[h] = HALVING_WIDTH * inverse if returns else 0.0
        peaks[h] = peak * inverse if returns else 0.0
        shorts[h] = short / reached if returns else 0.0


@kernel
def empty_tables(rows: int, copies: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Make tables (rows, J) of the four numbers that `tabulate` writes."""
    shape = (rows, copies)
    return np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)


@frugal_kernel
def flush(product: Floats, bits: NDArray[np.int64], log: Floats) -> None:
    """Add the logarithms of `product` to `log`, and begin again with 1."""
    take_logarithms(product, bits)
    for i in range(len(log)):
        log[i] += product[i]
    product[:] = 1.0


@kernel
def mixture_of_pairs(
    measured: MeasuredScans,
    scans: NDArray[np.intp],
    poses: NDArray[np.intp],
    start: NDArray[np.int64],
    beams: Ints,
    predicted: Floats,
    mixture: Mixture,
    out: Floats,
) -> None:
    """Log-likelihood of pairs of a scan and a pose, for each displaced copy of the pose.

    Args:
        measured: the scans, arrays (N, r).
        scans, poses: (P,) indices of each pair; fastest where pairs of one pose are neighbours.
        start, beams, predicted: as in `DisplacedScans`.
        mixture: of the rule.
        out: (P, J) written.
    """
    copies, most = predicted.shape[1], 0
    for pose in poses:
        most = max(most, start[pose + 1] - start[pose])
    means, inverses, peaks, shorts = empty_tables(most, copies)
    bits, product, tabulated = np.zeros(copies, dtype=np.int64), np.ones(copies), np.zeros(most, dtype=np.bool_)
    done = -1
    for pair in range(len(scans)):
        scan, pose, log = scans[pair], poses[pair], out[pair]
        first, last = start[pose], start[pose + 1]
        if pose != done:
            tabulated[:] = False
            done = pose
        rest, factors = measured.silent[scan], 0
        log[:] = 0.0
        for row in range(first, last):
            beam, k = beams[row], row - first
            z, none = measured.ranges[scan, beam], measured.none[scan, beam]
            rest -= measured.log_none[scan, beam]
            if z >= FAR_M:
                if none == 1.0 or not _has_gaps(predicted[row]):
                    continue
                _multiply_gaps(predicted[row], none, product)
            else:
                if not tabulated[k]:
                    tabulate(predicted[row], mixture, means[k], inverses[k], peaks[k], shorts[k])
                    tabulated[k] = True
                own = means[k], inverses[k], peaks[k], shorts[k]
                _multiply_copies(z, measured.decay[scan, beam], none, own, product, bits)
            factors += 1
            if factors == mixture.factors:
                flush(product, bits, log)
                factors = 0
        flush(product, bits, log)
        log += rest


@frugal_kernel
def _has_gaps(predicted: Floats) -> bool:
    """Whether a copy predicts no return on a beam (J,)."""
    farthest = 0.0
    for j in range(len(predicted)):
        farthest = max(farthest, predicted[j])
    return farthest == np.inf


@frugal_kernel
def _multiply_gaps(predicted: Floats, none: float, product: Floats) -> None:
    """Multiply `product` (J,) by the density of a no-return where none is predicted."""
    for j in range(len(product)):
        product[j] *= none if predicted[j] == np.inf else 1.0


@frugal_kernel
def _multiply_copies(
    z: float,
    decay: float,
    none: float,
    table: tuple[Floats, Floats, Floats, Floats],
    product: Floats,
    bits: NDArray[np.int64],
) -> None:
    """Multiply `product` (J,) by the density of a return under each copy of a pose."""
    means, inverse_widths, peaks, shorts = table
    numbers = bits.view(np.float64)
    for j in range(len(product)):
        off = (z - means[j]) * inverse_widths[j]
        before = shorts[j] * decay if z <= means[j] else 0.0
        density = 1.0 + peaks[j] * half_to_the(off * off, numbers, bits, j) + before
        product[j] *= density if inverse_widths[j] > 0.0 else none
