"""A PostgreSQL that does not answer is a failure within seconds; only one thread tries it again."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from sqlalchemy import make_url

from tests.support.postgres import Server
from tests.support.proxy import Wire, wire
from tests.support.waiting import wait_for
from tests.voa_store.samples import change, create, next_version, scenario, write
from voa_store.errors import Unavailable
from voa_store.patience import Outage, parameters
from voa_store.records import StoredResponse
from voa_store.sql import SqlStore

PATIENCE_S = 1.0


@pytest.fixture
def between(postgres: Server) -> Iterator[Wire]:
    with wire(make_url(postgres.url()).port or 0) as own:
        yield own


@pytest.fixture
def store(postgres: Server, between: Wire) -> Iterator[SqlStore]:
    url = make_url(postgres.new_database()).set(port=between.port)
    own = SqlStore(url.render_as_string(hide_password=False), PATIENCE_S)
    own.put_scenario(scenario("A"))
    create(own)
    yield own
    between.mend()
    own.close()


def refused(store: SqlStore) -> float:
    """Return the seconds after which a write is refused."""
    began = time.monotonic()
    with pytest.raises(Unavailable):
        change(store, "S", write(), next_version)
    return time.monotonic() - began


def test_a_silent_server_is_given_up_and_comes_back(store: SqlStore, between: Wire) -> None:
    between.cut()
    with ThreadPoolExecutor(8) as pool:
        took = list(pool.map(lambda _: refused(store), range(8)))
    assert max(took) < 4 * PATIENCE_S
    assert refused(store) < 0.5 * PATIENCE_S, "during an outage nobody waits"
    between.mend()

    def answered() -> StoredResponse | None:
        try:
            return change(store, "S", write(), next_version)
        except Unavailable:
            return None

    assert wait_for(answered, "the database to be back") == StoredResponse("v1", 1)
    assert [entry.state.version for entry in store.history("S", -1, 9)] == [0, 1]


def test_the_users_own_options_hold() -> None:
    given = parameters(make_url("postgresql://voa@lab/voa?connect_timeout=9&options=-c%20lock_timeout%3D1"), 5.0)
    assert given["connect_timeout"] == "9"
    assert given["options"].endswith("-c lock_timeout=1")
    assert "-c lock_timeout=4000 -c statement_timeout=5000" in given["options"]


def test_an_outage_ends_when_an_attempt_succeeds_and_no_attempt_follows() -> None:
    attempts: list[bool] = []

    def attempt() -> None:
        attempts.append(True)
        if len(attempts) == 1:
            raise OSError("still silent")

    outage = Outage(attempt)
    outage.begin()
    outage.begin()
    assert outage.present
    wait_for(lambda: not outage.present, "the second attempt")
    assert len(attempts) == 2


def test_a_closed_outage_makes_no_attempt() -> None:
    attempts: list[bool] = []
    outage = Outage(lambda: attempts.append(True))
    outage.close()
    outage.begin()
    assert not outage.present
    assert attempts == []
