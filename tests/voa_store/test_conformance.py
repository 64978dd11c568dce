"""Every promise of `ports.Store`, over every implementation of it."""

import math
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from functools import partial
from typing import TypeVar

import numpy as np
import pytest

from tests.voa_store.samples import (
    NOON,
    THREADS,
    Open,
    Result,
    announcing,
    at_once,
    change,
    create,
    key,
    looking,
    mesh,
    never,
    next_version,
    refuse,
    scenario,
    session,
    stored_mesh,
    upload,
    write,
)
from voa_core.filtering import Belief
from voa_service.ports import Store
from voa_store.errors import KeyReused, SessionMissing, VersionMismatch
from voa_store.records import HistoryKind, Listed, SessionState, StoredObject, StoredResponse

T = TypeVar("T")

FAR = str(10**18 - 1)


def in_steps(listing: Callable[[int, str | None], Listed[T]], limit: int) -> list[list[T]]:
    """Every page of a list."""
    pages, after = [], None
    while True:
        page = listing(limit, after)
        pages.append(page.items)
        if page.next is None:
            return pages
        after = page.next


def bits(state: SessionState) -> tuple[bytes, ...]:
    fit = np.array([-1.0 if state.last_fit_rmsd_mm is None else state.last_fit_rmsd_mm])
    arrays = (state.belief.p, state.belief.log_p, state.prior.p, state.prior.log_p, fit)
    return tuple(array.tobytes() for array in arrays)


# ------------------------------------------------------------------------------------------- objects, scenarios


def test_a_mesh_put_again_is_the_one_that_is_there(store: Store) -> None:
    first, new = store.put_object(stored_mesh(name="first"))
    again, new_again = store.put_object(StoredObject(mesh(), "second", NOON + timedelta(days=1)))
    assert (new, new_again) == (True, False)
    assert [first.name, again.name, again.created_at] == ["first", "first", NOON]
    assert len(store.list_objects(10, None).items) == 1


def test_a_mesh_comes_back_bit_for_bit(store: Store) -> None:
    stored, _ = store.put_object(stored_mesh())
    stored_object = store.get_object(mesh().digest)
    assert stored_object is not None
    for got in (stored, stored_object):
        assert got.object.digest == mesh().digest
        assert got.object.vertices.tobytes() == mesh().vertices.tobytes()
        assert got.object.faces.tobytes() == mesh().faces.tobytes()
        assert (got.name, got.created_at) == ("box", NOON)


def test_an_uploaded_file_is_identified_by_how_it_was_read(pair: tuple[Store, Store]) -> None:
    one, other = pair
    stored, _ = one.put_object(stored_mesh())
    another, _ = one.put_object(stored_mesh(0.06))
    assert other.find_upload(upload()) is None
    for _ in range(2):
        one.put_upload(upload(), stored.object.digest)
    one.put_upload(upload(up="+Y"), another.object.digest)
    for wanted, digest in ((upload(), stored.object.digest), (upload(up="+Y"), another.object.digest)):
        stored_object = other.find_upload(wanted)
        assert stored_object is not None
        assert stored_object.object.digest == digest
    for other_file in ({"sha256": "1" * 64}, {"type": "stl"}, {"scale": 0.3}):
        assert other.find_upload(upload(**other_file)) is None


def test_one_file_uploaded_at_once_is_remembered_once(pair: tuple[Store, Store]) -> None:
    stored, _ = pair[0].put_object(stored_mesh())
    at_once([partial(store.put_upload, upload(), stored.object.digest) for store in pair * THREADS])
    assert pair[0].find_upload(upload()) is not None


def test_a_scenario_put_again_is_the_one_that_is_there(store: Store) -> None:
    first, new = store.put_scenario(scenario("B", "first"))
    again, new_again = store.put_scenario(replace(scenario("B", "second"), created_at=NOON + timedelta(days=1)))
    assert (new, new_again) == (True, False)
    assert first == again == scenario("B", "first") == store.get_scenario("B")


