"""The checklist as it is printed, and the time that its checks may take."""

import threading
from io import StringIO

import pytest
from rich.console import Console

from voa_cli.doctor.findings import Budget, Finding, State, TookTooLong, checklist, verdict
from voa_cli.doctor.over_http import clocks


def test_what_was_seen_is_printed_as_it_is_whatever_its_length() -> None:
    console = Console(width=60, record=True, file=StringIO())
    console.print(checklist([Finding("check", "wrong", "[x] " + "a" * 200, "[/y]")]))
    printed = console.export_text()
    assert (printed.count("a"), "[x]" in printed, "[/y]" in printed) == (200, True, True)


@pytest.mark.parametrize("columns", [60, 80])
def test_the_list_is_as_wide_as_the_terminal_and_no_word_is_cut(columns: int) -> None:
    result = Finding("robot tb3_1", "wrong", "angle_min and lidar.upside_down " * 20, "correct the_mapping " * 10)
    console = Console(width=columns, record=True, file=StringIO())
    console.print(checklist([result, Finding("clock", "ok", "0.002 s ahead of ours")]))
    lines = [line.rstrip() for line in console.export_text().splitlines()]
    assert all(len(line) <= columns for line in lines)
    assert (lines[0].startswith("✗ robot tb3_1: angle_min"), lines[-1]) == (True, "✓ clock: 0.002 s ahead of ours")
    assert [line for line in lines if line.startswith("    -> correct the_mapping")]
    words = " ".join(lines).split()
    assert (words.count("lidar.upside_down"), words.count("the_mapping")) == (20, 10)


@pytest.mark.parametrize(
    ("states", "says"),
    [
        ("wow", "2 wrong, no warnings"),
        ("", "nothing wrong, no warnings"),
        ("oa", "nothing wrong, 1 warning"),
        ("waa", "1 wrong, 2 warnings"),
    ],
)
def test_the_last_line_counts(states: str, says: str) -> None:
    known: dict[str, State] = {"w": "wrong", "o": "ok", "a": "warning"}
    assert verdict([Finding("check", known[state], "seen") for state in states]) == says


def test_a_clock_is_only_blamed_beyond_the_uncertainty() -> None:
    assert clocks("clock", 0.3, 0.25).state == "ok"
    assert clocks("clock", -0.3, 0.1).state == "warning"


def test_work_that_hangs_is_left_behind() -> None:
    with pytest.raises(TookTooLong):
        Budget(60.0).within(0.05, threading.Event().wait)
    assert Budget(60.0).within(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        Budget(60.0).within(5.0, lambda: 1 // 0)
    assert Budget(0.0).step(5.0) <= 0.05
