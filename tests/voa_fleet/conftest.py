"""Fixtures of the fleet's tests."""

from tests.support.fleet_objects import mug, mug_plans, mug_world, targets

__all__ = ["mug", "mug_plans", "mug_world", "targets"]