def test_what_is_not_there_is_none(store: Store) -> None:
    for id_ in ("nothing", "", "A' OR '1'='1", "a\0b", "ü" * 300):
        assert store.get_object(id_) is None
        assert store.get_scenario(id_) is None
        assert store.get_session(id_) is None
        assert store.history(id_, -1, 10) == []
        assert change(store, id_, write(), never) is None
        assert not store.delete_session(id_, None, None)


@pytest.mark.parametrize("limit", [1, 2, 3, 5, 6, 100])
def test_lists_are_oldest_first_and_their_pages_have_everything_once(store: Store, limit: int) -> None:
    names = ["z", "m", "a", "k", "b"]
    for position, name in enumerate(names):
        store.put_object(stored_mesh(0.01 * (position + 1), name))
        store.put_scenario(scenario(name))
        create(store, name)
    for pages, expected in (
        ([[item.name for item in page] for page in in_steps(store.list_objects, limit)], names),
        ([[item.id for item in page] for page in in_steps(store.list_scenarios, limit)], ["A", *names]),
        ([[item.id for item in page] for page in in_steps(store.list_sessions, limit)], names),
    ):
        assert [item for page in pages for item in page] == expected
        assert all(len(page) == limit for page in pages[:-1])
        assert 0 < len(pages[-1]) <= limit


def test_an_empty_list_has_no_next(opened: Open) -> None:
    store = opened()
    for listing in (store.list_objects, store.list_scenarios, store.list_sessions):
        assert listing(5, None) == Listed([], None)


def test_after_the_largest_cursor_there_is_nothing(store: Store) -> None:
    create(store)
    for listing in (store.list_objects, store.list_scenarios, store.list_sessions):
        assert listing(5, FAR) == Listed([], None)
    assert store.history("S", int(FAR), 5) == []


def test_a_cursor_holds_while_the_list_grows_and_shrinks(store: Store) -> None:
    for name in ("a", "b", "c", "d"):
        create(store, name)
    first = store.list_sessions(2, None)
    store.delete_session("b", None, None)
    create(store, "e")
    rest = store.list_sessions(10, first.next)
    assert [item.id for item in rest.items] == ["c", "d", "e"]


# ------------------------------------------------------------------------------------------------------ sessions


def test_the_newest_session_is_the_one_that_was_opened_last(pair: tuple[Store, Store]) -> None:
    one, other = pair
    assert one.newest_session() is None
    create(one, "S")
    create(other, "T")
    change(one, "S", write(), next_version)
    newest = one.newest_session()
    assert newest is not None
    assert (newest.id, newest.version) == ("T", 0)
    one.delete_session("T", None, None)
    newest = other.newest_session()
    assert newest is not None
    assert (newest.id, newest.version) == ("S", 1)


def test_the_mark_of_a_session_changes_with_it(pair: tuple[Store, Store]) -> None:
    one, other = pair
    assert one.session_mark("S") is None
    assert one.session_mark("S\0") is None
    create(one)
    first = one.session_mark("S")
    assert first is not None
    assert other.session_mark("S") == first
    change(one, "S", write(), next_version)
    assert other.session_mark("S") == one.session_mark("S") != first
    one.delete_session("S", None, None)
    assert other.session_mark("S") is None


def test_a_stored_response_is_read_by_its_key_from_either_store(pair: tuple[Store, Store]) -> None:
    one, other = pair
    assert one.get_response(key()) is None
    create(one)
    answered = change(one, "S", write(named=key()), next_version)
    assert other.get_response(key()) == answered
    with pytest.raises(KeyReused):
        other.get_response(key(fingerprint="another"))


