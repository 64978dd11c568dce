"""Loops over pairs of scans, compiled: one statistic per (observed, predicted) pair, a sum over beams.

`observed` is (m, c), `predicted` (n, c), `out` (m, n), all of one float type.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.jit import kernel, sum_kernel

Array = NDArray[Any]
"""Float arrays of either size: float64 for updates, float32 for large rankings."""

_MARGIN_SLACK_M = 1e-9
_TILE = 16


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
    """Sum the squared differences of each pair of `scans` (n, c), to `out` (n (n + 1) / 2,), see `mirror`."""
    n, c = scans.shape
    columns = np.zeros(((c + 3) // 4 * 4, n), dtype=scans.dtype)  # in fours: rows of `out` are gone over less often
    columns[:c] = scans.T
    begin = 0
    for i in range(n):
        row = out[begin : begin + n - i]
        begin += n - i
        row[:] = 0.0
        for k in range(0, len(columns), 4):
            z0, z1, z2, z3 = columns[k, i], columns[k + 1, i], columns[k + 2, i], columns[k + 3, i]
            c0, c1, c2, c3 = columns[k, i:], columns[k + 1, i:], columns[k + 2, i:], columns[k + 3, i:]
            for j in range(len(row)):
                d0, d1, d2, d3 = z0 - c0[j], z1 - c1[j], z2 - c2[j], z3 - c3[j]
                row[j] += d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3


@kernel
def mirror(triangle: Array, square: Array) -> None:
    """Write the symmetric matrix `square` (n, n) whose upper triangle, row after row, is `triangle` (n (n + 1) / 2,).

    The lower triangle is written in tiles: whole columns would miss the cache at every entry.
    """
    n, begin = len(square), 0
    for i in range(n):
        square[i, i:] = triangle[begin : begin + n - i]
        begin += n - i
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
