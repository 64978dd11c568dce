"""Checks of the sessions that robots' scans go to: is the object there at all?"""

from collections.abc import Iterator, Sequence

import httpx2
from pydantic import ValidationError

from voa_client.formatting import absence
from voa_doctor.findings import Budget, Finding
from voa_doctor.remedies import for_warning
from voa_msgs.robots import Robots
from voa_msgs.sessions import Session

PROBABLE = 0.5
"""Probability of absence above which there is a warning, as the service warns."""
_SECONDS = 2.0
_MOST = 16
"""Most sessions that are checked, because all checks together may take a few seconds only."""


def sessions_of(http: httpx2.Client, robots: Robots, budget: Budget) -> list[Session]:
    """Return the sessions that the robots' scans go to; those that the service does not return are left out."""
    ids = dict.fromkeys(robot.session for robot in robots.items if robot.session is not None)
    sessions = (_session(http, id_, budget) for id_ in list(ids)[:_MOST])
    return [session for session in sessions if session is not None]


def check_sessions(sessions: Sequence[Session]) -> Iterator[Finding]:
    """Check for each session whose scenario considers an absent object if the object is probably there."""
    for session in sessions:
        seen = absence(session.absent)
        if session.absent is None or seen is None:
            continue
        if session.absent > PROBABLE:
            yield Finding(f"session {session.id}", "warning", seen, for_warning("probably-absent"))
        else:
            yield Finding(f"session {session.id}", "ok", seen)


def _session(http: httpx2.Client, id_: str, budget: Budget) -> Session | None:
    try:
        response = http.get(f"/v1/sessions/{id_}", timeout=budget.step(_SECONDS)).raise_for_status()
        return Session.model_validate_json(response.content, extra="ignore")
    except (httpx2.HTTPError, ValidationError):
        return None
