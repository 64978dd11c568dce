"""Lines of the audit that a service of this process logs."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from structlog.testing import capture_logs


class Audit:
    """Lines of the audit so far.

    Args:
        lines: of the log.
    """

    def __init__(self, lines: list[Any]) -> None:
        self._lines = lines

    def of(self, call: str, *fields: str) -> list[tuple[Any, ...]]:
        """List fields of the lines about a call, `caller` and `result` unless others are named."""
        lines = [line for line in list(self._lines) if line["event"] == "audit" and line["call"] == call]
        return [tuple(line[name] for name in fields or ("caller", "result")) for line in lines]


@contextmanager
def audited() -> Iterator[Audit]:
    """Keep the lines of the audit within a `with` block, whatever the level of the log."""
    with pytest.MonkeyPatch.context() as patch, capture_logs() as lines:
        patch.setattr("voa_service.access.audit.is_wanted", lambda _: True)
        yield Audit(lines)
