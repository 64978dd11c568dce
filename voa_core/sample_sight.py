"""Beams of many simulated scans that could see the object, and the scans in which it is missing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copies import Copies, SimulatedScans

_FEWEST_RETURNS = 3
_SLACK_M = 1e-9


@dataclass(frozen=True, eq=False)
class SampleSight:
    """Beams of simulated scans that could see the object at each pose, as `sight.Sight` has them for one scan.

    Attributes:
        reach: (n, c) largest range, metres, of a return that sees the object at a copy of each pose; -inf where no
            copy returns; inf elsewhere with a workspace.
        fewest: (g, n) the fewest returns of a copy of each pose, for each set of missing beams.
    """

    reach: Floats
    fewest: NDArray[np.intp]

    def misses_object(self, scans: SimulatedScans, possible: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Flags (N,) of the scans in which too few beams see the object for it to lie at the possible poses, (n,)."""
        fewest = self.fewest[:, possible].min(axis=1, initial=np.iinfo(np.intp).max)[scans.group]
        reach = self.reach[possible].max(axis=0, initial=-np.inf)
        with np.errstate(invalid="ignore"):
            seen = ((scans.ranges <= reach + _SLACK_M) & np.isfinite(scans.ranges)).sum(axis=1)
        missed: NDArray[np.bool_] = (fewest >= _FEWEST_RETURNS) & (3 * seen < fewest)
        return missed


def sight_of_samples(scans: SimulatedScans, copies: Copies, behind_m: float) -> SampleSight:
    """Find the beams of simulated scans that could see a pose in any of its displaced copies.

    A return at most `behind_m` behind the farthest prediction of its beam sees the object; with a workspace it is inf.
    """
    reach, fewest = [], []
    for poses, predicted in copies.blocks():
        column_of = np.full(predicted.grid.beams, -1)
        column_of[scans.columns] = np.arange(len(scans.columns))
        part = np.full((poses.stop - poses.start, len(scans.columns)), -np.inf)
        columns = column_of[predicted.beams]
        of_row = np.repeat(np.arange(len(part)), np.diff(predicted.start))
        seen = (columns >= 0) & (predicted.farthest > -np.inf)
        part[of_row[seen], columns[seen]] = predicted.farthest[seen] + behind_m
        reach.append(part)
        counts = []
        for missing in scans.missing:
            lost = np.zeros(predicted.grid.beams, dtype=bool)
            lost[scans.columns[missing]] = True
            counts.append(predicted.fewest_returns(lost))
        fewest.append(np.stack(counts))
    return SampleSight(np.concatenate(reach), np.concatenate(fewest, axis=1))
