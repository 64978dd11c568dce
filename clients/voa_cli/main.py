"""The `voa` command: imports the module of the named subcommand and runs it."""

import gc
import importlib
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple


class Command(NamedTuple):
    """A subcommand: the module whose `main(arguments)` returns the exit code, imported when the command is run."""

    module: str
    help: str
    extra: str


_KEY_FILE = "--key-file"

COMMANDS = {
    "serve": Command("voa_cli.serve", "run the service", "service"),
    "console": Command("voa_cli.console", "serve the laboratory's web page beside a service", "console"),
    "keys": Command("voa_service.access.command", "make, list and revoke the API keys of a service", "service"),
    "demo": Command("voa_cli.demo", "watch a lidar robot help an arm, in simulation", "fleet"),
    "replay": Command(
        "voa_cli.replay.command", "send recorded experiments, sessions or scans through the service", "cli"
    ),
    "experiment": Command("voa_cli.experiment", "begin, check or make a recorded experiment", "cli"),
    "calibrate": Command("voa_cli.calibrate", "estimate odometry's origin or the lidar's mount from a stop", "setup"),
    "doctor": Command("voa_cli.doctor", "find out what is wrong between this machine and the service", "cli"),
    "record": Command("voa_cli.record", "record what robots and the service publish on Zenoh", "cli"),
    "sessions": Command("voa_cli.sessions", "list, show, export and delete the sessions of a service", "cli"),
    "backup": Command("voa_service.backup", "copy the database of a running service to a file", "service"),
    "restore": Command("voa_service.restore", "put a backup in the place of a database", "service"),
    "prune": Command("voa_cli.prune", "delete the sessions that have not moved for long", "cli"),
    "new": Command("voa_cli.new.command", "make a scenario from a mesh", "setup"),
    "evaluate": Command("voa_cli.evaluate.command", "run the paper's evaluations, simulated or recorded", "fleet"),
    "fleet": Command("voa_cli.fleet", "run simulated robots that use the service", "fleet"),
    "check": Command("voa_cli.check", "list the probable mistakes in a scenario file", "cli"),
    "rank": Command("voa_cli.rank", "rank looks for a scenario file or a session", "cli"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand and return its exit code; 130 after Ctrl-C."""
    try:
        try:
            return _main(arguments)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader of our output has closed it, as `head` does; the rest must not fail at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _main(arguments: Sequence[str] | None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    if words[0] in ("-h", "--help", "--version"):
        print(version("voa") if words[0] == "--version" else _usage())
        return 0
    try:
        words, file = _without_key_file(words)
    except ValueError as error:
        print(f"voa {words[0]}: {error}", file=sys.stderr)
        return 2
    if words[0] not in COMMANDS:
        print(f"voa: there is no command {words[0]!r}\n\n{_usage()}", file=sys.stderr)
        return 2
    with _in_environment(file):
        return _run(words[0], words[1:])


def _without_key_file(words: list[str]) -> tuple[list[str], str | None]:
    """Take the option `--key-file`, which all commands that call a service have, out of the command line.

    Raises:
        ValueError: it names no file.
    """
    rest: list[str] = []
    file: str | None = None
    given = iter(words)
    for word in given:
        name, _, value = word.partition("=")
        if name == _KEY_FILE and COMMANDS.get(words[0], COMMANDS["serve"]).extra != "service":
            file = value or next(given, "")
            if not Path(file).is_file():
                raise ValueError(f"{_KEY_FILE}: expected a file with the key of the service, got {file!r}")
        else:
            rest.append(word)
    return rest, file


@contextmanager
def _in_environment(file: str | None) -> Iterator[None]:
    """Let clients of this process, and of those that it starts, read their key from a file; None: change nothing."""
    if file is None:
        yield
        return
    before = {name: os.environ.pop(name, None) for name in ("VOA_KEY", "VOA_KEY_FILE")}
    os.environ["VOA_KEY_FILE"] = str(Path(file).absolute())
    try:
        yield
    finally:
        del os.environ["VOA_KEY_FILE"]
        os.environ.update({name: value for name, value in before.items() if value is not None})


def _loaded(module: str) -> Any:
    """Import a module without garbage collection: modules are no garbage, and to search them takes long."""
    gc.disable()
    try:
        return importlib.import_module(module)
    finally:
        gc.enable()


def _run(name: str, rest: list[str]) -> int:
    command = COMMANDS[name]
    try:
        code: int = _loaded(command.module).main(rest)
    except ModuleNotFoundError as error:
        from voa_client.installing import install_hint  # noqa: PLC0415 - imports the client, which `--help` does not need

        missing = f"{(error.name or '').partition('.')[0]} is not installed"
        print(f"voa {name}: {missing}; install it with: {install_hint(command.extra)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return code


def _usage() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:{width}}  {command.help}" for name, command in COMMANDS.items()]
    key = "Commands that call a service take --key-file FILE, else VOA_KEY_FILE or VOA_KEY: the caller's API key."
    end = [key, "voa COMMAND --help describes a command."]
    return "\n".join(["usage: voa COMMAND [OPTIONS]", "", *lines, "", *end])


if __name__ == "__main__":
    sys.exit(main())
