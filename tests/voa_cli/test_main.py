"""`voa COMMAND`: finds commands, says what is missing, and ends quietly when nobody listens."""

import json
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.support.api_keys import make_key
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


@pytest.mark.parametrize("words", [["--key-file", "{}", "--json"], ["--json", "--key-file={}"]])
def test_commands_send_the_key_of_a_file(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "anna.key"
    monkeypatch.setenv("VOA_KEY", "another")
    monkeypatch.setenv("VOA_KEY_FILE", "nowhere")
    file.write_text(make_key(f"sqlite:///{tmp_path}/voa.db", "viewer"))
    with local_service.local_service(tmp_path) as url:
        given = [word.format(file) for word in words]
        assert main.main(["sessions", "list", "--url", url, *given]) == 0
        assert json.loads(capsys.readouterr().out) == []
        assert main.main(["sessions", "list", "--url", url]) == 1
        assert "key" in capsys.readouterr().err
        assert (os.environ["VOA_KEY"], os.environ["VOA_KEY_FILE"]) == ("another", "nowhere")


@pytest.mark.parametrize("words", [["--key-file"], ["--key-file", "/nowhere/a.key"], ["--key-file="]])
def test_a_key_file_that_is_not_there_is_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main.main(["sessions", "list", *words]) == 2
    assert "expected a file with the key" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["serve", "keys"])
def test_commands_that_call_no_service_take_no_key_file(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main.main([name, *(["list"] if name == "keys" else []), "--key-file", "a"])
    assert ended.value.code == 2
    assert "--key-file" in capsys.readouterr().err
