"""Update rules: from a scenario's `update` message to the rule and the policy of the mathematics."""

from voa_core.lidars import LidarModel
from voa_core.rules.rules import UpdateRule, defaults, rule_of
from voa_core.updating import UpdatePolicy
from voa_msgs import updates


def filled_update(update: updates.UpdateRule, lidar: LidarModel) -> updates.UpdateRule:
    """Return an update message with every parameter of its rule written out.

    Args:
        update: as received; null parameters take the rule's defaults.
        lidar: of the scenario; the defaults of some parameters depend on it.

    Raises:
        VoaError: there is no such rule.
    """
    stated = {name: value for name, value in update.model_dump().items() if value is not None}
    filled: updates.UpdateRule = type(update).model_validate(
        defaults(update.rule, lidar) | {"reject_above_rmsd_mm": None} | stated
    )
    return filled


def update_rule(update: updates.UpdateRule, lidar: LidarModel) -> UpdateRule:
    """Build the update rule that a filled-in message describes.

    Raises:
        VoaError: a parameter has a value that the rule does not allow.
    """
    return rule_of(update.rule, lidar, **update.model_dump(exclude=set(updates.POLICY_FIELDS)))


def update_policy(update: updates.UpdateRule) -> UpdatePolicy:
    """Build the policy that decides which observations are accepted."""
    return UpdatePolicy(update.on_no_match, update.reject_above_rmsd_mm, update.score_floor, update.on_nothing_seen)
