"""Logs on stderr with the request id of whatever is being served: for people on a terminal, else JSON.

In JSON each line is one object.
"""

import logging
import os
import sys
from typing import TextIO

import structlog


def is_wanted(level: str) -> bool:
    """Whether anybody reads lines of that level: to put one together costs as much as a small answer."""
    return logging.getLogger().isEnabledFor(logging.getLevelNamesMapping()[level])


def configure(level: str, stream: TextIO = sys.stderr) -> None:
    """Send the service's and its libraries' logs through one formatter."""
    shared: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        # What nobody wants to read costs nothing but the first of these.
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
    logging.getLogger("alembic").setLevel(logging.WARNING)  # else two lines whenever anybody asks for /readyz


def _renderers(stream: TextIO) -> list[structlog.typing.Processor]:
    """Give what turns an event into text: aligned and, unless NO_COLOR is set, coloured on a terminal; else JSON."""
    if not stream.isatty():
        return [structlog.processors.format_exc_info, structlog.processors.JSONRenderer()]
    return [
        structlog.dev.ConsoleRenderer(
            colors="NO_COLOR" not in os.environ, exception_formatter=structlog.dev.plain_traceback
        )
    ]
