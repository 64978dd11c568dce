"""Whether the database can be written: a small row, written and committed, as every answered write must be."""

import os
import secrets

from sqlalchemy import delete, insert

from voa_store.engines import Engines, transaction
from voa_store.tables import probes

_FILLER_BYTES = 16_384
"""About a scan of 500 poses: a disk with no room for a write has none for this either."""
_INSERT = insert(probes)
_DELETE = delete(probes)


class Probe:
    """Writes one row per process, another one each time, so that pages must really be written."""

    def __init__(self, engines: Engines) -> None:
        self._engines = engines
        self._replica = secrets.token_hex(8)

    def write(self) -> None:
        """Write a row and remove it again, in two commits: what is left behind is nothing.

        Raises:
            Failure: the database cannot be written.
        """
        filler = os.urandom(_FILLER_BYTES)
        with transaction(self._engines.writer) as connection:
            connection.execute(_DELETE.where(probes.c.replica == self._replica))
            connection.execute(_INSERT, {"replica": self._replica, "filler": filler})
        with transaction(self._engines.writer) as connection:
            connection.execute(_DELETE.where(probes.c.replica == self._replica))
