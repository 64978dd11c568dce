"""Fixtures of the tests of the evaluation of values: benches with few scans."""

import pytest

from tests.support.fleet_objects import targets
from voa_evaluation.values.bench import Bench, make_bench
from voa_evaluation.values.setting import ROBOT_ERRORS
from voa_fleet.world.objects import FleetObject

__all__ = ["targets"]


@pytest.fixture(scope="session")
def bench(targets: dict[str, FleetObject]) -> Bench:
    """The block under `beam`, for a robot error of 1 cm and 1 degree."""
    return make_bench(targets["block"], "beam", ROBOT_ERRORS[1], 6, 3)


@pytest.fixture(scope="session")
def margin_bench(targets: dict[str, FleetObject]) -> Bench:
    """The block under `margin`, whose scans often match no pose, for a robot without error."""
    return make_bench(targets["block"], "margin", ROBOT_ERRORS[0], 6, 3)
