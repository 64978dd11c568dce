"""Comparison of scans with displaced copies of poses for the rule `beam`."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.mixture import FAR_M, Mixture, measured_scans, mixture_of_pairs
from voa_core.mixture_kernels import mixture_of_copies
from voa_core.scans import NO_RETURN

_CLUSTER = 8
_POSES_AT_ONCE = 64


class MixtureComparison:
    """Comparison of N scans with the displaced copies of k poses by the mixture of the rule `beam`.

    Copies that surely have less than a given weight are left out, see `mixture_kernels.mixture_of_copies`.
    """

    leaves_out = True

    def __init__(self, mixture: Mixture, observed: Floats, copies: DisplacedScans) -> None:
        """Prepare the comparison of classified scans (N, r) with displaced copies of poses."""
        # On every other beam all scans and all copies are no-returns, which weighs all poses alike.
        kept = (observed != NO_RETURN).any(axis=0)
        kept[copies.beams] = True
        self._constant = mixture.temper * np.count_nonzero(~kept) * np.log(mixture.nothing)
        self._mixture, self._copies = (
            mixture,
            replace(copies, beams=(np.cumsum(kept) - 1)[copies.beams].astype(np.int32)),
        )
        self._measured = measured_scans(np.ascontiguousarray(observed[:, kept]), mixture)

    def log_weights(self, scans: NDArray[np.intp], poses: NDArray[np.intp]) -> Floats:
        """Logarithms ln w of the weights of every copy, (P, J), for P pairs of a scan and a pose."""
        logs = np.zeros((len(scans), self._copies.copies))
        copies = self._copies
        mixture_of_pairs(self._measured, scans, poses, copies.start, copies.beams, copies.ranges, self._mixture, logs)
        logs *= self._mixture.temper
        logs += self._constant
        return logs

    def log_means(self, own: NDArray[np.intp], least: Floats, check: Callable[[], None]) -> Floats:
        """Logarithms of the mean weight over the copies of each pose after each scan, (k, N); -inf where left out."""
        copies, order = self._copies, self._neighbours_together()
        measured = self._measured.by_beam(order)
        own, least = own[order], least[order] - self._constant
        means = np.zeros((len(copies), len(own)))
        for first in range(0, len(means), _POSES_AT_ONCE):
            check()
            mixture_of_copies(
                measured,
                own,
                least,
                first,
                copies.start[first : first + _POSES_AT_ONCE + 1],
                copies.beams,
                copies.ranges,
                copies.order,
                min(_CLUSTER, copies.copies),
                self._mixture,
                means[first : first + _POSES_AT_ONCE],
            )
        means = np.take(means, np.argsort(order), axis=1)  # back to the order of the scans
        means += self._constant - np.log(copies.copies)
        return means

    def _neighbours_together(self) -> NDArray[np.intp]:
        """Order (N,) of the scans by the beam in the middle of their returns, so that neighbours return alike."""
        returned = self._measured.ranges < FAR_M
        middle = returned @ np.arange(returned.shape[1]) / np.maximum(returned.sum(axis=1), 1)
        return np.argsort(middle, kind="stable")
