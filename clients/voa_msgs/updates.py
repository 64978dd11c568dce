"""Update rules and their parameters. What is null is filled in when the scenario is stored."""

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import Field

from voa_msgs.base import LEAST, Message, NotNegative, Positive


class _Update(Message):
    no_return_m: Positive | None = None
    """What a beam without a return counts as, and the most that a return counts as, metres; null: `range_max`."""
    on_no_match: Literal["reject", "nearest"] = "reject"
    """A scan that no pose explains: not accepted, or the belief is shared among the nearest poses."""
    on_nothing_seen: Literal["reject", "evidence"] = "reject"
    """A scan in which too few beams see any object: not accepted, or taken as evidence like any other."""
    reject_above_rmsd_mm: Positive | None = None
    """A scan whose best fit is worse is not accepted (wrong object, empty table); null: any is."""
    score_floor: Annotated[float, Field(ge=0.0, le=0.5)] = 0.0
    """Grasp outcomes count a score as at least this and at most 1 less this."""


class MarginUpdate(_Update):
    """Weight 1 if every beam agrees within `margin_m`, else 0."""

    rule: Literal["margin"]
    margin_m: Positive | None = None


class ExponentialUpdate(_Update):
    """Weight exp(-d), d the Euclidean norm of the differences."""

    rule: Literal["exponential"]


class GaussianUpdate(_Update):
    """Weight exp(-d^2 / (2 sigma_m^2))."""

    rule: Literal["gaussian"]
    sigma_m: Positive | None = None


class InverseRmsdUpdate(_Update):
    """Weight 1 / max(RMSD, floor_m)."""

    rule: Literal["inverse_rmsd"]
    floor_m: Positive | None = None


class BeamUpdate(_Update):
    """Per-beam mixture of hit, short, no-return and random, tempered; recommended for live robots."""

    rule: Literal["beam"] = "beam"
    z_hit: NotNegative | None = None
    z_short: NotNegative | None = None
    z_no_return: NotNegative | None = None
    z_random: NotNegative | None = None
    sigma_hit_m: Positive | None = None
    lambda_short_per_m: Positive | None = None
    temper: Annotated[float, Ge(LEAST), Le(1.0)] | None = None


UpdateRule = Annotated[
    MarginUpdate | ExponentialUpdate | GaussianUpdate | InverseRmsdUpdate | BeamUpdate, Field(discriminator="rule")
]
POLICY_FIELDS = frozenset({"rule", "on_no_match", "on_nothing_seen", "reject_above_rmsd_mm", "score_floor"})
"""Fields of an update that are no parameters of its rule."""
