"""`voa sessions`: what runs on a service, for a person at a terminal.

voa sessions list                           every session
voa sessions show ID                        what it believes, and its best grasp
voa sessions history ID                     every version and what made it
voa sessions export ID > session.json       a file that `voa replay` makes anew elsewhere
voa sessions delete ID...                   remove sessions with their histories, for good

`delete` asks first at a terminal; anywhere else it needs --yes.
"""

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from voa_client import Client, VoaClientError
from voa_client.formatting import bar, scale, share
from voa_client.local import BRIEFLY
from voa_recordings.session_file import export_session

DEFAULT_URL = "http://127.0.0.1:8000"
_BAR = 30
_WIDE = ("scenario", "grasp", "robots")
"""Columns of names that people gave."""


class NotDeleted(VoaClientError):
    """Sessions were not deleted, since nobody confirmed it."""


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
    names = {scenario.id: scenario.name for scenario in client.list_scenarios()} if found else {}
    robots = _robots(client)
    if options.json:
        more = [{"scenario_name": names.get(each.scenario), "robots": robots[each.id]} for each in found]
        print(json.dumps([each.model_dump(mode="json") | new for each, new in zip(found, more, strict=True)]))
        return
    table = _table("session", "scenario", "version", "grasp", "score", "updated", "robots")
    for session in found:
        table.add_row(
            session.id,
            names.get(session.scenario, ""),
            str(session.version),
            session.best_grasp or "none",
            share(session.expected_score, 3),
            f"{session.updated_at:%m-%d %H:%M}",
            " ".join(robots[session.id]),
        )
    _console().print(table if found else f"no sessions at {options.url}")


def _robots(client: Client) -> defaultdict[str, list[str]]:
    """The mapped robots by the session that their scans are for."""
    robots: defaultdict[str, list[str]] = defaultdict(list)
    for report in client.robots().items:
        if report.source == "ros2" and report.session is not None:
            robots[report.session].append(report.robot)
    return robots


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


def _delete(client: Client, options: argparse.Namespace) -> None:
    """Delete sessions, all of which must be there; raises NotDeleted where nobody agrees."""
    ids = list(dict.fromkeys(options.id))
    found = [client.get_session(id_) for id_ in ids]
    if not options.yes:
        robots = _robots(client)
        of = {id_: f" (session of {', '.join(names)})" for id_, names in robots.items()}
        _confirm([f"{each.id} at version {each.version}{of.get(each.id, '')}" for each in found])
    for id_ in ids:
        client.delete_session(id_)
        print(f"deleted {id_}")


def _confirm(sessions: Sequence[str]) -> None:
    """Ask a person; raises NotDeleted where there is none, or the answer is not yes."""
    what = ", ".join(sessions)
    if not sys.stdin.isatty():
        raise NotDeleted(f"nothing deleted: there is no terminal to ask at, add --yes to delete {what}")
    print(f"delete {what} with everything that happened there? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise NotDeleted("nothing deleted")


def _console() -> Console:
    """Open a terminal that prints names as they are: brackets in them are no markup."""
    return Console(markup=False, highlight=False)


def _table(*headings: str) -> Table:
    """Narrow enough for 80 columns, ids whole: what may be long without end is folded."""
    columns = [
        Column(heading, no_wrap=heading not in _WIDE, overflow="fold", min_width=len(heading)) for heading in headings
    ]
    return Table(*columns, box=SIMPLE_HEAD, pad_edge=False)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa sessions", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(required=True, metavar="list | show | history | export | delete")

    def command(
        name: str, act: Callable[[Client, argparse.Namespace], None], *, of_one: bool, has_json: bool = True
    ) -> argparse.ArgumentParser:
        one = commands.add_parser(name)
        if of_one:
            one.add_argument("id", help="of the session")
        if has_json:
            one.add_argument("--json", action="store_true", help="print one JSON document")
        one.add_argument("--url", default=DEFAULT_URL, help=f"of the service (default {DEFAULT_URL})")
        one.set_defaults(act=act)
        return one

    command("list", _list, of_one=False)
    command("show", _show, of_one=True)
    command("history", _history, of_one=True)
    command("export", _export, of_one=True, has_json=False)
    delete = command("delete", _delete, of_one=False, has_json=False)
    delete.add_argument("id", nargs="+", help="of a session")
    delete.add_argument("--yes", "-y", action="store_true", help="do not ask")
    return parser