def test_a_new_session_has_its_prior_as_history(store: Store) -> None:
    answer = store.create_session(
        session(), write(request='{"scenario": "A"}', kind="prior"), StoredResponse("body", 0)
    )
    assert answer == StoredResponse("body", 0)
    (entry,) = store.history("S", -1, 10)
    assert (entry.state.version, entry.kind, entry.request, entry.report) == (0, "prior", '{"scenario": "A"}', None)
    newest = store.get_session("S")
    assert newest is not None
    for state in (entry.state, newest):
        assert (state.id, state.scenario, state.created_at, state.updated_at) == ("S", "A", NOON, NOON)
        assert bits(state) == bits(session())


def test_floats_come_back_bit_for_bit(opened: Open, store: Store) -> None:
    odd = np.array([5e-324, 0.1 + 0.2, 1.0 - 2**-53, -0.0, 2.2250738585072014e-308, 0.1])
    logs = np.array([-math.inf, -1e300, -744.4400719213812, -0.0, math.log(0.1 + 0.2), -1e-17])
    fits = [0.1 + 0.2, 5e-324, 1.7976931348623157e308, 0.0]
    start = replace(session(), belief=Belief(odd, logs), prior=Belief(odd[::-1].copy(), logs[::-1].copy()))
    store.create_session(start, write(), StoredResponse("", 0))
    expected = [start]
    for fit in fits:
        turned = Belief(np.roll(expected[-1].belief.p, 1), np.roll(expected[-1].belief.log_p, 1))
        after = replace(expected[-1], version=expected[-1].version + 1, belief=turned, last_fit_rmsd_mm=fit)
        expected.append(after)
        change(store, "S", write(), lambda _, after=after: Result(StoredResponse("", after.version), after))  # type: ignore[misc] # bound in each round, which mypy cannot infer
    for reader in (store, opened()):
        newest = reader.get_session("S")
        assert newest is not None
        assert bits(newest) == bits(expected[-1])
        assert [bits(entry.state) for entry in reader.history("S", -1, 100)] == [bits(state) for state in expected]


def test_history_ascends_and_keeps_what_was_received(store: Store) -> None:
    create(store)
    received = ['{"b":1, "a" : 2.50}', '{"text":"ü\\u0000"}', "[" * 40 + "]" * 40]
    kinds: list[HistoryKind] = ["scan", "outcome", "belief"]
    for kind, request in zip(kinds, received, strict=True):
        change(store, "S", write(request=request, kind=kind), next_version)
    entries = store.history("S", -1, 10)
    assert [entry.state.version for entry in entries] == [0, 1, 2, 3]
    assert [entry.kind for entry in entries] == ["prior", *kinds]
    assert [entry.request for entry in entries][1:] == received
    assert [entry.report for entry in entries] == [None, '"report 1"', '"report 2"', '"report 3"']
    assert [entry.state.updated_at for entry in entries] == [NOON + timedelta(seconds=n) for n in range(4)]
    assert {entry.state.created_at for entry in entries} == {NOON}
    newest = store.get_session("S")
    assert newest is not None
    assert (newest.created_at, newest.updated_at) == (NOON, NOON + timedelta(seconds=3))
    assert [entry.state.version for entry in store.history("S", 0, 2)] == [1, 2]
    assert [entry.state.version for entry in store.history("S", 2, 2)] == [3]
    assert store.history("S", 3, 2) == []


def test_a_page_of_a_history_is_bounded_in_bytes_and_goes_on(store: Store) -> None:
    create(store)
    for _ in range(9):
        change(store, "S", write(request='"' + "x" * 998 + '"'), next_version)
    whole = store.history("S", -1, 99)
    for most_bytes, expected in ((1, [1] * 10), (2_500, [4, 3, 3]), (10**9, [10])):
        read: list[int] = []
        pages = []
        while len(read) < len(whole):
            page = store.history("S", read[-1] if read else -1, 99, most_bytes)
            read += [entry.state.version for entry in page]
            pages.append(len(page))
        assert read == [entry.state.version for entry in whole]
        assert pages == expected


