"""`voa doctor`: check the way to the service and its robots, and print a checklist with advice.

voa doctor                                                    the service on this machine, over HTTP
voa doctor --url http://lab:8000 --zenoh tcp/lab:7447         over HTTP and over Zenoh
voa doctor --zenoh zenoh://user:password@lab:7447/voa/v1/lab7 --robots lab.toml     the robots' topics, too

It takes at most 15 seconds. The exit code is 0 if nothing is wrong, else 1.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table

from voa_client import VoaClientError
from voa_client.zenoh_session import address_of
from voa_doctor.examination import examine
from voa_doctor.findings import Finding, State
from voa_doctor.over_database import check_database
from voa_doctor.topics import Listening
from voa_recordings.limits import most_beams
from voa_ros.robots import InvalidRobots, load

DEFAULT_URL = "http://127.0.0.1:8000"
_LISTEN_S = 3.0
_SIGNS: dict[State, str] = {"ok": "[green]✓[/green]", "warning": "[yellow]![/yellow]", "wrong": "[red]✗[/red]"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all checks, print the checklist, and return 0 if nothing is wrong, else 1."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.robots is not None and options.zenoh is None:
        parser.error("--robots needs --zenoh, the router that the robots are on")
    if not options.url.startswith(("http://", "https://")):
        parser.error(f"--url: expected http:// or https://, got {options.url!r}; name a Zenoh router by --zenoh")
    try:
        address = None if options.zenoh is None else address_of(options.zenoh)
        robots = () if options.robots is None else load(options.robots.read_text(encoding="utf-8"))
        listening = Listening(robots, options.listen, most_beams())
    except (VoaClientError, InvalidRobots, OSError, UnicodeDecodeError) as error:
        print(f"voa doctor: {error}", file=sys.stderr)
        return 1
    findings = examine(options.url, address, listening)
    findings += [] if options.database_url is None else check_database(options.database_url)
    wrong = any(finding.state == "wrong" for finding in findings)
    if options.json:
        json.dump({"healthy": not wrong, "findings": [asdict(finding) for finding in findings]}, sys.stdout, indent=1)
        print()
    else:
        console = Console()
        console.print(checklist(findings))
        console.print(verdict(findings), highlight=False)
    return int(wrong)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa doctor", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--url", default=DEFAULT_URL, help=f"address of the service (default {DEFAULT_URL})")
    parser.add_argument("--zenoh", metavar="ENDPOINT", help="address of the router: tcp/HOST:PORT, or a zenoh:// URL")
    parser.add_argument(
        "--robots", type=Path, help="mapping of the robots' topics, all of which are subscribed to and checked"
    )
    parser.add_argument(
        "--listen",
        type=float,
        default=_LISTEN_S,
        help=f"seconds for which topics are subscribed to (default {_LISTEN_S:g})",
    )
    parser.add_argument(
        "--database-url", metavar="URL", help="verify every version in this database, however long it takes"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser


def checklist(findings: Sequence[Finding]) -> Table:
    """Lay findings out as a list that can be read at any width: the observation, and below it the advice."""
    table = Table.grid(padding=(0, 1))
    table.add_column()
    table.add_column(overflow="fold")
    for finding in findings:
        lines = Table.grid(padding=(0, 1))
        lines.add_column(overflow="fold")
        lines.add_row(f"[bold]{escape(finding.check)}:[/bold] {escape(finding.seen)}")
        if finding.advice:
            lines.add_row(Padding(escape(f"-> {finding.advice}"), (0, 0, 0, 2)))
        table.add_row(_SIGNS[finding.state], lines)
    return table


def verdict(findings: Sequence[Finding]) -> str:
    """Count the wrong findings and the warnings in a line."""
    states = Counter(finding.state for finding in findings)
    warnings = f"{states['warning']} warning{'' if states['warning'] == 1 else 's'}"
    return f"{states['wrong'] or 'nothing'} wrong, {warnings if states['warning'] else 'no warnings'}"
