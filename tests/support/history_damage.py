"""Damages a stored history by one bit at a time, and tries whether verification names the damage."""

import random
import struct
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import Column, Table, and_, select, update
from sqlalchemy.exc import IntegrityError

from voa_store.drivers import sqlite_driver
from voa_store.engines import Engines, connect
from voa_store.tables import history, objects, sessions
from voa_store.verify import verify_all

KEYS = {history: ("session", "version"), sessions: ("id",), objects: ("id",)}
UNCHECKED = {"under_way", "seq", "name", "created_at of objects", "up"}
"""Columns that no checksum covers: announced looks, the order of lists, and the label and date of meshes."""


@dataclass(frozen=True)
class Cell:
    """Value of one column of one row.

    Attributes:
        table: of the row.
        key: values of the row's key.
        column: name of the column.
        value: as it was written.
    """

    table: Table
    key: tuple[Any, ...]
    column: str
    value: Any

    @property
    def bytes(self) -> bytes:
        """Value as bytes, of which each can be changed."""
        match self.value:
            case bytes():
                return self.value
            case str():
                return self.value.encode()
            case int():
                return struct.pack("<i", self.value)
            case float():
                return struct.pack("<d", self.value)
        return b""

    def with_flipped_bit(self, byte: int, bit: int) -> Any:
        """Return the value with one bit changed; a text stays one that every database can store."""
        changed = bytearray(self.bytes)
        changed[byte] ^= 1 << bit
        match self.value:
            case bytes():
                return bytes(changed)
            case str():
                # The highest bit would make it no UTF-8; the files of SQLite are damaged by `try_file`.
                flips = [changed[byte] ^ (1 << bit) ^ (1 << other) for other in (bit, *range(7)) if other < 7]
                changed[byte] = next(each for each in flips if each)
                return changed.decode()
            case int():
                return struct.unpack("<i", changed)[0]
        return struct.unpack("<d", changed)[0]


@dataclass
class Tried:
    """Result of damaging a history in many ways.

    Attributes:
        tried: number of bits that were changed, one at a time.
        named: number of these that verification named.
        harmless: number of these that changed no row of a session, its history, or an object.
        missed: descriptions of the others.
    """

    tried: int = 0
    named: int = 0
    harmless: int = 0
    missed: list[str] = field(default_factory=list)


def cells(engines: Engines, tables: Sequence[Table] = (history, sessions, objects)) -> Iterator[Cell]:
    """List every value of histories, sessions and objects that is covered by a checksum or digest."""
    with engines.readers.begin() as connection:
        for table in tables:
            for row in connection.execute(select(table)).mappings().all():
                key = tuple(row[name] for name in KEYS[table])
                for column in table.columns:
                    if row[column.name] is not None and _is_checked(table, column):
                        yield Cell(table, key, column.name, row[column.name])


def _is_checked(table: Table, column: Column[Any]) -> bool:
    return column.name not in UNCHECKED and f"{column.name} of {table.name}" not in UNCHECKED


def try_cells(url: str, share: float, seed: int = 0) -> Tried:
    """Change a bit of a share of all bytes of all cells, one at a time, and verify the database after each.

    Args:
        url: of a database with few sessions.
        share: of the bytes; 1: all.
        seed: of the choice of bytes and bits.
    """
    rng, tried = random.Random(seed), Tried()  # noqa: S311 - not a secret
    engines = connect(url)
    try:
        assert verify_all(engines).well
        for cell in list(cells(engines)):
            for byte in range(len(cell.bytes)):
                if rng.random() >= share:
                    continue
                bit = rng.randrange(8)
                changed = cell.with_flipped_bit(byte, bit)
                named = _is_named(engines, cell, changed)
                tried.tried += named is not None
                tried.named += named is True
                if named is False:
                    tried.missed.append(f"{cell.table.name} {cell.key} {cell.column}, byte {byte}, bit {bit}")
        assert verify_all(engines).well, "every change is undone"
    finally:
        engines.dispose()
    return tried


def _is_named(engines: Engines, cell: Cell, changed: Any) -> bool | None:
    """Change a cell, verify, and change it back; None: another row has that key already."""
    keys = KEYS[cell.table]
    moved = tuple(changed if name == cell.column else value for name, value in zip(keys, cell.key, strict=True))
    try:
        _put(engines, cell.table, cell.key, cell.column, changed)
    except IntegrityError:
        return None
    try:
        return not verify_all(engines).well
    finally:
        _put(engines, cell.table, moved, cell.column, cell.value)


def _put(engines: Engines, table: Table, key: tuple[Any, ...], column: str, value: Any) -> None:
    where = and_(*(table.c[name] == each for name, each in zip(KEYS[table], key, strict=True)))
    with engines.single.connect() as connection:
        if connection.dialect.name == "sqlite":
            connection.exec_driver_sql("PRAGMA foreign_keys=OFF")
        else:
            connection.exec_driver_sql("SET session_replication_role = replica")
        done = connection.execute(update(table).where(where).values({column: value}))
        assert done.rowcount == 1
        if connection.dialect.name == "sqlite":
            connection.exec_driver_sql("PRAGMA foreign_keys=ON")
        else:
            connection.exec_driver_sql("SET session_replication_role = origin")


def try_file(file: Path, folder: Path, step: int, seed: int = 0) -> Tried:
    """Change a bit of every so many bytes of an SQLite file, one at a time in a copy, and verify each copy.

    Args:
        file: that no process has open.
        folder: for the copies.
        step: distance between the bytes; 1: every byte.
        seed: of the choice of bits.
    """
    rng, tried, content = random.Random(seed), Tried(), file.read_bytes()  # noqa: S311 - not a secret
    original = _rows(file)
    for byte in range(rng.randrange(step), len(content), step):
        changed = bytearray(content)
        changed[byte] ^= 1 << rng.randrange(8)
        copy = folder / "damaged.db"
        copy.write_bytes(changed)
        tried.tried += 1
        if not _is_well(copy):
            tried.named += 1
        elif _rows(copy) == original:
            tried.harmless += 1
        else:
            tried.missed.append(f"byte {byte}, in page {byte // 4096 + 1}")
        for left in folder.glob("damaged.db*"):
            left.unlink()
    return tried


def _is_well(file: Path) -> bool:
    engines = connect(f"sqlite:///{file}")
    try:
        return verify_all(engines).well
    except Exception:  # whatever it is: the program names it, and ends with 2
        return False
    finally:
        engines.dispose()


def _rows(file: Path) -> list[Any] | None:
    """Read all rows that checksums cover; None: they cannot be read."""
    with closing(sqlite_driver().connect(str(file))) as connection:
        try:
            return [connection.execute(query).fetchall() for query in map(_query, KEYS)]
        except sqlite_driver().Error:
            return None


def _query(table: Table) -> str:
    names = ", ".join(column.name for column in table.columns if _is_checked(table, column))
    return f"SELECT {names} FROM {table.name} ORDER BY {', '.join(KEYS[table])}"  # noqa: S608 - our own names
