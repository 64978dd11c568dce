"""A robot keeps its session: claims over both databases, by one process and by two."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest
from sqlalchemy import create_engine, text

from tests.support.postgres import Server
from tests.support.waiting import wait_for
from tests.voa_store.samples import THREADS, Open, at_once, change, create, key, next_version, scenario, write
from voa_service.ports import Store
from voa_store.errors import StoreError
from voa_store.records import IdempotencyKey
from voa_store.sql import SqlStore

ROBOT = "tb3_1"


@pytest.fixture
def store(store: Store) -> Store:
    """A store with the scenarios "A" and "B"."""
    store.put_scenario(scenario("B"))
    return store


@pytest.fixture
def pair(opened: Open, store: Store) -> tuple[Store, Store]:
    """Two stores on one database, as of two processes."""
    return store, opened()


def peeks(stores: Sequence[Store], robot: str = ROBOT, of: str = "A") -> str | None:
    """The session that every store finds, which must be the same."""
    (session,) = {store.robot_session(robot, of) for store in stores}
    return session


def test_without_a_claim_a_robot_is_for_the_newest_session_on_its_scenario(pair: tuple[Store, Store]) -> None:
    one, other = pair
    assert peeks(pair) is None
    create(one, "first")
    create(one, "elsewhere", of="B")
    assert peeks(pair) == "first"
    create(other, "second")
    assert peeks(pair) == "second", "to peek is to change nothing"
    assert peeks(pair, of="B") == "elsewhere"


def test_a_settled_robot_stays_where_it_is(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one, "first")
    assert one.settle_robot(ROBOT, "A") == "first"
    create(other, "second")
    assert peeks(pair) == "first"
    assert [store.settle_robot(ROBOT, "A") for store in pair] == ["first", "first"]
    assert change(one, "first", write(), next_version)
    assert peeks(pair) == "first"
    assert peeks(pair, "another robot") == "second"


def test_a_claim_is_durable(opened: Open, store: Store) -> None:
    create(store, "first")
    store.settle_robot(ROBOT, "A")
    create(store, "second")
    store.close()
    assert opened().robot_session(ROBOT, "A") == "first"


def test_nothing_is_settled_while_there_is_no_session(pair: tuple[Store, Store]) -> None:
    one, other = pair
    assert one.settle_robot(ROBOT, "A") is None
    create(other, "first")
    assert peeks(pair) == "first"


def test_another_claim_moves_a_robot(pair: tuple[Store, Store]) -> None:
    one, other = pair
    for name in ("first", "second", "third"):
        create(one, name)
    assert one.claim_robot(ROBOT, "second")
    assert peeks(pair) == "second"
    assert other.settle_robot(ROBOT, "A") == "second"
    assert other.claim_robot(ROBOT, "first")
    assert peeks(pair) == "first"


def test_a_claim_of_a_session_that_is_not_there_changes_nothing(store: Store) -> None:
    create(store, "first")
    store.settle_robot(ROBOT, "A")
    assert not store.claim_robot(ROBOT, "nothing")
    assert store.robot_session(ROBOT, "A") == "first"


def test_a_robot_that_is_nobody_s_stays_so_until_the_next_claim(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one, "first")
    assert one.claim_robot(ROBOT, None)
    create(one, "second")
    assert peeks(pair) is None
    assert [store.settle_robot(ROBOT, "A") for store in pair] == [None, None]
    assert other.claim_robot(ROBOT, "first")
    assert peeks(pair) == "first"


def test_a_session_that_is_deleted_is_followed_by_the_newest_that_was_opened_after_it(
    pair: tuple[Store, Store],
) -> None:
    one, other = pair
    for name in ("older", "claimed", "later", "latest"):
        create(one, name)
    create(one, "elsewhere", of="B")
    one.claim_robot(ROBOT, "claimed")
    other.delete_session("claimed", None, None)
    assert peeks(pair) == "latest"
    assert other.settle_robot(ROBOT, "A") == "latest"
    create(one, "newest")
    assert peeks(pair) == "latest"


def test_an_older_session_is_never_taken_up_again(pair: tuple[Store, Store]) -> None:
    one, other = pair
    for name in ("older", "claimed"):
        create(one, name)
    one.settle_robot(ROBOT, "A")
    one.delete_session("claimed", None, None)
    assert peeks(pair) is None
    assert other.settle_robot(ROBOT, "A") is None
    create(other, "newer")
    assert peeks(pair) == "newer"
    assert one.settle_robot(ROBOT, "A") == "newer"


def test_a_session_that_is_opened_when_all_are_deleted_counts_as_opened_after_them(pair: tuple[Store, Store]) -> None:
    """A database that gives the numbers of deleted rows again must not give one up to a claim's."""
    one, other = pair
    for name in ("older", "claimed"):
        create(one, name)
    one.settle_robot(ROBOT, "A")
    for name in ("older", "claimed"):
        one.delete_session(name, None, None)
    create(other, "newer")
    assert peeks(pair) == "newer"


