"""`voa doctor`: check the way to the service and its robots, and print a checklist with advice.

voa doctor                                                    the service on this machine, over HTTP
voa doctor --url http://lab:8000 --zenoh tcp/lab:7447         over HTTP and over Zenoh
voa doctor --zenoh zenoh://user:password@lab:7447/voa/v1/lab7 --robots lab.toml     the robots' topics, too

It takes at most 15 seconds. The exit code is 0 if nothing is wrong, else 1.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from rich.console import Console

from voa_cli.doctor.findings import Budget, Finding, checklist, verdict
from voa_cli.doctor.over_database import check_database
from voa_cli.doctor.over_http import Responses, check_http, robots_after
from voa_cli.doctor.over_zenoh import check_router, check_service
from voa_cli.doctor.robots import check_robots, needs_second_report
from voa_cli.doctor.sessions import check_sessions
from voa_cli.doctor.topics import Listening, check_topics
from voa_client import VoaClientError, ZenohAddress
from voa_client.zenoh_session import address_of
from voa_msgs.keys import Keys
from voa_recordings.limits import most_beams
from voa_ros.robots import InvalidRobots, load

DEFAULT_URL = "http://127.0.0.1:8000"
_SECONDS = 14.0
_LISTEN_S = 3.0
_LATELY_S = 1.0
"""Time between two reports on the robots, seconds: a lidar of 5 Hz sends some scans in it."""


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
    findings = list(_findings(options.url, address, listening))
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


def _findings(url: str, address: ZenohAddress | None, listening: Listening) -> Iterator[Finding]:
    budget, responses = Budget(_SECONDS), Responses()
    yield from check_http(url, budget, responses)
    if address is not None:
        yield from _over_zenoh(address, responses, listening, budget)
    elif responses.health is not None and responses.health.zenoh not in (None, "off"):
        seen = f"the service uses Zenoh ({responses.health.zenoh}), which was not checked"
        yield Finding("zenoh", "warning", seen, "name its router: voa doctor --zenoh tcp/HOST:7447")
    on_zenoh = responses.health is not None and responses.health.zenoh != "off"
    if responses.robots is not None and (responses.robots.items or on_zenoh):
        before, robots = responses.robots, None
        if needs_second_report(before):
            robots = robots_after(url, _LATELY_S, budget)
        yield from check_robots(robots or before, datetime.now(UTC) + responses.ahead, before if robots else None)
    yield from check_sessions(responses.sessions)


def _over_zenoh(address: ZenohAddress, responses: Responses, listening: Listening, budget: Budget) -> Iterator[Finding]:
    with ExitStack() as stack:
        findings, session = check_router(address, budget, stack)
        yield from findings
        if session is None:
            return
        yield from check_service(session, Keys(address.root), responses.health, budget)
        yield from check_topics(session, listening, budget)


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
