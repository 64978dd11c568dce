"""The page of the commands lists every command of `voa` with its options, and every target of the Makefile."""

import contextlib
import re

import pytest

from tests.deploy.pages import REPOSITORY, page
from voa_cli.main import COMMANDS, main

ROWS = dict(re.findall(r"(?m)^\| `voa ([^`]+)` \| [^|]+ \| ([^|]*) \|$", page("commands").text))
"""Options of each command, by its words."""
OPTION = re.compile(r"(?m)^  (?:-\w(?: [A-Z]+)?, )?(--[a-z][\w-]*)")


def words_of(row: str) -> list[str]:
    """Words of a command without its arguments."""
    return [word for word in row.split() if re.fullmatch(r"[a-z][a-z-]*", word)]


def printed_help(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with contextlib.suppress(SystemExit):
        main([*words, "--help"])
    return capsys.readouterr().out


def test_every_command_is_listed() -> None:
    assert {words_of(row)[0] for row in ROWS} == set(COMMANDS)


def test_every_part_of_a_command_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    listed = {tuple(words) for row in ROWS if len(words := words_of(row)) == 2}
    evaluations = re.findall(r"(?m)^  ([a-z-]+)  ", printed_help(["evaluate"], capsys))
    (sessions,) = set(re.findall(r"(?m)^  ([a-z]+(?: \| [a-z]+)+)$", printed_help(["sessions"], capsys)))
    (keys,) = set(re.findall(r"(?m)^  ([a-z]+(?: \| [a-z]+)+)$", printed_help(["keys"], capsys)))
    parts = re.findall(r"(?m)^    ([a-z-]+)(?:  |$)", printed_help(["experiment"], capsys).partition("PART\n")[2])
    assert listed == {
        *(("evaluate", each) for each in evaluations),
        *(("sessions", each) for each in sessions.split(" | ")),
        *(("keys", each) for each in keys.split(" | ")),
        *(("experiment", each) for each in parts),
    }


@pytest.mark.parametrize("row", ROWS)
def test_a_command_is_listed_with_all_of_its_options(row: str, capsys: pytest.CaptureFixture[str]) -> None:
    printed = printed_help(words_of(row), capsys)
    assert set(re.findall(r"`(--[\w-]+)`", ROWS[row])) == set(OPTION.findall(printed)) - {"--help"}


def test_every_target_of_the_makefile_is_listed() -> None:
    targets = re.findall(r"(?m)^([a-z]+):.*##", (REPOSITORY / "Makefile").read_text(encoding="utf-8"))
    assert set(re.findall(r"(?m)^\| `make ([a-z]+)` \|", page("commands").text)) == set(targets)
