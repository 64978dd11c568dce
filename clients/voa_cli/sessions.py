"""`voa sessions`: list, show, export and delete the sessions of a service.

voa sessions list                           all sessions
voa sessions show ID                        the belief of a session, and its best grasp
voa sessions show ID --picture FILE.svg     draws both, with the places of its looks
voa sessions history ID                     its versions, each with the request that made it
voa sessions export ID > session.json       a file from which `voa replay` rebuilds the session on another service
voa sessions delete ID...                   delete sessions with their histories, for good

`delete` wants a confirmation at a terminal; anywhere else it needs --yes.
"""

import argparse
import json
import math
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from voa_cli.picture_option import add_picture_option
from voa_cli.predicted_points import predicted_points
from voa_client import Client, VoaClientError
from voa_client.formatting import absence, bar, scale, share
from voa_client.local import BRIEFLY
from voa_msgs.looks import AnnouncedLook, Place
from voa_msgs.sessions import Session
from voa_recordings.session_file import export_session

DEFAULT_URL = "http://127.0.0.1:8000"
_BAR = 30
_WIDE = ("scenario", "grasp", "robots")
"""Columns with names that people chose, which may be long."""


class NotDeleted(VoaClientError):
    """Sessions were not deleted, because no person confirmed it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand and return 0; 1 after an error."""
    options = _parser().parse_args(arguments)
    try:
        with Client(options.url, retries=BRIEFLY) as client:
            options.act(client, options)
    except VoaClientError as error:
        print(f"voa sessions: {error}", file=sys.stderr)
        return 1
    return 0


def _list(client: Client, options: argparse.Namespace) -> None:
    sessions = list(client.list_sessions())
    names = {scenario.id: scenario.name for scenario in client.list_scenarios()} if sessions else {}
    robots = _robots(client)
    if options.json:
        more = [{"scenario_name": names.get(each.scenario), "robots": robots[each.id]} for each in sessions]
        print(json.dumps([each.model_dump(mode="json") | new for each, new in zip(sessions, more, strict=True)]))
        return
    # A line of 80 columns has no room for columns that are empty in every session.
    absences = any(session.absent is not None for session in sessions)
    claims = any(robots[session.id] for session in sessions)
    headings = ["session", "scenario", "version", "grasp", "score"]
    table = _table(*headings, *(["absent"] if absences else []), "updated", *(["robots"] if claims else []))
    for session in sessions:
        table.add_row(
            session.id,
            names.get(session.scenario, ""),
            str(session.version),
            session.best_grasp or "none",
            share(session.expected_score, 3),
            *(["" if session.absent is None else share(session.absent)] if absences else []),
            f"{session.updated_at:%m-%d %H:%M}",
            *([" ".join(robots[session.id])] if claims else []),
        )
    _console().print(table if sessions else f"no sessions at {options.url}")


def _robots(client: Client) -> defaultdict[str, list[str]]:
    """Return the names of mapped robots by the session that their scans update."""
    robots: defaultdict[str, list[str]] = defaultdict(list)
    for report in client.robots().items:
        if report.source == "ros2" and report.session is not None:
            robots[report.session].append(report.robot)
    return robots


def _show(client: Client, options: argparse.Namespace) -> None:
    session = client.get_session(options.id)
    if options.picture is not None:
        _draw(client, options.picture, session)
    if options.json:
        print(session.model_dump_json(indent=1))
        return
    console = _console()
    console.print(f"session {session.id}, version {session.version}, scenario {session.scenario}", soft_wrap=True)
    console.print(f"best grasp {session.best_grasp or 'none'}, score {share(session.expected_score, 3)}")
    absent = absence(session.absent)
    if absent is not None:
        console.print(f"{absent} (score holds if it is at one)")
    if session.places:
        console.print("looks: " + ", ".join(f"{_where(place)} ({place.looks})" for place in session.places))
    if session.under_way:
        console.print("under way: " + ", ".join(_announced(look) for look in session.under_way))
    table = _table("pose", "belief", scale(1.0))
    for held, pose in sorted(zip(session.belief, session.poses, strict=True), key=lambda both: -both[0]):
        table.add_row(pose, share(held, 4), bar(held, 1.0, _BAR))
    console.print(table)


