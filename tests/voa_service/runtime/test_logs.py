"""Logs are one JSON object a line, whichever library logs."""

import io
import json
import logging
from collections.abc import Iterator

import pytest
import structlog

from voa_service.runtime import logs
from voa_service.runtime.logs import reason_of
from voa_store.errors import Unavailable


@pytest.fixture
def stream() -> Iterator[io.StringIO]:
    root = logging.getLogger()
    handlers, level, configured = root.handlers, root.level, structlog.get_config()
    out = io.StringIO()
    logs.configure("INFO", out)
    yield out
    root.handlers = handlers
    root.setLevel(level)
    structlog.configure(**configured)
    structlog.contextvars.clear_contextvars()


def lines(stream: io.StringIO) -> list[dict[str, object]]:
    return [json.loads(line) for line in stream.getvalue().splitlines()]


def test_our_logs_and_those_of_libraries_have_one_form(stream: io.StringIO) -> None:
    structlog.contextvars.bind_contextvars(request_id="r1")
    structlog.get_logger("voa").info("moved", version=3)
    logging.getLogger("uvicorn.error").warning("slow %s", "client")
    ours, theirs = lines(stream)
    assert (ours["event"], ours["version"], ours["level"], ours["request_id"]) == ("moved", 3, "info", "r1")
    assert (theirs["event"], theirs["level"], theirs["logger"]) == ("slow client", "warning", "uvicorn.error")
    assert theirs["request_id"] == "r1"
    assert all(str(line["timestamp"]).endswith("Z") for line in (ours, theirs))


def test_an_exception_with_newlines_stays_on_its_line(stream: io.StringIO) -> None:
    try:
        raise ValueError("two\nlines")
    except ValueError as error:
        structlog.get_logger().exception("unexpected error", exc_info=error)
    (line,) = lines(stream)
    assert "two\nlines" in str(line["exception"])


def test_levels_below_the_configured_one_are_dropped(stream: io.StringIO) -> None:
    structlog.get_logger("voa").debug("quiet")
    logging.getLogger("other").debug("quiet")
    assert lines(stream) == []


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(stream: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> io.StringIO:  # `stream` puts everything back
    monkeypatch.setenv("NO_COLOR", "1")
    out = Terminal()
    logs.configure("INFO", out)
    return out


def test_on_a_terminal_lines_are_for_people(terminal: io.StringIO) -> None:
    structlog.contextvars.bind_contextvars(request_id="r1")
    structlog.get_logger("voa").info("moved", version=3)
    logging.getLogger("uvicorn.error").warning("slow %s", "client")
    ours, theirs = terminal.getvalue().splitlines()
    assert ours.split() == [ours.split()[0], "[info", "]", "moved", "[voa]", "request_id=r1", "version=3"]
    assert "slow client" in theirs
    assert "{" not in terminal.getvalue()


def test_on_a_terminal_an_exception_is_a_traceback(terminal: io.StringIO) -> None:
    try:
        raise ValueError("the secret of the house")
    except ValueError as error:
        structlog.get_logger().exception("unexpected error", exc_info=error)
        logging.getLogger("uvicorn.error").error("theirs", exc_info=error)
    assert terminal.getvalue().count("ValueError: the secret of the house") == 2


def test_colours_are_for_who_wants_them(terminal: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    structlog.get_logger("voa").info("moved")
    assert "\x1b[" not in terminal.getvalue()
    monkeypatch.delenv("NO_COLOR")
    coloured = Terminal()
    logs.configure("INFO", coloured)
    structlog.get_logger("voa").info("moved")
    assert "\x1b[" in coloured.getvalue()


def test_a_database_that_is_away_is_a_reason_without_a_traceback() -> None:
    assert reason_of(Unavailable("the database is away")) == {"why": "the database is away"}
    mistake = KeyError("x")
    assert reason_of(mistake) == {"why": "'x'", "exc_info": mistake}