def test_lists_show_what_was_stored_with_the_version(store: Store) -> None:
    store.put_scenario(replace(scenario("B"), summary='{"poses": 3}'))
    stored, _ = store.put_object(stored_mesh())
    create(store)
    change(store, "S", write(), lambda state: replace_summary(next_version(state), '{"entropy": 1}'))
    (listed,) = store.list_sessions(9, None).items
    assert (listed.id, listed.version, listed.summary) == ("S", 1, '{"entropy": 1}')
    assert [item.summary for item in store.list_scenarios(9, None).items] == ["{}", '{"poses": 3}']
    (mesh_,) = store.list_objects(9, None).items
    assert mesh_.extents == tuple(stored.object.extents.tolist())
    assert (mesh_.id, mesh_.faces, mesh_.watertight) == (stored.object.digest, 12, stored.object.watertight)


def replace_summary(result: Result, summary: str) -> Result:
    assert result.after is not None
    return result._replace(after=replace(result.after, summary=summary))


def test_histories_of_two_sessions_do_not_mix(store: Store) -> None:
    create(store, "S")
    create(store, "T")
    change(store, "S", write(request='"S"'), next_version)
    change(store, "T", write(request='"T"'), next_version)
    assert [entry.request for entry in store.history("S", 0, 9)] == ['"S"']
    assert [entry.request for entry in store.history("T", 0, 9)] == ['"T"']


# ---------------------------------------------------------------------------------------- keys, versions, steps


def test_a_session_that_does_not_exist_cannot_be_changed(store: Store) -> None:
    def run(*_: object) -> None:
        raise AssertionError("the step must not run")

    with pytest.raises(SessionMissing, match="there is no session 'S'"):
        store.change("S", write(), run)


def test_a_change_without_a_response_is_a_defect_and_changes_nothing(store: Store) -> None:
    create(store)
    with pytest.raises(RuntimeError, match=r"call SessionChange\.respond"):
        store.change("S", write(key()), lambda *_: None)
    assert store.get_response(key()) is None


def test_a_key_seen_before_gets_the_first_answer_and_changes_nothing(store: Store) -> None:
    create(store)
    first = change(store, "S", write(key()), next_version)
    change(store, "S", write(), next_version)
    assert change(store, "S", write(key()), never) == first == StoredResponse("v1", 1)
    assert len(store.history("S", -1, 9)) == 3


def test_a_key_means_one_request(store: Store) -> None:
    create(store)
    change(store, "S", write(key()), next_version)
    with pytest.raises(KeyReused):
        change(store, "S", write(key(fingerprint="G")), never)
    with pytest.raises(KeyReused, match="another request"):
        store.delete_session("S", key(fingerprint="G"), None)
    assert store.get_session("S") is not None


def test_a_key_is_looked_for_before_the_version(store: Store) -> None:
    create(store)
    change(store, "S", write(key(), frozenset({0})), next_version)
    stale = frozenset({0})
    assert change(store, "S", write(key(), stale), never) == StoredResponse("v1", 1)
    with pytest.raises(KeyReused, match="another request"):
        change(store, "S", write(key(fingerprint="G"), stale), never)


def test_a_stale_version_is_refused_before_the_step_and_its_key_stays_free(store: Store) -> None:
    create(store)
    change(store, "S", write(), next_version)
    for seen in (frozenset({0}), frozenset({2, 7}), frozenset[int]()):
        with pytest.raises(VersionMismatch) as refused:
            change(store, "S", write(key(), seen), never)
        assert refused.value.version == 1
    assert change(store, "S", write(key(), frozenset({1, 5})), next_version) == StoredResponse("v2", 2)


