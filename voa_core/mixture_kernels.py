"""Weights of many scans at many displaced copies under the rule `beam`, without those that are negligible."""

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copy_kernels import log_sums_of_exp
from voa_core.jit import kernel
from voa_core.mixture import MeasuredScans, Mixture, empty_tables, flush, tabulate
from voa_core.mixture_likelihoods import likelihood, likelihood_bound, multiply_largest, write_intervals
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
        measured: the scans, arrays (r, N).
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
    scans, copies, most = measured.ranges.shape[1], predicted.shape[1], 0
    for pose in range(len(start) - 1):
        most = max(most, start[pose + 1] - start[pose])
    tables = empty_tables(most, copies)
    intervals = np.zeros((most, 4))
    of_pose, of_cluster = np.zeros((most, 4, scans)), np.zeros((most, 4, scans))
    bits, product, sums = np.zeros(scans, dtype=np.int64), np.ones(scans), np.zeros(scans)
    rests, limits, some = np.zeros(scans), np.zeros(scans), np.zeros(scans, dtype=np.intp)
    totals = np.zeros(scans)
    for beam in range(len(measured.ranges)):
        totals += measured.log_none[beam]
    for pose in range(len(start) - 1):
        rows = start[pose + 1] - start[pose]
        seen, ranges = beams[start[pose] : start[pose + 1]], predicted[start[pose] : start[pose + 1]]
        for row in range(rows):
            tabulate(ranges[row], mixture, tables[0][row], tables[1][row], tables[2][row], tables[3][row])
        rests[:] = totals
        write_intervals(ranges, order, intervals)
        _bound_all(measured, seen, intervals, mixture, product, bits, rests, sums)
        n = 0
        for i in range(scans):  # without a branch, which a processor could not predict
            some[n] = i
            n += (mixture.temper * (rests[i] + sums[i]) >= least[i]) | (own[i] == first_pose + pose)
        out[pose] = -np.inf
        if n == 0:
            continue
        for row in range(rows):
            _pick(measured.ranges[seen[row]], some[:n], of_pose[row, 0])
            _pick(measured.base[seen[row]], some[:n], of_pose[row, 1])
            _pick(measured.decay[seen[row]], some[:n], of_pose[row, 2])
            _pick(measured.none[seen[row]], some[:n], of_pose[row, 3])
        for i in range(n):  # what the log-likelihood on the beams of the pose must reach
            limits[i] = least[some[i]] / mixture.temper - rests[some[i]]
            limits[i] = -np.inf if own[some[i]] == first_pose + pose else limits[i]
        _sum_over_copies(
            of_pose, of_cluster, ranges, order, cluster, limits[:n], tables, intervals, mixture, product, bits, sums
        )
        for i in range(n):
            out[pose, some[i]] = sums[i] + mixture.temper * rests[some[i]]


@kernel
def _bound_all(
    measured: MeasuredScans,
    beams: Ints,
    intervals: Floats,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    rests: Floats,
    sums: Floats,
) -> None:
    """Write upper bounds of the log-likelihood of all scans on some beams to `sums`; take these beams off `rests`."""
    sums[:] = 0.0
    factors = 0
    for row in range(len(beams)):
        beam = beams[row]
        _subtract(measured.log_none[beam], rests)
        multiply_largest(
            measured.ranges[beam],
            measured.base[beam],
            measured.decay[beam],
            measured.none[beam],
            intervals[row],
            mixture,
            product,
        )
        factors += 1
        if factors == mixture.factors:
            flush(product, bits, sums)
            factors = 0
    flush(product, bits, sums)


@kernel
def _sum_over_copies(
    of_pose: Floats,
    of_cluster: Floats,
    ranges: Floats,
    order: NDArray[np.intp],
    cluster: int,
    limits: Floats,
    tables: tuple[Floats, Floats, Floats, Floats],
    intervals: Floats,
    mixture: Mixture,
    product: Floats,
    bits: NDArray[np.int64],
    sums: Floats,
) -> None:
    """Write the logarithm of the sum of weights over the copies of a pose, (n,).

    The weights are those of the beams (rows,) of the pose; clusters whose log-likelihood stays below `limits` (n,) are
    left out.
    """
    rows, n, copies = len(ranges), len(limits), len(order)
    few, every, bounds = np.zeros(n, dtype=np.intp), np.arange(n), np.zeros(n)
    parts = np.full((copies // cluster, n), -np.inf)
    for c in range(0, copies, cluster):
        members = order[c : c + cluster]
        write_intervals(ranges, members, intervals)
        likelihood_bound(of_pose, rows, intervals, mixture, product[:n], bits, bounds)
        m = 0
        for i in range(n):
            few[m] = i
            m += bounds[i] >= limits[i]
        whole = m > _SHARE_WORTH_GATHERING * n
        m = n if whole else m
        if m == 0:
            continue
        if not whole:
            _gather(of_pose, few[:m], intervals, rows, of_cluster)
        numbers, which = (of_pose, every) if whole else (of_cluster, few)
        logs = np.zeros((cluster, m))
        for index in range(cluster):
            log = logs[index]
            likelihood(numbers, rows, tables, members[index], mixture, product[:m], bits, log)
            for i in range(m):
                log[i] *= mixture.temper
        log_sums_of_exp(logs, sums[:m], bits)
        part = parts[c // cluster]
        for i in range(m):
            part[which[i]] = sums[i]
    log_sums_of_exp(parts, sums[:n], bits)


@kernel
def _pick(source: Floats, which: NDArray[np.intp], target: Floats) -> None:
    for i in range(len(which)):
        target[i] = source[which[i]]


@kernel
def _subtract(values: Floats, out: Floats) -> None:
    for i in range(len(out)):
        out[i] -= values[i]


@kernel
def _gather(numbers: Floats, which: NDArray[np.intp], intervals: Floats, rows: int, out: Floats) -> None:
    """Copy the numbers of some scans; what counts where no return is predicted only where that is needed."""
    for row in range(rows):
        for k in range(0 if intervals[row, 0] < np.inf else 3, 4 if intervals[row, 2] > 0.0 else 3):
            _pick(numbers[row, k], which, out[row, k])
