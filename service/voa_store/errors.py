"""Errors of the store: each says what is wrong, and what to do where something can be done; none knows a protocol.

StoreError
|-- SessionMissing      there is no session with this id
|-- VersionMismatch     a write was meant for another version of the session; has `version`
|-- KeyReused           an idempotency key was used for another request before
|-- LookRepeated        the session has accepted a look of this robot under this number
|-- ContentMissing      a scenario or an object that a write needs is not stored
|-- InUse               a scenario or an object cannot be deleted, because something needs it
|-- DamagedData         stored data differs from what was written; has `version`
|-- Unavailable         the database does not work at the moment
|-- Busy                too many calls wait for the database
|-- CannotOpen          the database cannot be opened when the service starts
|   |-- FileInUse       another process has the SQLite file open, and this SQLite must not share it
|   `-- NewerTables     a newer version of the service has changed the tables
"""


class StoreError(Exception):
    """Base class of every error that the store raises on purpose."""


class SessionMissing(StoreError):
    """An id that names no session.

    Args:
        id_: the id.
    """

    def __init__(self, id_: str) -> None:
        super().__init__(f"there is no session {id_!r}")


class VersionMismatch(StoreError):
    """A write that was meant for other versions of the session than the stored one.

    Args:
        expected: the versions that the caller would accept.
        version: the version of the session as stored.
    """

    def __init__(self, expected: frozenset[int], version: int) -> None:
        self.version = version
        versions = ", ".join(f"v{each}" for each in sorted(expected)) or "a version that does not exist"
        super().__init__(
            f"If-Match expects {versions}, the session is at v{version}: read the session again, then decide"
        )


class KeyReused(StoreError):
    """An idempotency key that was used for another request before.

    Args:
        key: the caller's key.
    """

    def __init__(self, key: str) -> None:
        super().__init__(f"Idempotency-Key {key!r} was used for another request: use a new key for each new request")


class ContentMissing(StoreError):
    """A scenario or an object that a write needs, and that was deleted at that moment.

    Args:
        kind: "scenario" or "object".
        id_: of it.
    """

    def __init__(self, kind: str, id_: str) -> None:
        super().__init__(f"there is no {kind} {id_!r}: store it again")


class InUse(StoreError):
    """A scenario or an object that cannot be deleted, because something needs it."""


class LookRepeated(StoreError):
    """A look of a robot whose number the session has counted before.

    Args:
        robot: name of the robot in the mapping.
        number: number of the look.
    """

    def __init__(self, robot: str, number: int) -> None:
        super().__init__(
            f"the session has already counted look {number} of robot {robot!r}: nothing was changed, and nothing needs "
            "to be done"
        )


class DamagedData(StoreError):
    """Stored data that differs from what was written.

    Args:
        message: what is damaged, and what to do.
        version: the first version of a session that is damaged or missing; None: the damage is not in one session.
    """

    def __init__(self, message: str, version: int | None = None) -> None:
        super().__init__(message)
        self.version = version


class Unavailable(StoreError):
    """A database that does not work at the moment: gone, silent, full, or locked by another program."""


class Busy(StoreError):
    """More calls wait for the database than it has connections for."""


class CannotOpen(StoreError):
    """A database that cannot be opened; the message is one line that says what to do.

    Args:
        message: the line.
        may_pass: True where waiting may help, as for a server that has not started yet.
    """

    def __init__(self, message: str, *, may_pass: bool = False) -> None:
        super().__init__(message)
        self.may_pass = may_pass


class FileInUse(CannotOpen):
    """An SQLite file that another process has open, while this SQLite must not share it."""


class NewerTables(CannotOpen):
    """Tables that a newer version of the service has made.

    Args:
        revision: of the database.
        newest: the newest revision that this version of the service knows.
    """

    def __init__(self, revision: str, newest: str) -> None:
        super().__init__(
            f"its tables are of revision {revision}, this version of the service knows revisions up to {newest}: "
            "update the service, or restore a backup"
        )
