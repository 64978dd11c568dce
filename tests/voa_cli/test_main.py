"""`voa COMMAND`: finds commands, says what is missing, and ends quietly when nobody listens."""

import json
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.support.recorded import write
from voa_cli import main
from voa_client import local as local_service
from voa_client.local import ServiceDidNotStart


def test_an_unknown_command_is_2_and_lists_those_that_exist(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["dance"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "'dance'" in said.err
    assert all(name in said.err for name in main.COMMANDS)


@pytest.mark.parametrize("arguments", [[], ["-h"], ["--help"]])
def test_help_lists_the_commands(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main([*arguments, *(["--help"] if not arguments else [])]) == 0
    said = capsys.readouterr().out
    assert all(f"  {name}" in said for name in main.COMMANDS)


def test_the_version_is_that_of_the_distribution(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == version("voa")


@pytest.mark.parametrize("name", main.COMMANDS)
def test_every_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main.main([name, "--help"])
    assert ended.value.code == 0
    assert f"usage: voa {name}" in capsys.readouterr().out


@pytest.mark.parametrize(("name", "absent", "extra"), [("replay", "rich", "cli"), ("serve", "uvicorn", "service")])
def test_a_missing_library_names_the_extra_that_brings_it(name: str, absent: str, extra: str) -> None:
    program = f"import sys; sys.modules[{absent!r}] = None; from voa_cli.main import main; sys.exit(main([{name!r}]))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert f"{absent} is not installed" in done.stderr
    assert f"pip install 'PATH_TO_CLONE[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(
    "command", ["--version", "--help", "rank --help", "replay experiment --json", "replay experiment"]
)
def test_a_reader_that_leaves_is_no_error(tmp_path: Path, process: str, command: str, unbuffered: str) -> None:
    write(tmp_path / "experiment")
    arguments = command.split() + (["--url", process] if "experiment" in command else [])
    read, written = os.pipe()
    os.close(read)  # nobody listens from the start
    try:
        done = subprocess.run(
            [sys.executable, "-m", "voa_cli.main", *arguments],
            stdout=written,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            cwd=tmp_path,
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        )
    finally:
        os.close(written)
    assert done.stderr == ""
    assert done.returncode == (1 if command == "replay experiment" else 0)  # rich ends with 1 by itself


@pytest.mark.parametrize("command", ["replay", "rank"])
def test_a_service_that_is_not_there_is_said_so(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write(tmp_path / "experiment")
    target = [str(folder)] if command == "replay" else ["--session", "s1"]
    assert main.main([command, *target, "--url", "http://127.0.0.1:1"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert "no answer from http://127.0.0.1:1" in said.err


def test_a_service_that_cannot_start_says_why(tmp_path: Path) -> None:
    (tmp_path / "voa.db").write_text("this is no database, and long enough to be taken for one " * 20)
    with pytest.raises(ServiceDidNotStart, match="is not an SQLite database"), local_service.local_service(tmp_path):
        raise AssertionError("it started")


def test_the_service_is_gone_afterwards(tmp_path: Path) -> None:
    with local_service.local_service(tmp_path) as url:
        assert url.startswith("http://127.0.0.1:")
    lines = [json.loads(line) for line in (tmp_path / "service.log").read_text().splitlines()]
    assert "listening" in [line["event"] for line in lines]
    assert not list(tmp_path.glob("voa.db-wal"))  # it ended in order
