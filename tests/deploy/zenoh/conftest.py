"""Router of a lab, once for the tests of a module and way to log in."""

from collections.abc import Iterator

import pytest
import zenoh

from tests.support.lab_router import OBSERVER, LabRouter, lab_router


@pytest.fixture(scope="module", params=["certificates", "passwords", "both"])
def lab(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LabRouter]:
    """A running router whose clients log in by certificates, passwords, or both."""
    with lab_router(tmp_path_factory.mktemp("lab"), request.param) as running:
        yield running


@pytest.fixture(scope="module")
def observing(lab: LabRouter) -> Iterator[zenoh.Session]:
    """A session that the router allows everything."""
    with lab.joined(OBSERVER) as session:
        yield session
