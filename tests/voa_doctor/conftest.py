"""A router and a service on it, for all tests of the doctor."""

from collections.abc import Iterator

import pytest

from tests.support.routers import Router, router
from tests.voa_cli.labs import Lab, service_on


@pytest.fixture(scope="package")
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


@pytest.fixture(scope="package")
def lab(own_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with service_on(own_router, tmp_path_factory.mktemp("lab")) as service:
        yield service
