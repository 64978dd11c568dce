"""The start of the service while its database may not be there yet."""

import time
from collections.abc import Callable
from contextlib import ExitStack

import structlog
from sqlalchemy import make_url
from sqlalchemy.exc import OperationalError

from voa_service import bootstrap
from voa_service.services import Services
from voa_service.settings import Settings

_AGAIN_SECONDS = 0.5
_UNREACHABLE = (OperationalError, OSError)


class NoDatabase(Exception):
    """The database cannot be reached; the message is one line."""


def shown(database_url: str) -> str:
    """Write the URL of a database without its password."""
    return make_url(database_url).render_as_string(hide_password=True)


def services_when_reachable(
    stack: ExitStack, settings: Settings, sleep: Callable[[float], object] = time.sleep
) -> Services:
    """Build the service as soon as its database can be reached.

    Args:
        stack: releases the service when it is left.
        settings: how long to try.
        sleep: between two tries, in seconds.

    Raises:
        NoDatabase: it could not be reached for `settings.wait_for_database` seconds.
    """
    end = time.monotonic() + settings.wait_for_database
    tried = False
    while True:
        try:
            return stack.enter_context(bootstrap.services(settings))
        except _UNREACHABLE as error:
            why = _one_line(error)
            left = end - time.monotonic()
            if left <= 0:
                hint = "" if tried else "; --wait-for-database SECONDS tries again"
                raise NoDatabase(f"cannot open the database {shown(settings.database_url)}: {why}{hint}") from error
            if not tried:
                structlog.get_logger("voa").warning(
                    "waiting for the database",
                    database=shown(settings.database_url),
                    seconds=settings.wait_for_database,
                    error=why,
                )
            tried = True
            sleep(min(_AGAIN_SECONDS, left))


def _one_line(error: Exception) -> str:
    cause = getattr(error, "orig", None) or error
    return " ".join(str(cause).split())
