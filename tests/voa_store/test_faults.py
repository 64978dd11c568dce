"""Bits that a disk has changed in a stored history: verification names each of them."""

from pathlib import Path

from tests.support.history_damage import try_cells, try_file
from tests.voa_store.samples import change, create, looking, scenario, stored_mesh, write
from voa_service.ports import Store
from voa_store.drivers import sqlite_driver
from voa_store.sql import SqlStore

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
