"""Fixtures of the tests of the Zenoh entrypoint."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support.routers import Router, router
from tests.support.serving import data_scenario, serving
from tests.voa_service.zenoh.replica_pair import Pair
from tests.voa_service.zenoh.ros_lab import Lab, lab


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Pair]:
    """Two processes on one database."""
    with ExitStack() as stack:
        yield Pair([stack.enter_context(serving(tmp_path)) for _ in range(2)])


@pytest.fixture(scope="module")
def own_router() -> Iterator[Router]:
    """A router, one per module of tests."""
    with router() as own:
        yield own


@pytest.fixture
def own(tmp_path: Path, own_router: Router) -> Iterator[Lab]:
    """A service on the router whose mapping of robots a test may write."""
    with lab(tmp_path, own_router) as own:
        yield own


@pytest.fixture
def session(own: Lab) -> str:
    """A session of that service."""
    return own.service.open(own.service.create(data_scenario()))
