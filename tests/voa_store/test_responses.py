"""Stored responses: kept for a stated time, and no longer than their session."""

from itertools import count

import pytest
from sqlalchemy import text

from tests.support.waiting import wait_for
from tests.voa_store.samples import change, create, engine_of, key, next_version, refuse, scenario, write
from voa_store.sql import SqlStore

DAY = 86_400


class Clock:
    """Clock of a test, in seconds."""

    def __init__(self) -> None:
        self.now = 1_000_000.5

    def __call__(self) -> float:
        return self.now


def store_of(url: str, clock: Clock) -> SqlStore:
    store = SqlStore(url, seconds=clock)
    store.put_scenario(scenario("A"))
    return store


def keys(url: str) -> list[str]:
    """Keys of the stored responses."""
    engine = engine_of(url)
    with engine.connect() as connection:
        stored = [name for (name,) in connection.execute(text("SELECT key FROM answers ORDER BY key"))]
    engine.dispose()
    return stored


def test_responses_are_removed_once_they_are_too_old(database_url: str) -> None:
    clock = Clock()
    store = store_of(database_url, clock)
    create(store, "S")
    for name in ("first", "second"):
        change(store, "S", write(key(name)), next_version)
        clock.now += DAY
    store.forget_responses(2 * DAY, lambda _: None)
    assert keys(database_url) == ["first", "second"]
    clock.now += 1
    store.forget_responses(2 * DAY, lambda _: None)
    assert keys(database_url) == ["second"]
    assert store.get_response(key("first")) is None
    assert change(store, "S", write(key("first")), next_version) is not None, "an old key is a new call"
    store.close()


def test_many_responses_are_removed_in_many_transactions_and_a_pause_can_end_it(database_url: str) -> None:
    clock, pauses = Clock(), count()
    store = store_of(database_url, clock)
    create(store, "S")
    for number in range(600):
        change(store, "S", write(key(f"{number:03}")), refuse)
    clock.now += DAY
    store.forget_responses(1.0, lambda _: next(pauses) == 1)  # dating takes one transaction
    assert len(keys(database_url)) == 600 - 256
    store.forget_responses(1.0, lambda _: None)
    assert keys(database_url) == []
    store.close()


def test_responses_from_before_their_times_were_stored_count_from_now_and_orphans_go(database_url: str) -> None:
    clock = Clock()
    store = store_of(database_url, clock)
    create(store, "S", key("made", scope="caller"))
    change(store, "S", write(key("K")), next_version)
    create(store, "T")
    change(store, "T", write(key("gone", scope="session:T")), next_version)
    engine = engine_of(database_url)
    with engine.begin() as connection:  # as an earlier version deleted a session
        connection.execute(text("UPDATE answers SET at = NULL"))
        connection.execute(text("DELETE FROM history WHERE session = 'T'"))
        connection.execute(text("DELETE FROM sessions WHERE id = 'T'"))
    engine.dispose()
    store.forget_responses(DAY, lambda _: None)
    assert keys(database_url) == ["K", "made"]
    clock.now += DAY + 1
    store.forget_responses(DAY, lambda _: None)
    assert keys(database_url) == []
    store.close()


@pytest.mark.parametrize("responses", [10, 200])
def test_responses_go_with_their_session(database_url: str, responses: int) -> None:
    store = store_of(database_url, Clock())
    create(store, "S")
    create(store, "SS")
    for number in range(responses):
        change(store, "S", write(key(str(number))), refuse)
    change(store, "SS", write(key("other", scope="session:SS")), refuse)
    assert store.delete_session("S", key("deleted"), None)
    assert store.get_session("S") is None
    wait_for(lambda: keys(database_url) == ["deleted", "other"], "the responses of S to go")
    assert store.delete_session("S", key("deleted"), None)
    store.close()
