"""Cases of an evaluation: beliefs before the look, and where the robot starts."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from voa_core.filtering import Belief
from voa_evaluation.values.scans import random_source

UNIFORM: Literal["uniform"] = "uniform"
HINTED: Literal["hinted"] = "hinted"
HINT = 0.5
"""Concentration of the Dirichlet distribution of hinted beliefs: below 1, so that a few poses have most of it."""
START_M = 1.0
"""Distance from the middle of the table at which the sensor robot starts."""


@dataclass(frozen=True, eq=False)
class Case:
    """A belief before the look; the true pose follows it.

    Attributes:
        kind: `uniform` or `hinted`.
        index: number among the cases of its object and kind.
        belief: over the poses.
        start: x, y of the sensor robot, metres.
    """

    kind: str
    index: int
    belief: Belief
    start: tuple[float, float]


def cases_of(name: str, poses: int, hinted: int, seed: int) -> list[Case]:
    """Make the uniform case and the hinted cases of an object, of so many poses."""
    return [
        _case(name, poses, kind, index, seed)
        for kind, count in ((UNIFORM, 1), (HINTED, hinted))
        for index in range(count)
    ]


def _case(name: str, poses: int, kind: str, index: int, seed: int) -> Case:
    rng = random_source(seed, "case", name, kind, index)
    belief = Belief.uniform(poses) if kind == UNIFORM else Belief.of(rng.dirichlet(np.full(poses, HINT)))
    bearing = float(rng.uniform(0.0, 2.0 * math.pi))
    return Case(kind, index, belief, (START_M * math.cos(bearing), START_M * math.sin(bearing)))
