"""Fixtures of the end-to-end tests."""

from collections.abc import Iterator

import pytest

from tests.support.drive_bench import Bench, benches
from tests.support.routers import router


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """Bench with a router of its own, which all drives share."""
    with router() as own_router, benches(tmp_path_factory.mktemp("bench"), own_router) as own:
        yield own
