"""`voa doctor` as it is typed and printed; its checks are tested in tests/voa_doctor."""

from collections.abc import Iterator
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from tests.support.routers import Router, router
from tests.voa_cli.labs import service_on
from voa_cli.doctor import checklist, verdict
from voa_cli.main import main
from voa_doctor.findings import Finding, State


@pytest.fixture
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


def test_a_person_reads_a_list(capsys: pytest.CaptureFixture[str], own_router: Router, tmp_path: Path) -> None:
    with service_on(own_router, tmp_path) as lab:
        assert main(["doctor", "--url", lab.url, "--zenoh", lab.endpoint]) == 0
    out = capsys.readouterr().out
    assert "✓" in out
    assert "✗" not in out
    assert "nothing wrong" in out.splitlines()[-1]


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


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        (["--zenoh", "gopher://x"], 1, "gopher"),
        (["--zenoh", "tcp/x:1", "--robots", "/nowhere.toml"], 1, "/nowhere.toml"),
        (["--zenoh", "tcp/x:1"], 1, "VOA_LIMITS__BEAMS: expected a positive whole number"),
    ],
)
def test_options_that_make_no_sense(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, options: list[str], code: int, says: str
) -> None:
    monkeypatch.setenv("VOA_LIMITS__BEAMS", "many")
    assert main(["doctor", *options]) == code
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "says"),
    [(["--robots", "x.toml"], "--robots needs --zenoh"), (["--url", "zenoh://x"], "name a Zenoh router by --zenoh")],
)
def test_options_that_do_not_go_together(capsys: pytest.CaptureFixture[str], options: list[str], says: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["doctor", *options])
    assert ended.value.code == 2
    assert says in " ".join(capsys.readouterr().err.split())
