"""Looks of mapped robots are counted once: over both databases, by one process and by two."""

from dataclasses import replace
from functools import partial

import pytest

from tests.voa_store.samples import THREADS, Open, at_once, change, create, key, next_version, refuse, write
from voa_service.ports import Store
from voa_store.errors import LookRepeated
from voa_store.records import IdempotencyKey, RobotLook, StoredResponse, Write

ROBOT = "tb3_1"


def look(number: int, digest: str = "d", robot: str = ROBOT) -> RobotLook:
    return RobotLook(robot, number, f"{digest}{number}")


def looked(counted: RobotLook, named: IdempotencyKey | None = None) -> Write:
    """The write that brings a look."""
    return replace(write(named), look=counted)


def count(
    store: Store, counted: RobotLook, id_: str = "S", named: IdempotencyKey | None = None
) -> StoredResponse | None:
    return change(store, id_, looked(counted, named), next_version)


def version(store: Store, id_: str = "S") -> int:
    state = store.get_session(id_)
    assert state is not None
    return state.version


def test_looks_are_read_by_both_stores_the_newest_first(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one)
    for number in (1, 2, 3):
        count(one if number % 2 else other, look(number))
    for store in pair:
        assert store.robot_looks("S", ROBOT, 9) == [look(3), look(2), look(1)]
        assert store.robot_looks("S", ROBOT, 2) == [look(3), look(2)]


def test_looks_are_of_one_session_and_one_robot(store: Store) -> None:
    for id_ in ("S", "T"):
        create(store, id_)
    count(store, look(1))
    count(store, look(1, robot="another"))
    count(store, look(1, "e"), "T")
    assert store.robot_looks("S", ROBOT, 9) == [look(1)]
    assert store.robot_looks("S", "another", 9) == [look(1, robot="another")]
    assert store.robot_looks("T", ROBOT, 9) == [look(1, "e")]
    assert store.robot_looks("S", "nobody", 9) == store.robot_looks("nothing", ROBOT, 9) == []


@pytest.mark.parametrize("digest", ["d", "another"])
def test_a_number_that_is_counted_is_refused_and_nothing_is_changed(pair: tuple[Store, Store], digest: str) -> None:
    one, other = pair
    create(one)
    count(one, look(1))
    before = one.get_session("S")
    with pytest.raises(LookRepeated) as caught:
        count(other, look(1, digest), named=key("again"))
    assert "look 1 of robot 'tb3_1'" in str(caught.value)
    after = other.get_session("S")
    assert before is not None
    assert after is not None
    assert (after.version, after.updated_at) == (before.version, before.updated_at)
    assert [entry.state.version for entry in other.history("S", -1, 9)] == [0, 1]
    assert one.robot_looks("S", ROBOT, 9) == [look(1)]
    assert one.get_response(key("again")) is None, "its key stays free"


def test_a_look_that_changes_nothing_is_not_counted(store: Store) -> None:
    create(store)
    answered = change(store, "S", looked(look(1), key()), refuse)
    assert answered == StoredResponse("refused at v0", 0)
    assert store.robot_looks("S", ROBOT, 9) == []
    count(store, look(1, "later"))
    assert store.robot_looks("S", ROBOT, 9) == [look(1, "later")]


def test_a_look_again_under_its_key_is_answered_and_counted_once(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one)
    first = count(one, look(1), named=key())
    assert count(other, look(1), named=key()) == first
    assert (version(one), other.robot_looks("S", ROBOT, 9)) == (1, [look(1)])


def test_a_write_that_is_no_look_counts_none(store: Store) -> None:
    create(store)
    change(store, "S", write(), next_version)
    assert store.robot_looks("S", ROBOT, 9) == []


def test_looks_go_with_their_session(store: Store) -> None:
    for id_ in ("S", "T"):
        create(store, id_)
        count(store, look(1), id_)
    store.delete_session("S", None, None)
    assert (store.robot_looks("S", ROBOT, 9), store.robot_looks("T", ROBOT, 9)) == ([], [look(1)])
    assert count(store, look(1)) is None, "there is no such session"
    create(store, "S")
    count(store, look(1, "anew"))
    assert store.robot_looks("S", ROBOT, 9) == [look(1, "anew")]


def test_looks_are_there_after_reopening(opened: Open, store: Store) -> None:
    create(store)
    count(store, look(2**31))
    store.close()
    assert opened().robot_looks("S", ROBOT, 9) == [look(2**31)]


def outcome(store: Store, counted: RobotLook) -> str:
    try:
        count(store, counted)
    except LookRepeated:
        return "repeated"
    return "accepted"


def test_of_processes_that_count_one_number_at_once_one_gets_through(pair: tuple[Store, Store]) -> None:
    create(pair[0])
    for number in range(1, 6):
        calls = [partial(outcome, store, look(number, f"{n}-")) for n, store in enumerate(pair * THREADS)]
        outcomes = at_once(calls)
        assert sorted(outcomes) == ["accepted"] + ["repeated"] * (2 * THREADS - 1)
        assert version(pair[0]) == number
        winner = outcomes.index("accepted")
        assert pair[1].robot_looks("S", ROBOT, 1) == [look(number, f"{winner}-")]


def test_robots_of_one_session_count_side_by_side(pair: tuple[Store, Store]) -> None:
    create(pair[0])
    robots = [f"r{n}" for n in range(2 * THREADS)]
    stores = pair * THREADS
    assert at_once([partial(outcome, s, look(1, robot=r)) for s, r in zip(stores, robots, strict=True)]) == [
        "accepted"
    ] * len(robots)
    assert version(pair[0]) == len(robots)
