"""Weights of simulated scans that serve many beliefs: what does not depend on the belief is kept."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import belief_after
from voa_core.copies import distances
from voa_core.filtering import Belief
from voa_core.simulated_weights import SimulatedWeights
from voa_core.updating import UpdatePolicy


@dataclass
class _Kept:
    logs: Floats | None = None
    away: dict[int, Floats] = field(default_factory=dict)
    nearest: dict[int, Belief] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class KeptWeights(SimulatedWeights):
    """Weights whose logarithms are computed once, where the ranking of each belief would compute them again.

    A scan that fits no pose leads to the same belief from any belief under the policy `nearest`: it is kept as well.
    """

    _kept: _Kept = field(default_factory=_Kept, init=False, repr=False)

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after each of the samples `rows` from that before it, in logarithms."""
        if len(self.scans) != 1 or len(rows) == 0:
            return super().beliefs(rows, before, policy)
        if self._kept.logs is None:
            self._kept.logs = self.log_rows(np.arange(len(self.scans[0].ranges)))
        logs = self._kept.logs
        dead = {int(row) for row in rows if logs[row].max() == -np.inf and policy.on_no_match == "nearest"}
        self._measure(sorted(dead - self._kept.nearest.keys()))
        after = []
        for row, belief in zip(rows, before, strict=True):
            index = int(row)
            if index in self._kept.nearest:
                after.append(self._kept.nearest[index])
                continue
            after.append(belief_after(belief, logs[index], policy, partial(self._away, index)))
            if index in dead:
                self._kept.nearest[index] = after[-1]
        return after

    def _measure(self, rows: list[int]) -> None:
        """Compute the distances of all poses to the scans `rows` at once."""
        if rows:
            part = self.scans[0].part(np.array(rows, dtype=np.intp))
            away = distances(part, self.copies, self.model.rule.no_return_m)
            self._kept.away.update(zip(rows, away, strict=True))

    def _away(self, row: int) -> Floats:
        if row not in self._kept.away:
            self._measure([row])
        return self._kept.away[row]
