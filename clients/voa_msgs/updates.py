"""Update rules and their parameters; a parameter that is null gets its default when the scenario is stored."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Literal, get_args

from annotated_types import Ge, Le
from pydantic import Field

from voa_msgs.base import LEAST, FreeObject, Message, Name, NotNegative, Positive

OnNoMatch = Literal["reject", "nearest"]


class _Update(Message):
    no_return_m: Positive | None = None
    """Range that a no-return counts as, and the most that a return counts as, metres; null: the lidar's `range_max`."""
    on_no_match: OnNoMatch = "reject"
    """Treatment of a scan that no pose explains: not accepted, or the nearest poses share the belief."""
    on_nothing_seen: Literal["reject", "evidence"] = "reject"
    """Treatment of a scan in which too few beams see the object: not accepted, or used as evidence like any other."""
    reject_above_rmsd_mm: Positive | None = None
    """Largest fit, mm, with which a scan is accepted, to reject a wrong object or an empty table; null: no limit."""
    score_floor: Annotated[float, Field(ge=0.0, le=0.5)] = 0.0
    """Floor of the grasp scores when an outcome updates the belief: they count as at least f and at most 1 - f."""


class MarginUpdate(_Update):
    """Update rule `margin`: weight 1 if every beam agrees with the prediction within a margin, else 0."""

    rule: Literal["margin"]
    """Always `margin`."""
    margin_m: Positive | None = None
    """Largest difference of a beam, metres; null: 0.008."""


class ExponentialUpdate(_Update):
    """Update rule `exponential`: weight exp(-d), with d the Euclidean norm of the differences of all beams, metres."""

    rule: Literal["exponential"]
    """Always `exponential`."""


class GaussianUpdate(_Update):
    """Update rule `gaussian`: weight exp(-d^2 / (2 sigma_m^2)), d the norm of the differences of all beams, metres."""

    rule: Literal["gaussian"]
    """Always `gaussian`."""
    sigma_m: Positive | None = None
    """Standard deviation of d, metres; null: 1."""


class InverseRmsdUpdate(_Update):
    """Update rule `inverse_rmsd`: weight 1 / max(RMSD, floor_m), RMSD the root mean square difference of the beams."""

    rule: Literal["inverse_rmsd"]
    """Always `inverse_rmsd`."""
    floor_m: Positive | None = None
    """Smallest RMSD that is distinguished, metres; null: 0.001."""


class BeamUpdate(_Update):
    """Update rule `beam`: the beam model of Thrun et al. (2005), section 6.3, tempered; recommended for live robots.

    Each beam is a mixture of a hit, a short return, a no-return and a random return. The shares are scaled to sum to 1.
    """

    rule: Literal["beam"] = "beam"
    """Always `beam`."""
    z_hit: NotNegative | None = None
    """Share of hits: returns from the predicted surface; null: the rest of the shares."""
    z_short: NotNegative | None = None
    """Share of short returns, from something in front of the object; null: 0.05."""
    z_no_return: NotNegative | None = None
    """Share of no-returns where a return is predicted; null: the lidar's `dropout` plus 0.05."""
    z_random: NotNegative | None = None
    """Share of random returns, uniform up to `range_max`; null: 0.05."""
    sigma_hit_m: Positive | None = None
    """Standard deviation of a hit at short range, metres; null: the lidar's `noise_m`."""
    lambda_short_per_m: Positive | None = None
    """Decay of short returns with range, 1/m; null: 1."""
    temper: Annotated[float, Ge(LEAST), Le(1.0)] | None = None
    """Exponent of the product over all beams, because the errors of neighbouring beams are correlated; null: one
    independent beam for every 4 degrees."""


class PluginUpdate(_Update):
    """Update rule `plugin`: the weights of a rule that a Python package beside the service provides.

    The service finds such rules in the entry points of the group `voa.rules`. A scenario whose rule is not installed
    is refused with a list of those that are.
    """

    rule: Literal["plugin"]
    """Always `plugin`."""
    name: Name
    """Name of the rule, which is the name of its entry point."""
    parameters: FreeObject = Field(default={})
    """Parameters of the rule, which checks them itself."""


BuiltInUpdate = MarginUpdate | ExponentialUpdate | GaussianUpdate | InverseRmsdUpdate | BeamUpdate
UpdateRule = Annotated[BuiltInUpdate | PluginUpdate, Field(discriminator="rule")]
BUILT_IN: Mapping[str, type[BuiltInUpdate]] = MappingProxyType(
    {get_args(message.model_fields["rule"].annotation)[0]: message for message in get_args(BuiltInUpdate)}
)
"""Messages of the built-in rules by name, in the order of `voa_core.rules.registry.RULES`."""
PAPER_RULES = tuple(name for name, message in BUILT_IN.items() if message is not BeamUpdate)
"""Names of the update rules of the papers; `beam` is this project's own."""
POLICY_FIELDS = frozenset({"rule", "on_no_match", "on_nothing_seen", "reject_above_rmsd_mm", "score_floor"})
"""Fields of an update rule that apply to every rule, and are no parameters of one."""


def default_update(name: str, no_return_m: float | None = None, on_no_match: OnNoMatch = "reject") -> UpdateRule:
    """Make the update of a rule with its default parameters; a name that is not built in names a plugin's rule.

    Args:
        name: of the rule.
        no_return_m: range that stands for a no-return, metres; None: the lidar's `range_max`.
        on_no_match: effect of a scan that no pose explains.
    """
    if name not in BUILT_IN:
        return PluginUpdate(rule="plugin", name=name, no_return_m=no_return_m, on_no_match=on_no_match)
    fields = {"rule": name, "no_return_m": no_return_m, "on_no_match": on_no_match}
    return BUILT_IN[name].model_validate(fields)
