"""The audit: a line in the log for each write, with who made it and what came of it."""

import structlog

from voa_service.access.callers import Caller
from voa_service.runtime.logs import is_wanted


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
    if not is_wanted("INFO"):
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
