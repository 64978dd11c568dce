"""Scenarios and meshes can be deleted as long as nothing needs them, also while somebody comes to need them."""

from dataclasses import replace

import pytest

from tests.support.waiting import wait_for
from tests.voa_store.samples import at_once, create, mesh, scenario, stored_mesh, upload
from voa_service.ports import Store
from voa_store.errors import ContentMissing, InUse, StoreError
from voa_store.records import StoredScenario

OBJECT = mesh().digest


def of_object(id_: str = "B") -> StoredScenario:
    return replace(scenario(id_, "of a box"), summary=f'{{"object": "{OBJECT}"}}', object=OBJECT)


def test_a_scenario_is_deleted_once_no_session_is_on_it(store: Store) -> None:
    create(store, "S")
    with pytest.raises(InUse, match=r"sessions are on this scenario \(S\)"):
        store.delete_scenario("A")
    store.delete_session("S", None, None)
    wait_for(lambda: deleted(store, "A"), "the rows of the session to go")
    assert store.get_scenario("A") is None
    assert store.list_scenarios(9, None).items == []
    assert not store.delete_scenario("A")
    with pytest.raises(ContentMissing, match="there is no scenario 'A'"):
        create(store, "T")
    assert store.put_scenario(scenario("A"))[1], "it can be stored again"


def deleted(store: Store, id_: str) -> bool:
    try:
        return store.delete_scenario(id_)
    except InUse:
        return False


def test_a_mesh_is_deleted_with_its_files_once_no_scenario_needs_it(store: Store) -> None:
    store.put_object(stored_mesh())
    store.put_upload(upload(), OBJECT)
    store.put_scenario(of_object())
    with pytest.raises(InUse, match=r"scenarios need this object \('of a box' \(B\)\): delete them first"):
        store.delete_object(OBJECT)
    assert store.delete_scenario("B")
    assert store.delete_object(OBJECT)
    assert store.get_object(OBJECT) is None
    assert store.find_upload(upload()) is None
    assert store.list_objects(9, None).items == []
    assert not store.delete_object(OBJECT)
    with pytest.raises(ContentMissing, match="there is no object"):
        store.put_scenario(of_object())


def test_nobody_overlooks_the_other(pair: tuple[Store, Store]) -> None:
    one, other = pair
    for number in range(20):
        one.put_object(stored_mesh())
        name = f"B{number}"

        def storing(id_: str = name) -> str:
            try:
                one.put_scenario(of_object(id_))
            except ContentMissing:
                return "missing"
            return "stored"

        def deleting() -> str:
            try:
                other.delete_object(OBJECT)
            except InUse:
                return "in use"
            return "deleted"

        outcome = set(at_once([storing, deleting]))
        assert outcome in ({"stored", "in use"}, {"missing", "deleted"})
        assert (one.get_object(OBJECT) is None) == ("deleted" in outcome)
        if "stored" in outcome:
            assert one.delete_scenario(name)


def test_a_session_and_the_deletion_of_its_scenario_exclude_each_other(pair: tuple[Store, Store]) -> None:
    one, other = pair
    for number in range(20):
        one.put_scenario(scenario("A"))
        name = f"S{number}"

        def opening(id_: str = name) -> str:
            try:
                create(one, id_)
            except ContentMissing:
                return "missing"
            return "opened"

        def deleting() -> str:
            try:
                other.delete_scenario("A")
            except StoreError:
                return "in use"
            return "deleted"

        outcome = set(at_once([opening, deleting]))
        assert outcome in ({"opened", "in use"}, {"missing", "deleted"})
        one.delete_session(name, None, None)
