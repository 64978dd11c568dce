"""Fixtures of the tests of reports: a small evaluation of values of two objects."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from tests.support.fleet_objects import targets
from voa_evaluation.values.results import Values
from voa_evaluation.values.running import evaluate_values
from voa_evaluation.values.setting import QUICK, ROBOT_ERRORS
from voa_fleet.world.objects import FleetObject

__all__ = ["targets"]


@contextmanager
def no_bar(text: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show no progress."""
    yield lambda count: None


@pytest.fixture(scope="session")
def values(targets: dict[str, FleetObject]) -> Values:
    """Block and coupling, two rules, one robot error, a few scans."""
    rules, errors = ("gaussian", "beam"), ROBOT_ERRORS[1:2]
    setting = replace(QUICK, scans=8, beliefs=2, sessions=3, drops=1, rules=rules, robot_errors=errors)
    return evaluate_values([targets["block"], targets["coupling"]], setting, no_bar, 1)
