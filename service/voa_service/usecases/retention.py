"""Retention: removes whole sessions that have not moved for long, and old responses to keyed calls."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta

import structlog

from voa_service.ports import Store
from voa_service.runtime.steady import SteadyClock
from voa_store.errors import VersionMismatch

_PAGE = 500


@dataclass(frozen=True)
class Retention:
    """Use case of removing what is old.

    Attributes:
        store: of the sessions.
        delete: deletes a session if it still has a version, with its history and responses; True if it did.
        clock: by which ages are measured.
        session_days: age of a session's newest version, in days, from which it is removed; None: sessions stay.
        response_days: age of a stored response from which it is removed.
    """

    store: Store
    delete: Callable[[str, int], bool]
    clock: SteadyClock
    session_days: float | None
    response_days: float

    def apply(self, pause: Callable[[float], object]) -> int:
        """Remove what is old by now; returns the number of removed sessions.

        Args:
            pause: sleeps for so many seconds between two transactions; returns true to end early.

        Raises:
            StoreError: the database does not work at the moment.
        """
        # The store dates responses by the wall clock.
        keep_s = timedelta(days=self.response_days).total_seconds() + self.clock.behind_s()
        self.store.forget_responses(keep_s, pause)
        if self.session_days is None:
            return 0
        removed = self._remove(self.clock.now() - timedelta(days=self.session_days), pause)
        if removed:
            log = structlog.get_logger("voa")
            log.info("old sessions removed", sessions=removed, older_than_days=self.session_days)
        return removed

    def _remove(self, before: datetime, pause: Callable[[float], object]) -> int:
        """Remove the sessions whose newest version is older than `before`."""
        removed, after = 0, None
        while True:
            page = self.store.list_sessions(_PAGE, after)
            for session in page.items:
                if session.updated_at < before and self._is_removed(session.id, session.version):
                    removed += 1
            after = page.next
            if after is None or pause(0.0):
                return removed

    def _is_removed(self, id_: str, version: int) -> bool:
        try:
            return self.delete(id_, version)
        except VersionMismatch:  # it has moved meanwhile
            return False
