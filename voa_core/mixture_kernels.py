"""Weights of many scans at many displaced copies under the rule `beam`, without those that are negligible."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copy_kernels import log_sums_of_exp
from voa_core.jit import frugal_kernel, kernel
from voa_core.mixture import MeasuredScans, Mixture, empty_tables, flush, tabulate
from voa_core.mixture_likelihoods import (
    REGISTER,
    likelihood_bound,
    likelihoods,
    log_sums_of_weights,
    multiply_largest,
    write_intervals,
    write_window,
)
from voa_core.outlines import Ints

_SHARE_WORTH_GATHERING = 0.8


@kernel
def mixture_of_copies(
    measured: MeasuredScans,
    own: NDArray[np.intp],
    least: Floats,
    first_pose: int,
    start: NDArray[np.int64],
    beams: Ints,
    predicted: Floats,
    order: NDArray[np.intp],
    cluster: int,
    mixture: Mixture,
    out: Floats,
) -> None:
    """Logarithm of the sum of the weights of every scan over the displaced copies of some poses.

    A bound on the weight of a scan at all copies of a pose comes first, then one at each cluster of copies: what does
    not reach `least` is left out. The bound takes each beam's range where it is the likeliest in the interval that the
    copies predict; no return counts where some copy predicts none.

    Args:
        measured: the scans, arrays (r, N); fastest where scans that return on the same beams are neighbours.
        own: (N,) index of the pose that gives each scan, which is compared with it in any case.
        least: (N,) log weight below which copies are left out; -inf: none are.
        first_pose: index of the first of the poses.
        start: (k + 1,) first row of each of the k poses, and the end.
        beams, predicted: as in `DisplacedScans`.
        order: (J,) the copies, cluster after cluster.
        cluster: number of copies in a cluster, which divides J.
        mixture: of the rule.
        out: (k, N) written: -inf where every copy is left out.
    """
    most = 0
    for pose in range(len(start) - 1):
        most = max(most, start[pose + 1] - start[pose])
    tables = empty_tables(most, predicted.shape[1])
    scratch = _scratch(measured.ranges.shape[0], measured.ranges.shape[1], most, len(order), cluster)
    _weigh(measured, own, least, first_pose, start, beams, predicted, order, cluster, mixture, tables, scratch, out)


@frugal_kernel
def _weigh(
    measured: MeasuredScans,
    own: NDArray[np.intp],
    least: Floats,
    first_pose: int,
    start: NDArray[np.int64],
    beams: Ints,
    predicted: Floats,
    order: NDArray[np.intp],
    cluster: int,
    mixture: Mixture,
    tables: tuple[Floats, Floats, Floats, Floats],
    scratch: "_Scratch",
    out: Floats,
) -> None:
    """`mixture_of_copies`, with arrays for the numbers in use."""
    scans, rests, some = measured.ranges.shape[1], scratch.rests, scratch.some
    for beam in range(len(measured.ranges)):
        write_window(measured.ranges[beam], scratch.all_windows[beam])
    for pose in range(len(start) - 1):
        seen, ranges = beams[start[pose] : start[pose + 1]], predicted[start[pose] : start[pose + 1]]
        for i in range(scans):
            rests[i] = measured.silent[i]
        write_intervals(ranges, order, scratch.intervals)
        _bound_all(measured, seen, mixture, scratch)
        n = 0
        for i in range(scans):  # without a branch, which a processor could not predict
            some[n] = i
            n += (mixture.temper * (rests[i] + scratch.sums[i]) >= least[i]) | (own[i] == first_pose + pose)
        out[pose] = -np.inf
        if n == 0:
            continue
        for row in range(len(seen)):
            tabulate(ranges[row], mixture, tables[0][row], tables[1][row], tables[2][row], tables[3][row])
        limits = scratch.limits[:n]  # what the log-likelihood on the beams of the pose must reach
        for i in range(n):
            is_own = own[some[i]] == first_pose + pose
            limits[i] = -np.inf if is_own else least[some[i]] / mixture.temper - rests[some[i]]
        _sum_over_copies(measured, seen, ranges, limits, order, cluster, tables, mixture, scratch)
        for i in range(n):
            out[pose, some[i]] = scratch.totals[i] + mixture.temper * rests[some[i]]


class _Scratch(NamedTuple):
    """Numbers in use, for at most N scans, rounded up to whole vector registers, on r beams under c copies of J.

    Attributes:
        product, bits, logs: (c N,).
        rests: (scans,) log-likelihood of each scan on the beams that a pose does not meet.
        some, few: (N,) scans that a pose, and a cluster of its copies, may explain.
        limits, sums, totals, highest: (N,).
        parts: (J / c N,).
        of_pose, of_cluster: (3 r N,).
        intervals: (r, 4).
        windows, fewer: (r, 2).
        all_windows: (beams, 2).
    """

    product: Floats
    bits: NDArray[np.int64]
    logs: Floats
    rests: Floats
    some: NDArray[np.uint64]
    few: NDArray[np.uint64]
    limits: Floats
    sums: Floats
    totals: Floats
    highest: Floats
    parts: Floats
    of_pose: Floats
    of_cluster: Floats
    intervals: Floats
    windows: NDArray[np.intp]
    fewer: NDArray[np.intp]
    all_windows: NDArray[np.intp]


@kernel
def _scratch(beams: int, scans: int, rows: int, copies: int, cluster: int) -> _Scratch:
    size = _whole_registers(scans)
    return _Scratch(
        np.ones(cluster * size),
        np.zeros(cluster * size, dtype=np.int64),
        np.zeros(cluster * size),
        np.zeros(scans),
        np.zeros(size, dtype=np.uint64),
        np.zeros(size, dtype=np.uint64),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(copies // cluster * size),
        np.zeros(3 * rows * size),
        np.zeros(3 * rows * size),
        np.zeros((rows, 4)),
        np.zeros((rows, 2), dtype=np.intp),
        np.zeros((rows, 2), dtype=np.intp),
        np.zeros((beams, 2), dtype=np.intp),
    )


@frugal_kernel
def _whole_registers(numbers: int) -> int:
    """Smallest multiple of the numbers in a vector register that is at least `numbers`."""
    return (numbers + REGISTER - 1) // REGISTER * REGISTER


@frugal_kernel
def _bound_all(measured: MeasuredScans, beams: Ints, mixture: Mixture, scratch: _Scratch) -> None:
    """Write upper bounds of the log-likelihood of all scans on some beams to the sums; take them off the rests."""
    rests, bits = scratch.rests, scratch.bits
    n = len(rests)
    product, sums = scratch.product[:n], scratch.sums[:n]
    sums[:] = 0.0
    factors = 0
    for row in range(len(beams)):
        beam = beams[row]
        _subtract(measured.log_none[beam], rests)
        multiply_largest(
            measured.ranges[beam],
            measured.decay[beam],
            measured.none[beam],
            scratch.all_windows[beam],
            scratch.intervals[row],
            mixture,
            product,
            bits,
        )
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, sums)
            factors = 0
    flush(product, bits, sums)


@frugal_kernel
def _sum_over_copies(
    measured: MeasuredScans,
    beams: Ints,
    ranges: Floats,
    limits: Floats,
    order: NDArray[np.intp],
    cluster: int,
    tables: tuple[Floats, Floats, Floats, Floats],
    mixture: Mixture,
    scratch: _Scratch,
) -> None:
    """Write the logarithm of the sum of weights over the copies of a pose to the first n totals, of n scans of `some`.

    The weights are those of the beams (rows,) of the pose; clusters whose log-likelihood stays below `limits` (n,) are
    left out.
    """
    rows, n, size = len(beams), len(limits), _whole_registers(len(limits))
    some, few, sums, intervals = scratch.some, scratch.few, scratch.sums, scratch.intervals
    numbers = scratch.of_pose[: 3 * rows * size].reshape(rows, 3, size)
    for row in range(rows):
        _pick(measured.ranges[beams[row]], some[:size], numbers[row, 0])
        _pick(measured.decay[beams[row]], some[:size], numbers[row, 1])
        _pick(measured.none[beams[row]], some[:size], numbers[row, 2])
        write_window(numbers[row, 0], scratch.windows[row])
    clusters = len(order) // cluster
    parts = scratch.parts[: clusters * size].reshape(clusters, size)
    parts[:] = -np.inf
    for c in range(clusters):
        members = order[c * cluster : (c + 1) * cluster]
        write_intervals(ranges, members, intervals)
        likelihood_bound(
            numbers, scratch.windows, intervals, mixture, scratch.product[:size], scratch.bits, sums[:size]
        )
        m = 0
        for i in range(n):
            few[m] = i
            m += sums[i] >= limits[i]
        if m > _SHARE_WORTH_GATHERING * n:
            _sum_over_cluster(numbers, scratch.windows, members, tables, mixture, scratch, parts[c])
        elif m > 0:
            fit = _whole_registers(m)
            few[m:fit] = few[0]
            fewer = scratch.of_cluster[: 3 * rows * fit].reshape(rows, 3, fit)
            _gather(numbers, few[:fit], intervals, fewer, scratch.fewer)
            _sum_over_cluster(fewer, scratch.fewer, members, tables, mixture, scratch, sums[:fit])
            for i in range(m):
                parts[c, few[i]] = sums[i]
    log_sums_of_exp(parts, scratch.highest[:size], scratch.bits, scratch.totals[:size])


@frugal_kernel
def _sum_over_cluster(
    numbers: Floats,
    windows: NDArray[np.intp],
    members: NDArray[np.intp],
    tables: tuple[Floats, Floats, Floats, Floats],
    mixture: Mixture,
    scratch: _Scratch,
    sums: Floats,
) -> None:
    """Write the logarithm of the sum of the weights of n scans over some copies of a pose, to `sums` (n,)."""
    n, used = len(sums), len(members) * len(sums)
    product, logs = scratch.product[:used], scratch.logs[:used]
    likelihoods(numbers, windows, members, tables, mixture, product, scratch.bits, logs)
    log_sums_of_weights(logs, mixture.temper, scratch.highest[:n], scratch.bits[:n], sums)


@frugal_kernel
def _pick(source: Floats, which: NDArray[np.uint64], target: Floats) -> None:
    for i in range(len(which)):
        target[i] = source[which[i]]


@frugal_kernel
def _subtract(values: Floats, out: Floats) -> None:
    for i in range(len(out)):
        out[i] -= values[i]


@frugal_kernel
def _gather(
    numbers: Floats, which: NDArray[np.uint64], intervals: Floats, out: Floats, windows: NDArray[np.intp]
) -> None:
    """Copy the numbers of some scans; what counts where no return is predicted only where that is needed."""
    for row in range(len(numbers)):
        for k in range(0 if intervals[row, 0] < np.inf else 2, 3 if intervals[row, 2] > 0.0 else 2):
            _pick(numbers[row, k], which, out[row, k])
        if intervals[row, 0] < np.inf:
            write_window(out[row, 0], windows[row])
