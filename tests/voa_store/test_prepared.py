"""Prepared statements write the rows that SQLAlchemy would, on both databases, and fail as it does."""

from typing import Any

import pytest
from sqlalchemy import bindparam, insert, select, update
from sqlalchemy.exc import IntegrityError

from voa_store.engines import connect, transaction
from voa_store.prepared import Prepared
from voa_store.tables import metadata, probes, responses

ROWS: list[dict[str, Any]] = [
    {"scope": "a", "key": "k%s", "fingerprint": "f", "body": "ä \x7f", "version": -1, "at": 2**40},
    {"scope": "b", "key": ":k ?", "fingerprint": "f", "body": "", "version": 0, "at": None},
]


def test_rows_are_written_and_changed_as_they_are(database_url: str) -> None:
    engines = connect(database_url)
    metadata.create_all(engines.writer)
    dialect = engines.writer.dialect
    add = Prepared(insert(responses), responses.columns.keys(), dialect)
    move = Prepared(update(responses).where(responses.c.scope == bindparam("by_scope")), ("by_scope", "body"), dialect)
    fill = Prepared(insert(probes), ("replica", "filler"), dialect)
    with transaction(engines.writer) as connection:
        add.execute(connection, ROWS)
        move.execute(connection, [{"by_scope": "b", "body": "%(body)s"}, {"by_scope": "nobody", "body": ""}])
        fill.execute(connection, [{"replica": "r", "filler": bytes(range(256))}])
    with transaction(engines.readers) as connection:
        stored = [dict(row._mapping) for row in connection.execute(select(responses).order_by(responses.c.scope))]
        assert stored == [ROWS[0], ROWS[1] | {"body": "%(body)s"}]
        assert connection.execute(select(probes.c.filler)).scalar_one() == bytes(range(256))
    with pytest.raises(IntegrityError), transaction(engines.writer) as connection:
        add.execute(connection, ROWS[:1])
    engines.dispose()
