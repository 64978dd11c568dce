"""Weights after several looks together: the products of the weights of each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import LookWeights
from voa_core.filtering import Belief
from voa_core.kernels import Array
from voa_core.updating import UpdatePolicy


@dataclass(frozen=True, eq=False)
class JointWeights:
    """Weights of every pose after looks from several places, sample by sample.

    Attributes:
        parts: weights of the looks, in the order in which they are taken; of as many samples each.
    """

    parts: tuple[LookWeights, ...]

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the weights: float64 or float32."""
        return self.parts[0].dtype

    @property
    def matrix(self) -> None:
        """None, as `panels`."""
        return None

    @property
    def panels(self) -> None:
        """None: the products of weights are not kept."""
        return None

    def all_weights(self, _check: Callable[[], None]) -> None:
        """None: products are computed for some scans at a time."""

    @property
    def samples(self) -> int:
        """Number of samples of each pose."""
        return self.parts[0].samples

    @property
    def simulated(self) -> bool:
        """True if the scans are drawn from the sensor model."""
        return self.parts[0].simulated

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Products of the weights W[rows, columns] of all looks, each row scaled by a positive number of its own."""
        product = self.parts[0].weights(rows, columns)
        for part in self.parts[1:]:
            product = product * part.weights(rows, columns)
        return product

    def most_left_out(self, rows: NDArray[np.intp], columns: NDArray[np.intp], masses: Floats) -> Floats | None:
        """Largest total, (k,), of what is left out of the products of the samples `rows`, each pose by its mass.

        What a look leaves out of the weight of a pose counts as often as the other looks weigh that pose. With E the
        most that the product P of some looks lacks, and e the most that the weight w of one more look lacks, the
        product of all lacks at most E (w + e) + P e. A bound by the largest weights alone, which are 1, would not do:
        the product is far smaller, and nearly every sample would have to be computed again in full.

        None: nothing is left out.
        """
        nothing = np.zeros(len(rows))
        bounds = (part.most_left_out(rows, columns, masses) for part in self.parts)
        left_out = [nothing if bound is None else bound for bound in bounds]
        if not any(each.any() for each in left_out):
            return None
        product, lacking = np.ones((len(rows), len(columns))), np.zeros((len(rows), len(columns)))
        for part, each in zip(self.parts, left_out, strict=True):
            weights, most = part.weights(rows, columns), each[:, None]
            lacking = lacking * (weights + most) + product * most
            product *= weights
        total: Floats = lacking @ masses
        return total

    def seen_with(self, belief: Belief, policy: UpdatePolicy) -> "JointWeights":
        """Weights with which scans that do not show the object change nothing, under the belief before all looks."""
        return JointWeights(tuple(part.seen_with(belief, policy) for part in self.parts))

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after all looks of each of the samples `rows`, look by look and in logarithms."""
        after = list(before)
        for part in self.parts:
            after = part.beliefs(rows, after, policy)
        return after
