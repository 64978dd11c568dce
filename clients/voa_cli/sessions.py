"""`voa sessions`: what runs on a service, for a person at a terminal.

voa sessions list                           every session
voa sessions show ID                        what it believes, and its best grasp
voa sessions history ID                     every version and what made it
voa sessions export ID > session.json       a file that `voa replay` makes anew elsewhere
"""

import argparse
import sys
from collections.abc import Callable, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from voa_cli.local_service import BRIEFLY
from voa_client import Client, VoaClientError
from voa_client.readable import bar, scale, share
from voa_client.session_file import export_session

DEFAULT_URL = "http://127.0.0.1:8000"
_BAR = 30


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what was asked for and return 0; 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    try:
        with Client(options.url, retries=BRIEFLY) as client:
            options.act(client, options)
    except VoaClientError as error:
        print(f"voa sessions: {error}", file=sys.stderr)
        return 1
    return 0


def _list(client: Client, options: argparse.Namespace) -> None:
    found = list(client.list_sessions())
    if options.json:
        print(f"[{', '.join(session.model_dump_json() for session in found)}]")
        return
    table = _table("session", "version", "best grasp", "score", "updated")
    for session in found:
        updated = f"{session.updated_at:%m-%d %H:%M:%S}"
        best = session.best_grasp or "none"
        table.add_row(session.id, str(session.version), best, share(session.expected_score, 3), updated)
    _console().print(table if found else f"no sessions at {options.url}")


def _show(client: Client, options: argparse.Namespace) -> None:
    session = client.get_session(options.id)
    if options.json:
        print(session.model_dump_json(indent=1))
        return
    console = _console()
    console.print(f"session {session.id}, version {session.version}, scenario {session.scenario}", soft_wrap=True)
    console.print(f"best grasp {session.best_grasp or 'none'}, score {share(session.expected_score, 3)}")
    table = _table("pose", "belief", scale(1.0))
    for held, pose in sorted(zip(session.belief, session.poses, strict=True), key=lambda both: -both[0]):
        table.add_row(pose, share(held, 4), bar(held, 1.0, _BAR))
    console.print(table)


def _history(client: Client, options: argparse.Namespace) -> None:
    entries = client.history(options.id)
    if options.json:
        print(f"[{', '.join(entry.model_dump_json() for entry in entries)}]")
        return
    table = _table("version", "kind", "at", "result", "evidence", "fit (mm)", "best fit")
    for entry in entries:
        report = entry.update
        result = "" if report is None else report.reason or "accepted"
        figures = ["", "", ""]
        if report is not None:
            evidence, fit = report.log_evidence, report.fit_rmsd_mm
            figures = ["" if evidence is None else f"{evidence:.3f}", "" if fit is None else f"{fit:.1f}"]
            figures.append(report.best_fit_pose or "")
        table.add_row(str(entry.version), entry.kind, f"{entry.at:%H:%M:%S}", result, *figures)
    _console().print(table)


def _export(client: Client, options: argparse.Namespace) -> None:
    print(export_session(client, options.id).model_dump_json(indent=1))


def _console() -> Console:
    """Open a terminal that prints names as they are: brackets in them are no markup."""
    return Console(markup=False, highlight=False)


def _table(*headings: str) -> Table:
    """Narrow enough for 80 columns, ids whole."""
    return Table(*(Column(heading, no_wrap=True) for heading in headings), box=SIMPLE_HEAD, pad_edge=False)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa sessions", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(required=True, metavar="list | show | history | export")

    def command(name: str, act: Callable[[Client, argparse.Namespace], None], *, of_one: bool) -> None:
        one = commands.add_parser(name)
        if of_one:
            one.add_argument("id", help="of the session")
        if name != "export":
            one.add_argument("--json", action="store_true", help="print one JSON document")
        one.add_argument("--url", default=DEFAULT_URL, help=f"of the service (default {DEFAULT_URL})")
        one.set_defaults(act=act)

    command("list", _list, of_one=False)
    command("show", _show, of_one=True)
    command("history", _history, of_one=True)
    command("export", _export, of_one=True)
    return parser