def test_a_step_that_refuses_is_answered_and_remembered_and_changes_nothing(store: Store) -> None:
    create(store)
    assert change(store, "S", write(key()), refuse) == StoredResponse("refused at v0", 0)
    change(store, "S", write(), next_version)
    assert change(store, "S", write(key()), never) == StoredResponse("refused at v0", 0)
    assert [entry.state.version for entry in store.history("S", -1, 9)] == [0, 1]


def test_a_step_that_raises_leaves_nothing(store: Store) -> None:
    create(store)
    with pytest.raises(AssertionError, match="must not run"):
        change(store, "S", write(key()), never)
    assert len(store.history("S", -1, 9)) == 1
    assert change(store, "S", write(key()), next_version) == StoredResponse("v1", 1)


def test_keys_are_scoped(store: Store) -> None:
    create(store, "S", key(scope="caller:x"))
    create(store, "T", key(scope="caller:y"))
    for id_ in ("S", "T"):
        named = key(scope=f"session:{id_}")
        assert change(store, id_, write(named), next_version) == StoredResponse("v1", 1)
    assert len(store.list_sessions(9, None).items) == 2


def test_a_session_created_again_under_its_key_is_the_first_one(store: Store) -> None:
    first = create(store, "S", key())
    assert create(store, "T", key()) == first
    with pytest.raises(KeyReused, match="another request"):
        create(store, "U", key(fingerprint="G"))
    assert [item.id for item in store.list_sessions(9, None).items] == ["S"]
    assert store.history("T", -1, 9) == []


# -------------------------------------------------------------------------------------------------------- delete


def test_delete_takes_the_history_along_and_nothing_else(store: Store) -> None:
    create(store, "S")
    create(store, "T")
    for id_ in ("S", "T"):
        change(store, id_, write(), next_version)
    assert store.delete_session("S", None, None)
    assert store.get_session("S") is None
    assert store.history("S", -1, 9) == []
    assert not store.delete_session("S", None, None)
    assert [item.id for item in store.list_sessions(9, None).items] == ["T"]
    assert len(store.history("T", -1, 9)) == 2
    create(store, "S")  # if its history were still there, this could not be
    assert len(store.history("S", -1, 9)) == 1


def test_delete_keeps_the_promises_of_keys_and_versions(store: Store) -> None:
    create(store)
    change(store, "S", write(), next_version)
    with pytest.raises(VersionMismatch, match="the session is at v1"):
        store.delete_session("S", key("D"), frozenset({0}))
    assert store.delete_session("S", key("D"), frozenset({1}))
    assert store.delete_session("S", key("D"), frozenset({0})), "the key is looked for first"
    assert not store.delete_session("S", key("E"), None)


def test_responses_go_with_their_session_but_for_those_that_made_and_deleted_it(store: Store) -> None:
    created = create(store, "S", key(scope="caller"))
    change(store, "S", write(key("K")), next_version)
    change(store, "S", write(key("R")), refuse)
    store.delete_session("S", key("D"), None)
    assert change(store, "S", write(key("K")), never) is None
    assert change(store, "S", write(key("R")), never) is None
    assert store.delete_session("S", key("D"), None)
    with pytest.raises(KeyReused, match="another request"):
        store.delete_session("S", key("D", fingerprint="G"), None)
    assert create(store, "T", key(scope="caller")) == created
    assert store.list_sessions(9, None).items == []


# ------------------------------------------------------------------------------------------- more than one store


def test_everything_is_there_after_reopening(opened: Open, store: Store) -> None:
    store.put_object(stored_mesh())
    create(store, "S", key(scope="caller"))
    change(store, "S", write(key()), next_version)
    store.close()
    again = opened()
    assert again.get_object(mesh().digest) is not None
    assert again.get_scenario("A") == scenario("A")
    assert [entry.state.version for entry in again.history("S", -1, 9)] == [0, 1]
    assert change(again, "S", write(key()), never) == StoredResponse("v1", 1)
    assert create(again, "T", key(scope="caller")) == StoredResponse("created S", 0)


# ------------------------------------------------------------------------------------------------------- looks


