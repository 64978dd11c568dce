"""Calls of several stores on one database at the same time: none is lost, none takes effect twice."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from threading import Lock

import pytest

from tests.voa_store.samples import (
    THREADS,
    Result,
    at_once,
    belief,
    change,
    create,
    key,
    next_version,
    refuse,
    scenario,
    stored_mesh,
    write,
)
from voa_service.ports import Store
from voa_store.errors import VersionMismatch
from voa_store.records import SessionState, StoredResponse


def test_what_one_store_answered_the_other_reads(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one)
    for version in range(1, 9):
        writer, reader = (one, other) if version % 2 else (other, one)
        change(writer, "S", write(), next_version)
        newest = reader.get_session("S")
        assert newest is not None
        assert newest.version == version
        assert len(reader.history("S", -1, 99)) == version + 1


def test_writers_of_two_stores_lose_no_update_and_never_retry(pair: tuple[Store, Store]) -> None:
    each = 15
    create(pair[0])
    steps, lock = 0, Lock()

    def add_one(state: SessionState) -> Result:
        nonlocal steps
        with lock:
            steps += 1
        more = belief(*(state.belief.p + 1.0))
        after = replace(state, version=state.version + 1, belief=more)
        return Result(StoredResponse("", after.version), after)

    def writer(store: Store) -> Callable[[], list[int]]:
        def run() -> list[int]:
            answers = [change(store, "S", write(), add_one) for _ in range(each)]
            return [answer.version for answer in answers if answer is not None]

        return run

    answered = at_once([writer(store) for store in pair for _ in range(THREADS)])
    count = len(answered) * each
    assert sorted(version for versions in answered for version in versions) == list(range(1, count + 1))
    assert all(a < b for versions in answered for a, b in pairwise(versions))
    assert steps == count, "a step ran again: a retry"
    newest = pair[1].get_session("S")
    assert newest is not None
    assert (newest.version, newest.belief.p.tolist()) == (count, [0.25 + count, 0.75 + count])
    entries = pair[0].history("S", -1, count + 1)
    assert [entry.state.belief.p[0] for entry in entries] == [0.25 + n for n in range(count + 1)]


def test_of_writers_that_saw_the_same_version_one_gets_through(pair: tuple[Store, Store]) -> None:
    create(pair[0])

    def attempt(store: Store) -> Callable[[], str]:
        def run() -> str:
            try:
                answer = change(store, "S", write(None, frozenset({0})), next_version)
            except VersionMismatch:
                return "version mismatch"
            return answer.body if answer else "gone"

        return run

    outcomes = at_once([attempt(store) for store in pair for _ in range(THREADS)])
    assert sorted(outcomes) == ["v1"] + ["version mismatch"] * (2 * THREADS - 1)


@pytest.mark.parametrize("step", [next_version, refuse])
def test_duplicates_of_one_key_at_once_have_one_effect_and_one_answer(
    pair: tuple[Store, Store], step: Callable[[SessionState], Result]
) -> None:
    create(pair[0])
    for round_ in range(5):
        before = len(pair[0].history("S", -1, 99))
        named = key(f"K{round_}")
        calls = [
            lambda store=store, named=named: change(store, "S", write(named), step)
            for store in pair
            for _ in range(THREADS)
        ]
        answers = at_once(calls)
        assert len(set(answers)) == 1
        assert len(pair[1].history("S", -1, 99)) == before + (step is next_version)


def test_duplicates_of_one_creation_at_once_open_one_session(pair: tuple[Store, Store]) -> None:
    for round_ in range(5):
        named = key(f"K{round_}", "caller")
        calls = [
            lambda store=store, id_=f"{round_}-{n}", named=named: create(store, id_, named)
            for n, store in enumerate(pair * THREADS)
        ]
        assert len(set(at_once(calls))) == 1
        assert len(pair[0].list_sessions(99, None).items) == round_ + 1


def test_duplicates_of_one_delete_at_once_all_succeed_and_without_a_key_one_does(pair: tuple[Store, Store]) -> None:
    for named, expected in ((key("D"), 2 * THREADS), (None, 1)):
        create(pair[0])
        calls = [
            lambda store=store, named=named: store.delete_session("S", named, None)
            for store in pair
            for _ in range(THREADS)
        ]
        assert sum(at_once(calls)) == expected
        assert pair[0].get_session("S") is None


def test_equal_content_put_at_once_is_new_once(pair: tuple[Store, Store]) -> None:
    for round_ in range(5):
        puts = [partial(store.put_scenario, scenario(f"R{round_}", str(n))) for n, store in enumerate(pair * THREADS)]
        results = at_once(puts)
        assert sum(new for _, new in results) == 1
        assert len({stored for stored, _ in results}) == 1
        meshes = at_once([partial(store.put_object, stored_mesh(0.01 * (round_ + 1))) for store in pair * THREADS])
        assert sum(new for _, new in meshes) == 1


def test_a_change_and_a_delete_at_once_leave_nothing_behind(pair: tuple[Store, Store]) -> None:
    for _ in range(5):
        create(pair[0])
        changed, deleted = at_once(
            [
                lambda: change(pair[0], "S", write(), next_version),
                lambda: pair[1].delete_session("S", None, None),
            ]
        )
        assert deleted is True
        assert changed in (None, StoredResponse("v1", 1))
        assert pair[0].history("S", -1, 9) == []


# ------------------------------------------------------------------------------------------- the database itself
