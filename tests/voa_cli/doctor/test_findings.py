"""The checklist as it is printed, and the time that its checks may take."""

import threading
from io import StringIO

import pytest
from rich.console import Console

from voa_cli.doctor.findings import Budget, Finding, TookTooLong, checklist
from voa_cli.doctor.over_http import clocks


def test_what_was_seen_is_printed_as_it_is_whatever_its_length() -> None:
    console = Console(width=60, record=True, file=StringIO())
    console.print(checklist([Finding("check", "wrong", "[x] " + "a" * 200, "[/y]")]))
    printed = console.export_text()
    assert (printed.count("a"), "[x]" in printed, "[/y]" in printed) == (202, True, True)


def test_a_clock_is_only_blamed_beyond_what_can_be_told() -> None:
    assert clocks("clock", 0.3, 0.25).state == "ok"
    assert clocks("clock", -0.3, 0.1).state == "warning"


def test_work_that_hangs_is_left_behind() -> None:
    with pytest.raises(TookTooLong):
        Budget(60.0).within(0.05, threading.Event().wait)
    assert Budget(60.0).within(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        Budget(60.0).within(5.0, lambda: 1 // 0)
    assert Budget(0.0).step(5.0) <= 0.05
