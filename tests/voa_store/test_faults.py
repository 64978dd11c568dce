"""Bits that a disk has changed in a stored history: verification names each of them."""

from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import select, update

from tests.support.history_damage import try_cells, try_file
from tests.voa_store.samples import change, create, engine_of, looking, next_version, scenario, stored_mesh, write
from voa_service.ports import Store
from voa_store.drivers import sqlite_driver
from voa_store.engines import connect
from voa_store.errors import DamagedData
from voa_store.sql import SqlStore
from voa_store.tables import objects, sessions
from voa_store.verify import verify_all

SHARE, STEP = 0.04, 1499
"""Share of the bytes of all rows, and distance of the bytes of the file; `make chaos` changes all of them."""


def fill(store: Store, versions: int = 4, size: int = 0) -> None:
    store.put_object(stored_mesh())
    for id_ in ("S", "T"):
        create(store, id_)
        for number in range(versions):
            request = f'"{id_}{number}{"x" * size}"'
            change(store, id_, write(request=request), looking(f'{{"since": {10 * number}}}'))


def test_every_flipped_bit_of_a_history_is_named(store: Store, database_url: str) -> None:
    fill(store)
    tried = try_cells(database_url, SHARE)
    assert tried.missed == []
    assert tried.named == tried.tried > 50


def test_a_session_that_the_disk_has_set_back_is_named_and_written_no_more(store: Store, database_url: str) -> None:
    """A page that was not written, although the disk reported it, keeps a row that is right by its own checksum."""
    fill(store)
    engine = engine_of(database_url)
    with engine.begin() as connection:
        (before,) = connection.execute(select(sessions).where(sessions.c.id == "S")).mappings().all()
    change(store, "S", write(), next_version)
    with engine.begin() as connection:
        connection.execute(update(sessions).where(sessions.c.id == "S").values(**before))
    engine.dispose()
    engines = connect(database_url)
    assert [(each.session, each.version) for each in verify_all(engines).damaged] == [("S", before["version"] + 1)]
    engines.dispose()
    with pytest.raises(DamagedData) as refused:
        change(store, "S", write(), next_version)
    assert refused.value.version == before["version"] + 1
    with pytest.raises(DamagedData):
        store.history("S", -1, 99)
    assert change(store, "T", write(), next_version) is not None


def test_a_mesh_that_was_changed_is_named_and_not_returned(store: Store, database_url: str) -> None:
    stored = stored_mesh()
    store.put_object(stored)
    engine = engine_of(database_url)
    with engine.begin() as connection:
        vertices = bytearray(stored.object.vertices.tobytes())
        vertices[11] ^= 4
        connection.execute(update(objects).values(vertices=bytes(vertices)))
    engine.dispose()
    with pytest.raises(DamagedData, match=stored.object.digest):
        store.get_object(stored.object.digest)
    engines = connect(database_url)
    assert verify_all(engines).objects == [stored.object.digest]
    engines.dispose()


def test_a_flipped_bit_of_the_file_is_named_or_changes_no_session(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    store = SqlStore(f"sqlite:///{file}")
    store.put_scenario(scenario("A"))
    fill(store, 20, 1000)  # most pages of a small database are empty
    store.close()
    sqlite_driver().connect(str(file)).execute("PRAGMA wal_checkpoint(TRUNCATE)")
    tried = try_file(file, tmp_path, STEP)
    assert tried.missed == []
    assert tried.named > 20


def test_a_damaged_index_by_which_a_mesh_is_looked_up_is_named(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    store = SqlStore(f"sqlite:///{file}")
    store.put_object(stored_mesh())
    store.close()
    with closing(sqlite_driver().connect(str(file))) as connection:
        ((page,),) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'sqlite_autoindex_objects_1'")
        ((size,),) = connection.execute("PRAGMA page_size")
    content = bytearray(file.read_bytes())
    content[page * size - 1] ^= 1  # the last character of the id in the index
    file.write_bytes(content)
    engines = connect(f"sqlite:///{file}")
    assert verify_all(engines).pages != []
    engines.dispose()
