"""Update rules of scenarios: from their messages to the mathematics, and those that other packages provide."""

from collections.abc import Mapping
from importlib.metadata import entry_points
from types import MappingProxyType

import structlog

from voa_core.lidars import LidarModel
from voa_core.rules.plugins import RuleFactory, installed_rule
from voa_core.rules.protocol import UpdateRule
from voa_core.rules.registry import defaults, rule_of
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
            log.error("update_rule_not_loaded", rule=entry.name, source=entry.value, reason="the name is taken")
            continue
        try:
            installed[entry.name] = entry.load()
        except Exception:
            log.exception("update_rule_not_loaded", rule=entry.name, source=entry.value)
        else:
            log.info("update_rule_loaded", rule=entry.name, source=entry.value)
    return MappingProxyType(installed)


def update_defaults(update: updates.UpdateRule, lidar: LidarModel) -> dict[str, float]:
    """Default of each parameter of a scenario's update rule; a rule of another package has its own, but for one."""
    if isinstance(update, updates.PluginUpdate):
        return {"no_return_m": lidar.range_max}
    return defaults(update.rule, lidar)


def rule_of_update(update: updates.UpdateRule, lidar: LidarModel, installed: InstalledRules) -> UpdateRule:
    """Make the update rule of a scenario whose parameters are filled in.

    Args:
        update: with every default written out.
        lidar: the scenario's.
        installed: the update rules of other packages.

    Raises:
        VoaError: the rule is not installed, or refuses its parameters.
    """
    if isinstance(update, updates.PluginUpdate):
        no_return_m = lidar.range_max if update.no_return_m is None else update.no_return_m
        return installed_rule(installed, update.name, update.parameters, no_return_m, lidar)
    return rule_of(update.rule, lidar, **update.model_dump(exclude=set(updates.POLICY_FIELDS)))