def test_a_robot_that_is_mapped_to_another_scenario_gets_a_session_of_that_scenario(pair: tuple[Store, Store]) -> None:
    one, _ = pair
    create(one, "there", of="B")
    create(one, "first")
    one.settle_robot(ROBOT, "A")
    assert peeks(pair, of="B") == "there"
    one.delete_session("first", None, None)
    assert peeks(pair, of="B") == "there", "what was opened before a session elsewhere is not older than anything"
    assert one.settle_robot(ROBOT, "B") == "there"
    assert peeks(pair, of="B") == "there"


@pytest.mark.parametrize("named", [None, key(scope="caller")])
def test_a_session_is_opened_with_its_robots(pair: tuple[Store, Store], named: IdempotencyKey | None) -> None:
    one, _ = pair
    create(one, "first")
    for robot in (ROBOT, "other"):
        one.settle_robot(robot, "A")
    create(one, "second", named, ["other", ROBOT])
    create(one, "third")
    assert [peeks(pair, robot) for robot in (ROBOT, "other", "free")] == ["second", "second", "third"]


def test_a_creation_again_under_its_key_claims_nothing(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one, "first", key(scope="caller"), [ROBOT])
    create(one, "second", robots=[ROBOT])
    assert create(other, "third", key(scope="caller"), [ROBOT]).body == "created first"
    assert peeks(pair) == "second"
    with pytest.raises(StoreError, match="another request"):
        create(other, "third", key(scope="caller", fingerprint="G"), [ROBOT])
    assert peeks(pair) == "second"


def opens_and_settles(store: Store, id_: str, robot: str) -> str | None:
    create(store, id_)
    return store.settle_robot(robot, "A")


def test_of_processes_that_settle_at_once_the_first_decides_for_all(pair: tuple[Store, Store]) -> None:
    for round_ in range(5):
        robot = f"robot {round_}"
        calls = [partial(opens_and_settles, store, f"{robot}-{n}", robot) for n, store in enumerate(pair * THREADS)]
        (decided,) = set(at_once(calls))
        assert decided is not None
        assert peeks(pair, robot) == decided


def test_of_processes_that_follow_a_deleted_session_at_once_the_first_decides_for_all(
    pair: tuple[Store, Store],
) -> None:
    create(pair[0], "claimed", robots=[ROBOT])
    for round_ in range(5):
        claimed = peeks(pair)
        assert claimed is not None
        pair[1].delete_session(claimed, None, None)
        calls = [partial(opens_and_settles, store, f"{round_}-{n}", ROBOT) for n, store in enumerate(pair * THREADS)]
        (decided,) = set(at_once(calls))
        assert peeks(pair) == decided


def test_who_settles_waits_for_who_does_so_already_and_finds_the_same(postgres: Server) -> None:
    url = postgres.new_database()
    store, engine = SqlStore(url), create_engine(url)
    store.put_scenario(scenario("A"))
    for id_ in ("deleted", "first", "second"):
        create(store, id_, robots=[ROBOT] if id_ == "deleted" else [])
    store.delete_session("deleted", None, None)

    def one_waits() -> bool:
        waiting = (
            "SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock' AND datname = current_database()"
        )
        with engine.connect() as connection:
            return bool(connection.execute(text(waiting)).scalar_one())

    with ThreadPoolExecutor(1) as pool, engine.connect() as other:
        settled = "UPDATE claims SET session = 'first', after = (SELECT seq FROM sessions WHERE id = 'first')"
        other.execute(text(settled))
        future = pool.submit(store.settle_robot, ROBOT, "A")
        wait_for(one_waits, "the other one to wait")
        other.commit()
        assert future.result() == "first"
    assert store.robot_session(ROBOT, "A") == "first"
    engine.dispose()
    store.close()


def test_sessions_that_claim_the_same_robots_at_once_all_open_and_one_has_them_all(pair: tuple[Store, Store]) -> None:
    robots = ["a", "b", "c", "d"]
    for round_ in range(5):
        calls = [
            partial(create, store, f"{round_}-{n}", None, robots if n % 2 else robots[::-1])
            for n, store in enumerate(pair * THREADS)
        ]
        at_once(calls)
        assert len({peeks(pair, robot) for robot in robots}) == 1
        assert len(pair[0].list_sessions(999, None).items) == (round_ + 1) * 2 * THREADS


def test_a_claim_and_a_deletion_at_once_leave_a_claim_that_is_over(pair: tuple[Store, Store]) -> None:
    for round_ in range(5):
        id_ = f"S{round_}"
        create(pair[0], id_)
        at_once([partial(pair[0].claim_robot, ROBOT, id_), partial(pair[1].delete_session, id_, None, None)])
        assert peeks(pair) is None
    create(pair[0], "next")
    assert peeks(pair) == "next"
