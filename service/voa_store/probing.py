"""Tests that the database can be written, by committing a small row as every write must be."""

import os
import secrets

from sqlalchemy import delete, insert

from voa_store.engines import Engines, transaction
from voa_store.tables import probes

_FILLER_BYTES = 16_384
"""Size of the row: about that of a scan of 500 poses, so that a disk too full for a write is too full for this."""
_INSERT = insert(probes)
_DELETE = delete(probes)


class Probe:
    """Writer of a row with random content, so that the database must really write pages.

    Args:
        engines: of the database.
    """

    def __init__(self, engines: Engines) -> None:
        self._engines = engines
        self._replica = secrets.token_hex(8)

    def write(self) -> None:
        """Write a row and remove it again, in two commits; nothing is left behind.

        Raises:
            StoreError: the database cannot be written.
        """
        filler = os.urandom(_FILLER_BYTES)
        with transaction(self._engines.writer) as connection:
            connection.execute(_DELETE.where(probes.c.replica == self._replica))
            connection.execute(_INSERT, {"replica": self._replica, "filler": filler})
        with transaction(self._engines.writer) as connection:
            connection.execute(_DELETE.where(probes.c.replica == self._replica))
