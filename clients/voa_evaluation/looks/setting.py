"""Setting of an evaluation of looks: numbers of drops, update rules, policies, imperfections. Fixed before the run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

from voa_core.rules.registry import RULES
from voa_fleet.episodes.policies import POLICIES
from voa_fleet.world.imperfections import Imperfections
from voa_msgs.updates import UpdateRule
from voa_recordings.replay.experiments import paper_update

Belief = Literal["uniform", "hinted"]
"""Kind of belief before the look: `uniform` as in the paper, or `hinted`: a different one for each drop."""

BELIEFS: tuple[Belief, ...] = ("uniform", "hinted")
EVALUATED_RULES = tuple(RULES)
"""Names of the update rules under which looks are evaluated: all that are built in."""
RULE_DESCRIPTIONS: Mapping[str, str] = MappingProxyType({name: rule.meaning for name, rule in RULES.items()})


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

    drops: int = 60
    attempts: int = 15
    sensitivity_drops: int = 20
    seed: int = 0
    imperfections: Imperfections = field(default_factory=default_imperfections)
    threads: int = 3
    processes: int = 1
    policies: tuple[str, ...] = tuple(POLICIES)


def evaluated_update(rule: str, own: UpdateRule) -> UpdateRule:
    """Return the update rule of that name for a scenario whose update is `own`.

    It has the scenario's no-return value, and otherwise the rule's defaults. `margin` shares the belief among the
    nearest poses where none is within the margin, as in the experiments of the paper.
    """
    return own if rule == own.rule else paper_update(rule, own.no_return_m)
