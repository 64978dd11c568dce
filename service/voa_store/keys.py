"""Reads and writes API keys: their digests, names and roles. A key's row is never removed."""

import json
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from sqlalchemy import Engine, Row, bindparam, insert, or_, select, update

from voa_store.engines import connect, statement, transaction
from voa_store.migrate import migrate
from voa_store.records import StoredKey
from voa_store.tables import api_keys

_ALL = select(api_keys).order_by(api_keys.c.created_at, api_keys.c.id)
_INSERT = insert(api_keys)
_REVOKE = update(api_keys).where(api_keys.c.id == bindparam("by_id"), api_keys.c.revoked_at.is_(None))
_USED = update(api_keys).where(
    api_keys.c.id == bindparam("by_id"),
    or_(api_keys.c.last_used_at.is_(None), api_keys.c.last_used_at < bindparam("at")),
)
_TIMES = ("created_at", "expires_at", "revoked_at", "last_used_at")


class KeyRecords:
    """Storage of API keys, on the engines of the store that inherits it."""

    _writer: Engine
    _single: Engine

    def put_key(self, key: StoredKey) -> None:
        """Store a new key, durably; its id must be new."""
        with transaction(self._writer) as connection:
            connection.execute(_INSERT, _columns(key))

    def list_keys(self) -> list[StoredKey]:
        """List every key that was ever made, revoked and expired ones too, oldest first."""
        with statement(self._single) as connection:
            return [_key(row) for row in connection.execute(_ALL)]

    def revoke_key(self, id_: str, at: datetime) -> bool:
        """Revoke a key for good; False where there is none of this id, or it was revoked before."""
        with transaction(self._writer) as connection:
            return connection.execute(_REVOKE, {"by_id": id_, "revoked_at": at.isoformat()}).rowcount == 1

    def keys_used(self, used: Mapping[str, datetime]) -> None:
        """Store when keys were last used, by their ids; of several processes, the newest time stays."""
        rows = [{"by_id": id_, "at": at.isoformat()} for id_, at in sorted(used.items())]
        with transaction(self._writer) as connection:
            connection.execute(_USED.values(last_used_at=bindparam("at")), rows)


class KeyStore(KeyRecords):
    """Storage of API keys alone, for the command that makes them, also while the service runs.

    Args:
        url: of the database; its tables are made or migrated.
        patience_s: seconds for which PostgreSQL may be silent before a call fails.

    Raises:
        StoreError: the database cannot be used; `starting.open_keys` explains errors of drivers too.
    """

    def __init__(self, url: str, patience_s: float) -> None:
        self._engines = connect(url, patience_s)
        self._writer, self._single = self._engines.writer, self._engines.single
        try:
            migrate(self._engines)
        except BaseException:
            self._engines.dispose()
            raise

    def close(self) -> None:
        """Close all connections."""
        self._engines.dispose()


def _columns(key: StoredKey) -> dict[str, Any]:
    columns = {name: getattr(key, name) for name in ("id", "digest", "name", "role")}
    columns |= {name: _listed(getattr(key, name)) for name in ("sessions", "robots")}
    return columns | {name: None if (at := getattr(key, name)) is None else at.isoformat() for name in _TIMES}


def _listed(names: tuple[str, ...] | None) -> str | None:
    return None if names is None else json.dumps(names)


def _key(row: Row[Any]) -> StoredKey:
    fields = dict(row._mapping)
    for name in ("sessions", "robots"):
        fields[name] = None if fields[name] is None else tuple(json.loads(fields[name]))
    for name in _TIMES:
        fields[name] = None if fields[name] is None else datetime.fromisoformat(fields[name])
    return StoredKey(**fields | {"digest": bytes(fields["digest"])})
