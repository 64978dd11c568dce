"""Setting of an evaluation of looks: numbers of drops, update rules, policies, imperfections. Fixed before the run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

from voa_fleet.episodes.policies import POLICIES
from voa_fleet.world.imperfections import Imperfections
from voa_msgs.updates import (
    UpdateRule,
)
from voa_recordings.replay.experiments import update_of as default_update

Belief = Literal["uniform", "hinted"]
"""Kind of belief before the look: `uniform` as in the paper, or `hinted`: a different one for each drop."""

BELIEFS: tuple[Belief, ...] = ("uniform", "hinted")
RULES = ("margin", "exponential", "gaussian", "inverse_rmsd", "beam")
RULE_DESCRIPTIONS: Mapping[str, str] = MappingProxyType(
    {
        "margin": "a pose stays possible if every beam agrees within 8 mm; if none does, the nearest poses share",
        "exponential": "weight exp(-d), d the length of the vector of differences in metres",
        "gaussian": "weight exp(-d²/2), d as for exponential",
        "inverse_rmsd": "weight 1 / RMSD, the root of the mean squared difference",
        "beam": "this project's rule for live robots: every beam is a hit, too short, empty or random",
    }
)


def default_imperfections() -> Imperfections:
    """Return the errors of an LDS-01 in a room, and an object 5 mm and 3 degrees (standard deviations) off its pose."""
    return replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=math.radians(3.0))


@dataclass(frozen=True)
class Setting:
    """Extent of an evaluation of looks.

    Attributes:
        drops: per object and kind of belief.
        attempts: per cell of the grasp scores.
        sensitivity_drops: per object, for the curves of sensitivity; the first of those with a uniform belief.
        seed: of all random numbers.
        imperfections: of the simulated world.
        threads: number of requests at a time.
        processes: for the grasp scores.
        policies: names of the policies that are compared.
    """

    drops: int = 100
    attempts: int = 15
    sensitivity_drops: int = 30
    seed: int = 0
    imperfections: Imperfections = field(default_factory=default_imperfections)
    threads: int = 3
    processes: int = 1
    policies: tuple[str, ...] = tuple(POLICIES)


def update_of(rule: str, own: UpdateRule) -> UpdateRule:
    """Return the update rule of that name for a scenario whose update is `own`.

    It has the scenario's no-return value, and otherwise the rule's defaults. `margin` shares the belief among the
    nearest poses where none is within the margin, as in the experiments of the paper.
    """
    return own if rule == own.rule else default_update(rule, own.no_return_m)
