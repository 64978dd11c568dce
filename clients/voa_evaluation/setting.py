"""What is evaluated: how many drops, which rules, what goes wrong. Fixed before the run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

from voa_core.rules.registry import RULES as BUILT_IN_RULES
from voa_fleet.world.imperfections import Imperfections
from voa_msgs.updates import UpdateRule
from voa_recordings.replay.experiments import update_of as usual_update

Belief = Literal["uniform", "hinted"]
"""What is believed before the look: nothing (`uniform`, as in the paper), or something that differs between drops."""

BELIEFS: tuple[Belief, ...] = ("uniform", "hinted")
RULES = tuple(BUILT_IN_RULES)
MEANT: Mapping[str, str] = MappingProxyType({name: rule.meaning for name, rule in BUILT_IN_RULES.items()})


def usual_flaws() -> Imperfections:
    """An LDS-01 in a room, and an object that lies 5 mm and 3 degrees (std) from its pose."""
    return replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=math.radians(3.0))


@dataclass(frozen=True)
class Setting:
    """One evaluation.

    Attributes:
        drops: per object and kind of belief.
        attempts: per cell of the grasp scores.
        sensitivity_drops: per object, for the curves; the first of the uniform ones.
        seed: of everything.
        flaws: what goes wrong.
        threads: requests at a time.
        processes: for the grasp scores.
    """

    drops: int = 100
    attempts: int = 15
    sensitivity_drops: int = 30
    seed: int = 0
    flaws: Imperfections = field(default_factory=usual_flaws)
    threads: int = 3
    processes: int = 1


def update_of(rule: str, own: UpdateRule) -> UpdateRule:
    """The rule for a scenario whose update is `own`: the same no-return value, else the rule's defaults.

    `margin` shares the belief among the nearest poses where none is within the margin, as the paper's lab did.
    """
    return own if rule == own.rule else usual_update(rule, own.no_return_m)
