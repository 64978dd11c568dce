"""The simulator, with a database that every run copies."""

from collections.abc import Iterator

import pytest

from tests.simulation.run import Simulator, template


@pytest.fixture(scope="module")
def simulator() -> Iterator[Simulator]:
    with template() as (database, model):
        yield Simulator(database, model)
