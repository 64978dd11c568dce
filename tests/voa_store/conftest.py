"""Stores on an empty database of each kind."""

from collections.abc import Iterator

import pytest

from tests.voa_store.samples import Open, scenario
from voa_service.ports import Store
from voa_store.sql import SqlStore


@pytest.fixture
def opened(database_url: str) -> Iterator[Open]:
    """A function that opens another store on the test's database."""
    stores: list[Store] = []

    def once_more() -> Store:
        store = SqlStore(database_url)
        stores.append(store)
        return store

    yield once_more
    for store in stores:
        store.close()


@pytest.fixture
def store(opened: Open) -> Store:
    """A store with the scenario "A"."""
    store = opened()
    store.put_scenario(scenario("A"))
    return store


@pytest.fixture
def pair(opened: Open, store: Store) -> tuple[Store, Store]:
    """Two stores on one database, as of two processes."""
    return store, opened()
