"""A line in the log for each write; tests/voa_service/http/test_authentication.py has the lines of real calls."""

import pytest
from structlog.testing import capture_logs

from voa_service.access import audit
from voa_service.access.callers import Caller


def test_a_line_has_who_what_and_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit, "is_wanted", lambda _: True)
    with capture_logs() as lines:
        audit.record_write(Caller("tb3_1", "sensor", "0123"), "scan.put", 200, session="s", robot="tb3_1", version=4)
        audit.record_write(None, "session.delete", 401, session="s")
    assert lines == [
        {
            "event": "audit",
            "log_level": "info",
            "caller": "tb3_1",
            "key": "0123",
            "call": "scan.put",
            "session": "s",
            "robot": "tb3_1",
            "version": 4,
            "result": 200,
        },
        {
            "event": "audit",
            "log_level": "info",
            "caller": "unknown",
            "key": None,
            "call": "session.delete",
            "session": "s",
            "robot": None,
            "version": None,
            "result": 401,
        },
    ]


def test_nothing_is_composed_where_nothing_is_logged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit, "is_wanted", lambda _: False)
    with capture_logs() as lines:
        audit.record_write(None, "session.delete", 401)
    assert lines == []
