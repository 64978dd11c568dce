"""What is evaluated: how many drops, which rules, what goes wrong. Fixed before the run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

from voa_fleet.world.imperfections import Imperfections
from voa_msgs.updates import (
    UpdateRule,
)
from voa_recordings.replay.experiments import update_of as usual_update

Belief = Literal["uniform", "hinted"]
"""What is believed before the look: nothing (`uniform`, as in the paper), or something that differs between drops."""

BELIEFS: tuple[Belief, ...] = ("uniform", "hinted")
RULES = ("margin", "exponential", "gaussian", "inverse_rmsd", "beam")
MEANT: Mapping[str, str] = MappingProxyType(
    {
        "margin": "a pose stays possible if every beam agrees within 8 mm; if none does, the nearest poses share",
        "exponential": "weight exp(-d), d the length of the vector of differences in metres",
        "gaussian": "weight exp(-d²/2), d as above",
        "inverse_rmsd": "weight 1 / RMSD, the root of the mean squared difference",
        "beam": "this project's rule for live robots: every beam is a hit, too short, empty or random",
    }
)


def usual_imperfections() -> Imperfections:
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
        imperfections: what goes wrong.
        threads: requests at a time.
        processes: for the grasp scores.
    """

    drops: int = 100
    attempts: int = 15
    sensitivity_drops: int = 30
    seed: int = 0
    imperfections: Imperfections = field(default_factory=usual_imperfections)
    threads: int = 3
    processes: int = 1


def update_of(rule: str, own: UpdateRule) -> UpdateRule:
    """The rule for a scenario whose update is `own`: the same no-return value, else the rule's defaults.

    `margin` shares the belief among the nearest poses where none is within the margin, as the paper's lab did.
    """
    return own if rule == own.rule else usual_update(rule, own.no_return_m)
