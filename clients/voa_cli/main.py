"""`voa COMMAND`: finds the command's module and hands over."""

import importlib
import os
import sys
from collections.abc import Sequence
from importlib.metadata import version
from typing import NamedTuple


class Command(NamedTuple):
    """Where a command lives: `module.main(arguments) -> exit code`; imported only when it is called."""

    module: str
    help: str
    extra: str


COMMANDS = {
    "serve": Command("voa_service.serve", "run the service", "service"),
    "demo": Command("voa_cli.demo", "watch a lidar robot help an arm, in simulation", "fleet"),
    "replay": Command("voa_cli.replay", "send a recorded experiment through the service", "cli"),
    "doctor": Command("voa_cli.doctor", "say what is wrong between this machine and the service", "cli"),
    "record": Command("voa_cli.record", "record what robots and the service say on Zenoh", "cli"),
    "sessions": Command("voa_cli.sessions", "list, show, export and delete the sessions of a service", "cli"),
    "evaluate": Command("voa_cli.evaluate.command", "the paper's evaluations, simulated or recorded", "fleet"),
    "fleet": Command("voa_cli.fleet", "simulated robots as customers of the service", "fleet"),
    "check": Command("voa_cli.check", "say what is probably wrong with a scenario file", "cli"),
    "rank": Command("voa_cli.rank", "rank looks for a scenario file or a session", "cli"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code."""
    try:
        try:
            return _main(arguments)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read our output has gone, and that is fine; what is left of it must not fail at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _main(arguments: Sequence[str] | None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    if given[0] in ("-h", "--help", "--version"):
        print(version("voa") if given[0] == "--version" else _usage())
        return 0
    if given[0] not in COMMANDS:
        print(f"voa: there is no command {given[0]!r}\n\n{_usage()}", file=sys.stderr)
        return 2
    return _run(given[0], given[1:])


def _run(name: str, rest: list[str]) -> int:
    command = COMMANDS[name]
    try:
        code: int = importlib.import_module(command.module).main(rest)
    except ModuleNotFoundError as error:
        from voa_client.installing import install_hint  # noqa: PLC0415 - brings a client, which `--help` needs not

        print(f"voa {name}: no {error.name}; install it with: {install_hint(command.extra)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return code


def _usage() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:{width}}  {command.help}" for name, command in COMMANDS.items()]
    return "\n".join(["usage: voa COMMAND [OPTIONS]", "", *lines, "", "voa COMMAND --help says more."])


if __name__ == "__main__":
    sys.exit(main())
