"""JSON logs, one object a line on stderr, with the request id of whatever is being served."""

import logging
import sys
from typing import TextIO

import structlog


def is_wanted(level: str) -> bool:
    """Whether anybody reads lines of that level: to put one together costs as much as a small answer."""
    return logging.getLogger().isEnabledFor(logging.getLevelNamesMapping()[level])


def configure(level: str, stream: TextIO = sys.stderr) -> None:
    """Send the service's and its libraries' logs through one JSON formatter."""
    shared: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        structlog.processors.format_exc_info,
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
                structlog.processors.JSONRenderer(),
            ],
        )
    )
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(level)
    logging.getLogger("alembic").setLevel(logging.WARNING)  # else two lines whenever anybody asks for /readyz
