"""Stores meshes, uploaded files and scenarios: content that is named by its digest and never changes.

Content can be deleted as long as nothing needs it. Whoever deletes locks its row, and whoever comes to need it locks it
too, so that neither overlooks the other.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from typing import Any

from sqlalchemy import Connection, Row, Select, Table, bindparam, delete, insert, select
from sqlalchemy.exc import IntegrityError

from voa_store.engines import Engines, statement, transaction
from voa_store.errors import ContentMissing
from voa_store.records import Listed, ListedObject, ListedScenario, StoredObject, StoredScenario, Upload
from voa_store.rows import object_of, scenario_of
from voa_store.summaries import list_objects, list_scenarios, object_summary
from voa_store.tables import objects, scenarios, summaries, uploads
from voa_store.usage import check_object, check_scenario

# Built once, so that SQLAlchemy finds their compiled form in its cache by identity.
_INSERT = {table: insert(table) for table in (objects, scenarios, summaries, uploads)}
_BY_ID = {table: select(table).where(table.c.id == bindparam("by_id")) for table in (objects, scenarios)}
_DELETE = {table: delete(table).where(table.c.id == bindparam("by_id")) for table in (objects, scenarios, summaries)}
_KEPT_OBJECT = select(objects.c.id).where(objects.c.id == bindparam("by_id")).with_for_update(read=True)
_UPLOADED = (
    select(objects)
    .join(uploads, uploads.c.object == objects.c.id)
    .where(*(uploads.c[name] == bindparam(f"by_{name}") for name in ("sha256", "type", "scale", "up")))
)


class Contents:
    """Storage of objects, uploads and scenarios.

    Args:
        engines: of the database.
    """

    def __init__(self, engines: Engines) -> None:
        self._writer, self._single = engines.writer, engines.single

    def put_object(self, stored: StoredObject) -> tuple[StoredObject, bool]:
        """Store a mesh unless an equal one is stored; returns the stored one, and True if it is new."""
        row = {
            "id": stored.object.digest,
            "name": stored.name,
            "created_at": stored.created_at.isoformat(),
            "vertices": stored.object.vertices.astype("<f8").tobytes(),
            "faces": stored.object.faces.astype("<i4").tobytes(),
            "up": stored.up,
        }
        there, new = self._put(objects, row, object_summary(stored.object))
        return object_of(there), new

    def get_object(self, id_: str) -> StoredObject | None:
        """Read the mesh with a digest; None: there is none."""
        row = self._get(objects, id_)
        return None if row is None else object_of(row)

    def list_objects(self, limit: int, after: str | None) -> Listed[ListedObject]:
        """List at most `limit` meshes after a cursor, oldest first."""
        with statement(self._single) as connection:
            return list_objects(connection, limit, after)

    def put_upload(self, upload: Upload, object_: str) -> None:
        """Store that a file became the mesh with the digest `object_`, which is stored already."""
        if self.find_upload(upload) is not None:
            return
        with suppress(IntegrityError), transaction(self._writer) as connection:  # another process was first
            connection.execute(_INSERT[uploads], {**asdict(upload), "object": object_})

    def find_upload(self, upload: Upload) -> StoredObject | None:
        """Find the mesh that a file became when it was uploaded; None: it was never uploaded."""
        with statement(self._single) as connection:
            named = {f"by_{name}": value for name, value in asdict(upload).items()}
            row = connection.execute(_UPLOADED, named).one_or_none()
        return None if row is None else object_of(row)

    def put_scenario(self, stored: StoredScenario) -> tuple[StoredScenario, bool]:
        """Store a scenario unless an equal one is stored; returns the stored one, and True if it is new.

        Raises:
            ContentMissing: its object is not stored.
        """
        row = {"id": stored.id, "name": stored.name, "created_at": stored.created_at.isoformat(), "body": stored.body}
        there, new = self._put(scenarios, row, stored.summary, stored.object)
        return scenario_of(there), new

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """Read the scenario with a digest; None: there is none."""
        row = self._get(scenarios, id_)
        return None if row is None else scenario_of(row)

    def delete_scenario(self, id_: str) -> bool:
        """Delete a scenario; False: there is none.

        Raises:
            InUse: a session is on it.
        """
        return self._delete(scenarios, id_, check_scenario)

    def delete_object(self, id_: str) -> bool:
        """Delete a mesh, and the records of the files that it was read from; False: there is none.

        Raises:
            InUse: a scenario needs it.
        """
        return self._delete(objects, id_, check_object)

    def list_scenarios(self, limit: int, after: str | None) -> Listed[ListedScenario]:
        """List at most `limit` scenarios after a cursor, oldest first."""
        with statement(self._single) as connection:
            return list_scenarios(connection, limit, after)

    def _delete(self, table: Table, id_: str, check: Callable[[Connection, str], None]) -> bool:
        """Delete content that is locked and not in use; False: there is none."""
        with transaction(self._writer) as connection:
            if named_row(connection, _BY_ID[table].with_for_update(), id_) is None:
                return False
            check(connection, id_)
            for each in (summaries, table):
                connection.execute(_DELETE[each], {"by_id": id_})
        return True

    def _put(
        self, table: Table, row: dict[str, Any], summary: str, object_: str | None = None
    ) -> tuple[Row[Any], bool]:
        """Insert a row that is named by its content unless it exists; returns the stored row, and True if it is new.

        Args:
            table: objects or scenarios.
            row: to be inserted.
            summary: of the row.
            object_: digest of a mesh that must be stored, and stays until the end of the transaction; None: none.
        """
        named = {"by_id": row["id"]}
        try:
            with transaction(self._writer) as connection:
                there = connection.execute(_BY_ID[table], named).one_or_none()
                if there is not None:
                    return there, False
                if object_ is not None and connection.execute(_KEPT_OBJECT, {"by_id": object_}).one_or_none() is None:
                    raise ContentMissing("object", object_)
                connection.execute(_INSERT[table], row)
                connection.execute(_INSERT[summaries], {"id": row["id"], "summary": summary})
                return connection.execute(_BY_ID[table], named).one(), True
        except IntegrityError:  # another process stored the same content at the same instant
            with statement(self._single) as connection:
                return connection.execute(_BY_ID[table], named).one(), False

    def _get(self, table: Table, id_: str) -> Row[Any] | None:
        with statement(self._single) as connection:
            return named_row(connection, _BY_ID[table], id_)


def named_row(connection: Connection, query: Select[Any], id_: str) -> Row[Any] | None:
    """Read the row with an id; None: there is none. PostgreSQL cannot store a NUL in a text, so no id contains one."""
    return None if "\0" in id_ else connection.execute(query, {"by_id": id_}).one_or_none()
