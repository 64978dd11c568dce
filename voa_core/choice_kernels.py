"""Loops over the scans of a look, compiled: which grasp is best after each, and how good it is."""

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import frugal_kernel, kernel
from voa_core.kernels import Array
from voa_core.register_products import PANEL_BYTES, ROWS, add_products

_POSES = 64  # whose weights are multiplied at a time: 16 KiB, which stay in a first-level cache for all grasps
_TILE = 16


@kernel
def choose_after_panels(
    panels: Array,
    factor: Array,
    grasps: int,
    tie: np.floating,
    version: int,
    chosen: NDArray[np.intp],
    scores: Floats,
    norms: Array,
    low: NDArray[np.bool_],
    close: NDArray[np.bool_],
) -> None:
    """Choose the best grasp after each of the scans in some panels.

    Each sum over the poses is the product of a column of a panel and a column of the factor.

    Args:
        panels: (t, c, w) weights of the poses after t w scans, see `panels.Panels`.
        factor: (g, c, ROWS) weighted scores of the grasps, in blocks; the normaliser comes after the last grasp.
        grasps: number of grasps m, below g ROWS.
        tie: scores within this share of the normaliser are as good as the best; of the type of `panels`.
        version: of the registers at hand, see `register_products.version_at_hand`.
        chosen: (t w,) written: the first listed that is as good as the best; -1 where the best is 0.
        scores: (t w,) written: expected score of the best, 0 where nothing is left of the normaliser.
        norms: (t w,) written: the normaliser.
        low: (t w,) written: True where the best is no better than a score of 0.
        close: (t w,) written: True where another grasp is as good as the best.
    """
    width = panels.shape[2]
    product = np.zeros((len(factor) * ROWS, width), dtype=panels.dtype)
    for panel in range(len(panels)):
        some = slice(panel * width, (panel + 1) * width)
        _multiply(factor, panels[panel], version, product)
        norms[some] = product[grasps]
        choose_each(product[: grasps + 1], tie, chosen[some], scores[some], low[some], close[some])


@kernel
def choose_after_rows(
    rows: Array,
    factor: Array,
    grasps: int,
    tie: np.floating,
    version: int,
    chosen: NDArray[np.intp],
    scores: Floats,
    norms: Array,
    low: NDArray[np.bool_],
    close: NDArray[np.bool_],
) -> None:
    """Choose the best grasp after each of k scans, whose weights lie scan by scan in memory.

    Args:
        rows: (k, c) weights of the poses after each scan.
        factor, grasps, tie, version: see `choose_after_panels`.
        chosen, scores, norms, low, close: written, see `choose_after_panels`; t w is at least k.
    """
    width = PANEL_BYTES // rows.itemsize
    product = np.zeros((len(factor) * ROWS, width), dtype=rows.dtype)
    panel = np.zeros((rows.shape[1], width), dtype=rows.dtype)
    for first in range(0, len(rows), width):
        some = slice(first, first + width)
        _turn(rows[some], panel)
        _multiply(factor, panel, version, product)
        norms[some] = product[grasps]
        choose_each(product[: grasps + 1], tie, chosen[some], scores[some], low[some], close[some])


@frugal_kernel
def _turn(rows: Array, panel: Array) -> None:
    """Write the weights (h, c) of some scans to a panel (c, w), in tiles that stay in a first-level cache."""
    poses = len(panel)
    for left in range(0, poses, _TILE):
        for i in range(len(rows)):
            row = rows[i]
            for pose in range(left, min(left + _TILE, poses)):
                panel[pose, i] = row[pose]


@kernel
def _multiply(factor: Array, panel: Array, version: int, product: Array) -> None:
    """Write the sums over the poses of a factor (g, c, ROWS) times a panel (c, w) to `product` (g ROWS, w)."""
    turns = len(factor)
    product[:] = 0.0
    for first in range(0, len(panel), _POSES):
        weights = panel[first : first + _POSES]
        for turn in range(turns):
            sums = product[turn * ROWS : (turn + 1) * ROWS]
            add_products(factor[turn, first : first + _POSES], weights, sums, turn, turns, version)


@kernel
def choose_each(
    product: Array,
    tie: np.floating,
    chosen: NDArray[np.intp],
    scores: Floats,
    low: NDArray[np.bool_],
    close: NDArray[np.bool_],
) -> None:
    """Choose the best grasp of each of k beliefs, in loops that run in vector registers.

    Args:
        product: (m + 1, k) unnormalised expected scores, the normaliser last.
        tie: see `choose_after_panels`.
        chosen, scores, low, close: (k,) written, see `choose_after_panels`.
    """
    m, k = len(product) - 1, len(chosen)
    best, second = product[0].copy(), np.full(k, -1.0, product.dtype)
    first = np.zeros(k, np.int32)  # as wide as float32, so that one register holds as many
    for x in range(1, m):
        row, index = product[x], np.int32(x)
        for j in range(k):
            score, before = row[j], best[j]
            less = score if score < before else before
            second[j] = less if less > second[j] else second[j]
            first[j] = index if score > before else first[j]
            best[j] = score if score > before else before
    for j in range(k):
        norm = product[m, j]
        margin = tie * norm
        enough = best[j] - margin
        low[j] = best[j] <= margin
        close[j] = second[j] >= enough
        scores[j] = np.float64(best[j]) / np.float64(norm) if norm > 0.0 else 0.0
        chosen[j] = first[j]
        if best[j] <= 0.0:
            chosen[j] = -1
        elif close[j]:
            x = 0
            while product[x, j] < enough:
                x += 1
            chosen[j] = x
