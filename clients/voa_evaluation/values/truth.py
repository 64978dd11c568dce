"""True values of looks: what the grasp that is chosen after each of many fresh scans achieves at the true pose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_evaluation.values.bench import Bench


@dataclass(frozen=True, eq=False)
class Truth:
    """Achieved values of the looks from k places under a belief, over S scans of each of n poses.

    Attributes:
        shares: (n,) probability of each pose.
        gains: (k, n, S) success with the look less success without it, less the cost of the look.
        without: success without a look.
    """

    shares: Floats
    gains: Floats
    without: float

    @property
    def net(self) -> Floats:
        """Achieved net value of each look, (k,)."""
        net: Floats = self.gains.mean(axis=2) @ self.shares
        return net

    def covariance(self) -> Floats:
        """Covariance of the achieved values, (k, k): a sample has the same displaced object at all places."""
        k, _, samples = self.gains.shape
        apart = (self.gains - self.gains.mean(axis=2, keepdims=True)) * self.shares[:, None]
        flat = apart.reshape(k, -1)
        covariance: Floats = flat @ flat.T / (samples * (samples - 1))
        return covariance

    def half(self, second: bool) -> "Truth":
        """Truth over every other scan: the even or the odd ones."""
        return Truth(self.shares, self.gains[:, :, int(second) :: 2], self.without)

    def resampled(self, rng: np.random.Generator, number: int) -> Floats:
        """Net values over scans that are drawn again with replacement, (number, k); places keep their samples."""
        k, n, samples = self.gains.shape
        drawn = rng.multinomial(samples, np.full(samples, 1.0 / samples), (number, n)) / samples
        means = np.einsum("kns,rns->rkn", self.gains, drawn, optimize=True)
        net: Floats = means @ self.shares
        return net.reshape(number, k)


def truth_of(bench: Bench, belief: Belief) -> Truth:
    """Value a look from every place of a bench by the world's scans."""
    valuation = bench.valuation(belief)
    poses = len(belief.p)
    gains = []
    for sensor in bench.sensors:
        assistance = valuation.value(bench.taken.together(sensor))
        full = np.zeros((poses, assistance.gains.shape[1]))
        full[assistance.outcomes] = assistance.gains - sensor.cost
        gains.append(full)
    grasp = best_grasp(bench.scenario.table, belief.p)
    without = 0.0 if grasp.index is None else float(bench.scenario.table.scores[grasp.index] @ belief.p)
    return Truth(belief.p, np.stack(gains), without)


def argmax(values: Floats) -> int:
    """Index of the largest value, the first of those that are equal to 1e-12."""
    return int(np.argmax(np.round(values, 12)))


def oracle_choices(truth: Truth) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Best and worst place by each half of the scans, (2,) and (2,); a best of -1 is no look, where each would harm."""
    best, worst = [], []
    for second in (False, True):
        net = truth.half(second).net
        index = argmax(net)
        best.append(index if net[index] > 0.0 else -1)
        worst.append(argmax(-net))
    return np.array(best, dtype=np.intp), np.array(worst, dtype=np.intp)


def crossed(truth: Truth, choices: NDArray[np.intp]) -> Floats:
    """Gains (n, S) of a place chosen by one half of the scans, over the other half, for both halves; -1 gains 0.

    So the luck of the scans by which a place is chosen does not count for it.
    """
    gains = np.zeros(truth.gains.shape[1:])
    for second, choice in enumerate(choices):
        if choice >= 0:
            gains[:, 1 - second :: 2] = truth.gains[choice][:, 1 - second :: 2]
    return gains
