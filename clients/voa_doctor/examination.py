"""Examination of a service, its router and its robots: all checks in order, within one time limit."""

from collections.abc import Iterator
from contextlib import ExitStack
from datetime import UTC, datetime

from voa_client import ApiKey, ZenohAddress
from voa_doctor.findings import Budget, Finding
from voa_doctor.over_http import Responses, check_http, robots_after
from voa_doctor.over_zenoh import check_router, check_service
from voa_doctor.robots import check_robots, needs_second_report
from voa_doctor.sessions import check_sessions
from voa_doctor.topics import Listening, check_topics
from voa_msgs.keys import Keys

SECONDS = 14.0
"""Time limit of all checks together, seconds."""
_LATELY_S = 1.0
"""Time between two reports on the robots, seconds: a lidar of 5 Hz sends some scans in it."""


def examine(
    url: str,
    address: ZenohAddress | None = None,
    listening: Listening | None = None,
    key: ApiKey | None = None,
) -> list[Finding]:
    """Run all checks of a service and its robots, and return the findings in the order of the checks.

    It blocks for as long as the checks take, at most 15 seconds: a program with an event loop runs it in a thread.

    Args:
        url: address of the service, http:// or https://.
        address: of the Zenoh router, with credentials; None: only HTTP is checked.
        listening: topics of robots to subscribe to on the router; None: none.
        key: by which the service is called over HTTP; None: that of the environment, if there is one.
    """
    return list(_findings(url, address, listening, Budget(SECONDS), ApiKey.given() if key is None else key))


def _findings(
    url: str, address: ZenohAddress | None, listening: Listening | None, budget: Budget, key: ApiKey
) -> Iterator[Finding]:
    responses = Responses()
    yield from check_http(url, budget, responses, key)
    if address is not None:
        yield from _over_zenoh(address, responses, listening, budget)
    elif responses.health is not None and responses.health.zenoh not in (None, "off"):
        seen = f"the service uses Zenoh ({responses.health.zenoh}), which was not checked"
        yield Finding("zenoh", "warning", seen, "name its router: voa doctor --zenoh tcp/HOST:7447")
    on_zenoh = responses.health is not None and responses.health.zenoh != "off"
    if responses.robots is not None and (responses.robots.items or on_zenoh):
        before, robots = responses.robots, None
        if needs_second_report(before):
            robots = robots_after(url, _LATELY_S, budget, key)
        yield from check_robots(robots or before, datetime.now(UTC) + responses.ahead, before if robots else None)
    yield from check_sessions(responses.sessions)


def _over_zenoh(
    address: ZenohAddress, responses: Responses, listening: Listening | None, budget: Budget
) -> Iterator[Finding]:
    with ExitStack() as stack:
        findings, session = check_router(address, budget, stack)
        yield from findings
        if session is None:
            return
        yield from check_service(session, Keys(address.root), responses.health, budget)
        if listening is not None:
            yield from check_topics(session, listening, budget)
