"""Update rules and their parameters; a parameter that is null gets its default when the scenario is stored."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import Field

from voa_msgs.base import LEAST, Free, Message, Name, NotNegative, Positive

OnNoMatch = Literal["reject", "nearest"]


class _Update(Message):
    no_return_m: Positive | None = None
    """Range, in metres, that stands for a no-return, and upper limit of every return; null: the lidar's `range_max`."""
    on_no_match: OnNoMatch = "reject"
    """A scan that no pose explains is not accepted (`reject`), or the nearest poses share the belief (`nearest`)."""
    on_nothing_seen: Literal["reject", "evidence"] = "reject"
    """A scan in which too few beams see any object is not accepted (`reject`), or is evidence like any other."""
    reject_above_rmsd_mm: Positive | None = None
    """Largest RMSD of the best fit, in mm, with which a scan is accepted; null: any."""
    score_floor: Annotated[float, Field(ge=0.0, le=0.5)] = 0.0
    """Distance from 0 and from 1 that a grasp score keeps, at least, when the outcome of a grasp is weighed."""


class MarginUpdate(_Update):
    """Weight 1 if every beam agrees within `margin_m`, else 0."""

    rule: Literal["margin"]
    margin_m: Positive | None = None
    """Largest difference of two ranges that agree, metres; null: 0.008."""


class ExponentialUpdate(_Update):
    """Weight exp(-d), where d is the Euclidean norm of the differences of ranges, in metres."""

    rule: Literal["exponential"]


class GaussianUpdate(_Update):
    """Weight exp(-d^2 / (2 sigma_m^2))."""

    rule: Literal["gaussian"]
    sigma_m: Positive | None = None
    """Standard deviation of d, metres; null: 1."""


class InverseRmsdUpdate(_Update):
    """Weight 1 / max(RMSD, floor_m)."""

    rule: Literal["inverse_rmsd"]
    floor_m: Positive | None = None
    """Smallest RMSD that counts, metres; null: 0.001."""


class BeamUpdate(_Update):
    """Mixture of hit, short, no-return and random for each beam, tempered; recommended for live robots.

    Each parameter that is null gets a default from the lidar.
    """

    rule: Literal["beam"] = "beam"
    z_hit: NotNegative | None = None
    """Share of beams that measure the object; the four shares are scaled to sum to 1."""
    z_short: NotNegative | None = None
    """Share of beams that something in front of the object stops."""
    z_no_return: NotNegative | None = None
    """Share of beams that come back empty although the object is there."""
    z_random: NotNegative | None = None
    """Share of beams that measure a random range."""
    sigma_hit_m: Positive | None = None
    """Standard deviation of a range on the object at close range, metres."""
    lambda_short_per_m: Positive | None = None
    """Decay of the density of obstacles with range, 1/m."""
    temper: Annotated[float, Ge(LEAST), Le(1.0)] | None = None
    """Exponent of the likelihood of a scan: neighbouring beams err together and are no independent witnesses."""


class PluginUpdate(_Update):
    """Weights of an update rule that a Python package beside the service provides.

    The service finds such rules in the entry points of the group `voa.rules`. A scenario whose rule is not installed
    is refused with a list of those that are.
    """

    rule: Literal["plugin"]
    name: Name
    """Name of the rule, which is the name of its entry point."""
    parameters: dict[Name, Free] = Field(default={})
    """Parameters of the rule, which checks them itself."""


BuiltInUpdate = MarginUpdate | ExponentialUpdate | GaussianUpdate | InverseRmsdUpdate | BeamUpdate
UpdateRule = Annotated[BuiltInUpdate | PluginUpdate, Field(discriminator="rule")]
BUILT_IN: Mapping[str, type[BuiltInUpdate]] = MappingProxyType(
    {
        "margin": MarginUpdate,
        "exponential": ExponentialUpdate,
        "gaussian": GaussianUpdate,
        "inverse_rmsd": InverseRmsdUpdate,
        "beam": BeamUpdate,
    }
)
"""Messages of the built-in rules by name, in the order of `voa_core.rules.registry.RULES`."""
POLICY_FIELDS = frozenset({"rule", "on_no_match", "on_nothing_seen", "reject_above_rmsd_mm", "score_floor"})
"""Fields of an update that are no parameters of its rule."""


def update_of(name: str, no_return_m: float | None = None, on_no_match: OnNoMatch = "reject") -> UpdateRule:
    """Make the update of a rule with its default parameters: a built-in rule, or else an installed one of that name.

    Args:
        name: of the rule.
        no_return_m: range that stands for a no-return, metres; None: the lidar's `range_max`.
        on_no_match: effect of a scan that no pose explains.
    """
    if name not in BUILT_IN:
        return PluginUpdate(rule="plugin", name=name, no_return_m=no_return_m, on_no_match=on_no_match)
    fields = {"rule": name, "no_return_m": no_return_m, "on_no_match": on_no_match}
    return BUILT_IN[name].model_validate(fields)