def _draw(client: Client, file: Path, session: Session) -> None:
    """Draw a session into a file; raises PictureNotWritten."""
    from voa_cli.picture import draw_session  # noqa: PLC0415 - matplotlib takes half a second

    scenario = client.get_scenario(session.scenario)
    draw_session(file, scenario, session, predicted_points(client, scenario))


def _where(place: Place | AnnouncedLook) -> str:
    """Write from where a look is taken."""
    if place.sensor_pose is None:
        return place.sensor or ""
    pose = place.sensor_pose
    return f"x {pose.x:.2f} m, y {pose.y:.2f} m, yaw {math.degrees(pose.yaw_rad):.0f} degrees"


def _announced(look: AnnouncedLook) -> str:
    """Write an announced look with its robot, and when the announcement ends."""
    robot = "" if look.robot is None else f" by {look.robot}"
    return f"{_where(look)}{robot} (until {look.expires_at:%H:%M:%S})"


def _history(client: Client, options: argparse.Namespace) -> None:
    entries = list(client.history(options.id))
    if options.json:
        print(f"[{', '.join(entry.model_dump_json() for entry in entries)}]")
        return
    absences = any(entry.absent is not None for entry in entries)
    headings = ("version", "kind", "at", "result", "evidence", "fit (mm)", "best fit")
    table = _table(*headings, *(["absent"] if absences else []))
    for entry in entries:
        report = entry.update
        result = "" if report is None else report.reason or "accepted"
        figures = ["", "", ""]
        if report is not None:
            evidence, fit = report.log_evidence, report.fit_rmsd_mm
            figures = ["" if evidence is None else f"{evidence:.3f}", "" if fit is None else f"{fit:.1f}"]
            figures.append(report.best_fit_pose or "")
        if absences:
            figures.append("" if entry.absent is None else share(entry.absent))
        table.add_row(str(entry.version), entry.kind, f"{entry.at:%H:%M:%S}", result, *figures)
    _console().print(table)


def _export(client: Client, options: argparse.Namespace) -> None:
    print(export_session(client, options.id).model_dump_json(indent=1))


def _delete(client: Client, options: argparse.Namespace) -> None:
    """Delete sessions, if all exist; raises NotDeleted if no person confirms it."""
    ids = list(dict.fromkeys(options.id))
    sessions = [client.get_session(id_) for id_ in ids]
    if not options.yes:
        robots = _robots(client)
        of = {id_: f" (session of {', '.join(names)})" for id_, names in robots.items()}
        _confirm([f"{each.id} at version {each.version}{of.get(each.id, '')}" for each in sessions])
    for id_ in ids:
        client.delete_session(id_)
        print(f"deleted {id_}")


def _confirm(sessions: Sequence[str]) -> None:
    """Let a person confirm at the terminal; raises NotDeleted without a terminal, or unless the answer is yes."""
    what = ", ".join(sessions)
    if not sys.stdin.isatty():
        raise NotDeleted(f"nothing deleted: there is no terminal for a confirmation; add --yes to delete {what}")
    print(f"delete {what} with the whole history? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise NotDeleted("nothing deleted")


def _console() -> Console:
    """Open a console that does not take brackets in names for markup."""
    return Console(markup=False, highlight=False)


def _table(*headings: str) -> Table:
    """Make a table that fits 80 columns: ids are kept whole, long names are folded."""
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
            one.add_argument("id", help="id of the session")
        if has_json:
            one.add_argument("--json", action="store_true", help="print one JSON document")
        one.add_argument("--url", default=DEFAULT_URL, help=f"address of the service (default {DEFAULT_URL})")
        one.set_defaults(act=act)
        return one

    command("list", _list, of_one=False)
    show = command("show", _show, of_one=True)
    add_picture_option(show, "the belief, and the places of its looks,")
    command("history", _history, of_one=True)
    command("export", _export, of_one=True, has_json=False)
    delete = command("delete", _delete, of_one=False, has_json=False)
    delete.add_argument("id", nargs="+", help="id of a session")
    delete.add_argument("--yes", "-y", action="store_true", help="delete without a confirmation")
    return parser