def looks_of(store: Store) -> tuple[str | None, list[str | None]]:
    """The record of looks of the session S, and that of each version of its history."""
    state = store.get_session("S")
    assert state is not None
    return state.looks, [entry.state.looks for entry in store.history("S", -1, 99)]


def under_way_of(store: Store) -> str | None:
    state = store.get_session("S")
    assert state is not None
    return state.under_way


def test_each_version_has_its_record_of_looks(pair: tuple[Store, Store]) -> None:
    one, other = pair
    begun = replace(session(), looks="prior")
    one.create_session(begun, write(kind="prior"), StoredResponse("created", 0))
    for looks in ("a", "ü \U0001f916", None, "b" * 100_000):
        change(one, "S", write(), looking(looks))
    expected = ["prior", "a", "ü \U0001f916", None, "b" * 100_000]
    for store in (one, other):
        assert looks_of(store) == (expected[-1], expected)


def test_a_page_of_a_history_counts_the_bytes_of_looks(store: Store) -> None:
    create(store)
    for _ in range(4):
        change(store, "S", write(), looking("x" * 1_000))
    assert len(store.history("S", 0, 99, 2_000)) == 2


def test_announced_looks_make_no_version_and_no_entry(pair: tuple[Store, Store]) -> None:
    one, other = pair
    create(one)
    change(one, "S", write(), looking("record"))
    before, entries = other.get_session("S"), other.history("S", -1, 99)
    assert before is not None
    for under_way in ("first", "ü", None, "last"):
        mark = other.session_mark("S")
        answer = change(one, "S", write(kind="look", request="look"), announcing(under_way))
        assert answer == StoredResponse(f"announced {under_way}", 1)
        after, mark_after = other.get_session("S"), other.session_mark("S")
        assert after is not None
        assert mark_after is not None
        assert (mark_after.under_way, mark_after != mark) == (under_way, True)
        assert bits(after) == bits(before)
        assert (after.version, after.updated_at, after.looks) == (1, before.updated_at, "record")
        assert after.under_way == under_way
    assert [entry.state.version for entry in other.history("S", -1, 99)] == [entry.state.version for entry in entries]


def test_announced_looks_go_on_with_the_next_version_as_the_step_says(store: Store) -> None:
    create(store)
    change(store, "S", write(kind="look"), announcing("first"))
    change(store, "S", write(), next_version)
    assert under_way_of(store) == "first"

    def ends(state: SessionState) -> Result:
        response, after, report = next_version(state)
        assert after is not None
        return Result(response, replace(after, under_way=None), report)

    change(store, "S", write(), ends)
    assert under_way_of(store) is None
    change(store, "S", write(kind="look"), announcing("second"))
    change(store, "S", write(), refuse)
    assert under_way_of(store) == "second"
    assert [entry.state.under_way for entry in store.history("S", -1, 99)] == [None] * 3


def test_an_announcement_is_remembered_by_its_key_and_refused_at_a_stale_version(store: Store) -> None:
    create(store)
    first = change(store, "S", write(key(), kind="look"), announcing("first"))
    assert change(store, "S", write(key(), kind="look"), never) == first
    with pytest.raises(KeyReused):
        change(store, "S", write(key(fingerprint="another"), kind="look"), never)
    with pytest.raises(VersionMismatch):
        change(store, "S", write(if_match=frozenset({1}), kind="look"), never)
    assert change(store, "nothing", write(kind="look"), never) is None
    assert under_way_of(store) == "first"


def test_announcements_at_once_are_all_kept(pair: tuple[Store, Store]) -> None:
    create(pair[0])

    def one_more(state: SessionState) -> Result:
        return announcing((state.under_way or "") + "x")(state)

    at_once([partial(change, store, "S", write(kind="look"), one_more) for store in pair * THREADS])
    assert under_way_of(pair[0]) == "x" * 2 * THREADS
