"""Weights in panels: the way they lie in memory in which they are multiplied the fastest.

A panel holds the weights of all poses after some scans, pose after pose; of one pose they take 256 bytes, so that is 64
scans in float32 and 32 in float64. Panel after panel is gone through from its begin to its end, which a processor reads
ahead; and a part of a panel stays in its first-level cache while it is multiplied by the scores of all grasps.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.jit import frugal_kernel
from voa_core.kernels import Array
from voa_core.register_products import PANEL_BYTES

_TILE = 16


def size_in_panels(scans: int, poses: int, dtype: np.dtype[Any]) -> int:
    """Memory, in bytes, that weights of so many poses after so many scans take in panels."""
    return _panels_of(scans, dtype) * poses * PANEL_BYTES


def _panels_of(scans: int, dtype: np.dtype[Any]) -> int:
    """Number of panels that so many scans fill."""
    return -(-scans * dtype.itemsize // PANEL_BYTES)


@dataclass(frozen=True, eq=False)
class Panels:
    """Weights of c poses after each of k scans.

    Attributes:
        numbers: (t, c, w) of scans 0 to w - 1, then of the next w, and so on; 0 beyond the last scan.
        scans: number k of scans.
    """

    numbers: Array
    scans: int

    @classmethod
    def empty(cls, scans: int, poses: int, dtype: np.dtype[Any]) -> "Panels":
        """Make panels of weights of 0, to be written."""
        shape = _panels_of(scans, dtype), poses, PANEL_BYTES // dtype.itemsize
        return cls(np.zeros(shape, dtype=dtype), scans)

    @classmethod
    def of(cls, weights: Array) -> "Panels":
        """Copy weights (k, c) into panels."""
        scans, poses = weights.shape
        panels = cls.empty(scans, poses, weights.dtype)
        panels.write(0, weights)
        return panels

    @classmethod
    def of_pairs(cls, pairs: Array, poses: int) -> "Panels":
        """Make panels of weights of n poses after a scan of each, alike in both orders, from those of each pair once.

        Args:
            pairs: (n (n + 1) / 2,) upper triangle of the matrix, row after row.
            poses: number n.
        """
        panels = cls.empty(poses, poses, pairs.dtype)
        mirror_in_panels(pairs, panels.numbers)
        return panels

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.numbers.nbytes

    def write(self, first: int, weights: Array) -> None:
        """Write the weights (h, c) after h scans in a row, of which the first has the index `first`."""
        width, begin = self.numbers.shape[2], 0
        while begin < len(weights):
            panel, at = divmod(first + begin, width)
            some = weights[begin : begin + width - at]
            self.numbers[panel, :, at : at + len(some)] = some.T
            begin += len(some)

    def read(self, scans: NDArray[np.intp], poses: NDArray[np.intp]) -> Array:
        """Copy the weights of some poses after some scans, (h, d)."""
        rows = np.zeros((len(scans), len(poses)), dtype=self.numbers.dtype)
        read_panels(self.numbers, scans, poses, rows)
        return rows


@frugal_kernel
def mirror_in_panels(triangle: Array, panels: Array) -> None:
    """Write the symmetric matrix with the upper `triangle` (n (n + 1) / 2,), row after row, into its panels (t, n, w).

    The other half is copied in tiles: whole columns would miss the cache at every number.
    """
    n, width, begin = panels.shape[1], panels.shape[2], 0
    for pose in range(n):
        row = triangle[begin : begin + n - pose]
        begin += n - pose
        for panel in range(pose // width, len(panels)):
            first = max(pose, panel * width)
            own = panels[panel, pose, first - panel * width :]
            some = row[first - pose :]
            for i in range(min(len(own), len(some))):
                own[i] = some[i]
    for left in range(0, n, _TILE):
        for top in range(left, n, _TILE):
            own = panels[left // width, top : top + _TILE, left % width : left % width + _TILE]
            other = panels[top // width, left : left + _TILE, top % width : top % width + _TILE]
            for pose in range(len(own)):
                for scan in range(min(len(other), top + pose - left)):
                    own[pose, scan] = other[scan, pose]


@frugal_kernel
def read_panels(panels: Array, scans: NDArray[np.intp], poses: NDArray[np.intp], rows: Array) -> None:
    """Write the weights of some poses after some scans, from panels (t, c, w), to `rows` (h, d).

    In tiles: whole rows would miss the cache at every number.
    """
    width = panels.shape[2]
    for left in range(0, len(poses), _TILE):
        for i in range(len(scans)):
            panel, at, row = panels[scans[i] // width], scans[i] % width, rows[i]
            for j in range(left, min(left + _TILE, len(poses))):
                row[j] = panel[poses[j], at]
