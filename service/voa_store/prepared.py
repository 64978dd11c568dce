"""Statements of writes as text for the driver: SQLAlchemy would take longer to prepare them than to send them."""

from collections.abc import Sequence

from sqlalchemy import Connection, Dialect, Insert, Update
from sqlalchemy.sql.compiler import SQLCompiler

from voa_store.rows import Columns


class Prepared:
    """An insertion or a change of rows, compiled once.

    Values go to the driver as they are: texts, numbers, bytes and None.

    Args:
        statement: inserts or changes rows.
        columns: names of the values of each row, those of the statement's own parameters included.
        dialect: of the database.
    """

    def __init__(self, statement: Insert | Update, columns: Sequence[str], dialect: Dialect) -> None:
        compiled: SQLCompiler = statement.compile(dialect=dialect, column_keys=list(columns))
        self._text = str(compiled)
        self._order = compiled.positiontup

    def execute(self, connection: Connection, rows: Sequence[Columns]) -> None:
        """Execute the statement for each of some rows; raises what `Connection.execute` does."""
        order = self._order
        sent = [row if order is None else tuple(row[name] for name in order) for row in rows]
        connection.exec_driver_sql(self._text, sent)
