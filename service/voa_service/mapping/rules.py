"""Update rules: from a scenario's `update` message to the mathematics, and the rules that other packages provide."""

from collections.abc import Mapping
from importlib.metadata import entry_points
from types import MappingProxyType

import structlog

from voa_core.lidars import LidarModel
from voa_core.rules.plugins import RuleFactory, installed_rule
from voa_core.rules.protocol import UpdateRule
from voa_core.rules.registry import defaults, rule_of
from voa_core.updating import UpdatePolicy
from voa_msgs import updates

GROUP = "voa.rules"
"""Group of the entry points by which packages provide update rules."""
InstalledRules = Mapping[str, RuleFactory]
"""Factories of the update rules of other packages, by name."""
NO_RULES: InstalledRules = MappingProxyType({})


def load_installed_rules() -> InstalledRules:
    """Load the update rules that the installed packages provide.

    A rule that cannot be loaded, and a second rule of the same name, are logged and left out: a scenario that names
    it is then refused, and all others work.
    """
    log = structlog.get_logger("voa")
    installed: dict[str, RuleFactory] = {}
    for entry in entry_points(group=GROUP):
        if entry.name in installed:
            log.error("an update rule is not loaded", rule=entry.name, source=entry.value, reason="the name is taken")
            continue
        try:
            installed[entry.name] = entry.load()
        except Exception:
            log.exception("an update rule is not loaded", rule=entry.name, source=entry.value)
        else:
            log.info("an update rule is loaded", rule=entry.name, source=entry.value)
    return MappingProxyType(installed)


def filled_update(update: updates.UpdateRule, lidar: LidarModel, *, spread: bool = False) -> updates.UpdateRule:
    """Return an update message with every parameter of its rule written out.

    Args:
        update: as received; null parameters take the rule's defaults.
        lidar: of the scenario; the defaults of some parameters depend on it.
        spread: True if the scenario states a spread of the object, on which a default depends.

    Raises:
        VoaError: there is no such rule.
    """
    if isinstance(update, updates.PluginUpdate):
        usual = {"no_return_m": lidar.range_max}  # the defaults of other parameters are its package's
    else:
        usual = defaults(update.rule, lidar, spread=spread)
    stated = {name: value for name, value in update.model_dump().items() if value is not None}
    filled: updates.UpdateRule = type(update).model_validate(usual | {"reject_above_rmsd_mm": None} | stated)
    return filled


def update_rule(update: updates.UpdateRule, lidar: LidarModel, installed: InstalledRules) -> UpdateRule:
    """Build the update rule that a filled-in message describes.

    Args:
        update: with every default written out.
        lidar: of the scenario.
        installed: the update rules of other packages.

    Raises:
        VoaError: the rule is not installed, or a parameter has a value that the rule does not allow.
    """
    if isinstance(update, updates.PluginUpdate):
        no_return_m = lidar.range_max if update.no_return_m is None else update.no_return_m
        return installed_rule(installed, update.name, update.parameters, no_return_m, lidar)
    return rule_of(update.rule, lidar, **update.model_dump(exclude=set(updates.POLICY_FIELDS)))


def update_policy(update: updates.UpdateRule) -> UpdatePolicy:
    """Build the policy that decides which observations are accepted."""
    return UpdatePolicy(update.on_no_match, update.reject_above_rmsd_mm, update.score_floor, update.on_nothing_seen)
