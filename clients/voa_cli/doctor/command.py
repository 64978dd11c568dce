"""`voa doctor`: what is wrong between this machine and the service, as a checklist, each with what to do about it.

voa doctor                                                    the service on this machine, by HTTP
voa doctor --url http://lab:8000 --zenoh tcp/lab:7447         by HTTP and by Zenoh
voa doctor --zenoh zenoh://user:password@lab:7447/voa/v1/lab7 --robots lab.toml     and the robots' topics

Ends within 15 seconds; with 0 if nothing is wrong, else with 1.
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
from voa_cli.doctor.over_http import Answers, check_http, robots_after
from voa_cli.doctor.over_zenoh import check_router, check_service
from voa_cli.doctor.robots import check_robots, needs_second_report
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
"""A lidar that turns five times a second has sent some scans by then."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Check, print, and return 0 if nothing is wrong, else 1."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.robots is not None and options.zenoh is None:
        parser.error("--robots needs --zenoh, the router that the robots are on")
    if not options.url.startswith(("http://", "https://")):
        parser.error(f"--url: expected http:// or https://, got {options.url!r}; a router goes with --zenoh")
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
    budget, answers = Budget(_SECONDS), Answers()
    yield from check_http(url, budget, answers)
    if address is not None:
        yield from _over_zenoh(address, answers, listening, budget)
    elif answers.health is not None and answers.health.zenoh not in (None, "off"):
        seen = f"the service is on Zenoh ({answers.health.zenoh}); not checked"
        yield Finding("zenoh", "warning", seen, "name its router: --zenoh tcp/HOST:7447")
    on_zenoh = answers.health is not None and answers.health.zenoh != "off"
    if answers.robots is not None and (answers.robots.items or on_zenoh):
        before, robots = answers.robots, None
        if needs_second_report(before):
            robots = robots_after(url, _LATELY_S, budget)
        yield from check_robots(robots or before, datetime.now(UTC) + answers.ahead, before if robots else None)


def _over_zenoh(address: ZenohAddress, answers: Answers, listening: Listening, budget: Budget) -> Iterator[Finding]:
    with ExitStack() as stack:
        findings, session = check_router(address, budget, stack)
        yield from findings
        if session is None:
            return
        yield from check_service(session, Keys(address.root), answers.health, budget)
        yield from check_topics(session, listening, budget)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa doctor", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--url", default=DEFAULT_URL, help=f"of the service (default {DEFAULT_URL})")
    parser.add_argument("--zenoh", metavar="ENDPOINT", help="of the router: tcp/HOST:PORT, or a zenoh:// URL")
    parser.add_argument("--robots", type=Path, help="the mapping of robots' topics: listens to each of them")
    parser.add_argument(
        "--listen", type=float, default=_LISTEN_S, help=f"for how long, in seconds (default {_LISTEN_S:g})"
    )
    parser.add_argument("--database-url", metavar="URL", help="verify every version in this database, which takes time")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
