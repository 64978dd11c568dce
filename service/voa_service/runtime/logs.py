"""Structured logs on stderr, each with the id of the request being served: text on a terminal, else JSON lines."""

import logging
import os
import sys
from typing import Any, TextIO

import structlog

from voa_store.errors import StoreError

_LEVELS = logging.getLevelNamesMapping()


def is_wanted(level: str) -> bool:
    """Return True if lines of a level are logged; callers check first, for composing a line takes time."""
    return logging.getLogger().isEnabledFor(_LEVELS[level])


def reason_of(error: Exception) -> dict[str, object]:
    """Return the fields of a line about an error in the background: with a traceback, unless the store has raised it.

    The store logs its faults itself: a database that is away is no fault of this program.
    """
    return {"why": str(error)} | ({} if isinstance(error, StoreError) else {"exc_info": error})


def logger_of_command(level: str, stream: TextIO) -> Any:
    """Make a logger that writes to a stream as the service does, and leaves the logs of this process as they are.

    Args:
        level: name of the least severe level that is logged, as in `logging`.
        stream: where lines are written.
    """
    return structlog.wrap_logger(
        structlog.PrintLogger(stream),
        wrapper_class=structlog.make_filtering_bound_logger(logging.getLevelNamesMapping().get(level, logging.INFO)),
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            *_renderers(stream),
        ],
    )


def configure(level: str, stream: TextIO = sys.stderr) -> None:
    """Send the logs of the service and of its libraries through one formatter to a stream.

    Args:
        level: name of the least severe level that is logged, as in `logging`.
        stream: where lines are written.
    """
    shared: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        # The first of these drops lines below the level, before they cost more.
        processors=[structlog.stdlib.filter_by_level, *shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        wrapper_class=structlog.stdlib.BoundLogger,
        cache_logger_on_first_use=False,
    )
    handler = logging.StreamHandler(stream)
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=shared,
            processors=[
                structlog.stdlib.ProcessorFormatter.remove_processors_meta,
                *_renderers(stream),
            ],
        )
    )
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(level)
    logging.getLogger("alembic").setLevel(logging.WARNING)  # else every check of /readyz logs two lines


def _renderers(stream: TextIO) -> list[structlog.typing.Processor]:
    """List the processors that write an event: in columns on a terminal, coloured unless NO_COLOR is set; else JSON."""
    if not stream.isatty():
        return [structlog.processors.format_exc_info, structlog.processors.JSONRenderer()]
    return [
        structlog.dev.ConsoleRenderer(
            colors="NO_COLOR" not in os.environ, exception_formatter=structlog.dev.plain_traceback
        )
    ]
