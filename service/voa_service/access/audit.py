"""The audit: a line in the log for each write, and for each key that is made or revoked, with who did it."""

from typing import Any, Literal

import structlog

from voa_service.access.callers import Caller
from voa_service.runtime.logs import is_wanted
from voa_store.records import StoredKey


def is_recorded() -> bool:
    """True if the log takes lines of the audit, which have level INFO."""
    return is_wanted("INFO")


def record_write(
    caller: Caller | None,
    call: str,
    result: int,
    *,
    session: str | None = None,
    robot: str | None = None,
    version: int | None = None,
) -> None:
    """Log a write, made or refused; nothing where lines of level INFO are not logged.

    Args:
        caller: that made it; None: it has no valid key.
        call: name of the call.
        result: status of the response.
        session: id of the session that it concerns; None: none, or not known.
        robot: name of the robot that it concerns; None: none, or not known.
        version: of the session afterwards; None: none, or not known.
    """
    if not is_recorded():
        return
    structlog.get_logger().info(
        "audit",
        caller="unknown" if caller is None else caller.name,
        key=None if caller is None else caller.key,
        call=call,
        session=session,
        robot=robot,
        version=version,
        result=result,
    )


def record_key(done: Literal["key.create", "key.revoke"], key: StoredKey, by: str, log: Any = None) -> None:
    """Log that a key was made or revoked.

    Args:
        done: name of the change.
        key: that was made or revoked.
        by: who did it, as far as it is known.
        log: logger of a command; None: that of the service, where lines of level INFO are logged.
    """
    if log is None:
        if not is_recorded():
            return
        log = structlog.get_logger()
    bound = {"sessions": key.sessions, "robots": key.robots}
    log.info("audit", caller=by, call=done, key=key.id, name=key.name, role=key.role, **bound, result=200)
