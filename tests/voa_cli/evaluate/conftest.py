"""Fixtures of the evaluations' tests."""

from tests.support.fleet_objects import mug, targets

__all__ = ["mug", "targets"]
