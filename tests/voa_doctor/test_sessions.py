"""Sessions of robots, and what the doctor says of an object that may be absent."""

import httpx2
import pytest

from tests.support.serving import data_scenario
from tests.voa_client.roles import session as stored
from voa_client import Client, ScenarioRequest, SessionRequest
from voa_doctor.findings import Budget
from voa_doctor.sessions import check_sessions, sessions_of
from voa_msgs.robots import RobotReport, Robots
from voa_msgs.sessions import Session


def of_robots(*sessions: str | None) -> Robots:
    """Robots, each with the session that its scans go to."""
    reports = [
        RobotReport(
            robot=f"r{index}",
            session=session,
            source="scan",
            key="scan",
            last_scan_at=None,
            scans=0,
            looks=0,
            refused=0,
            last_refusal=None,
            waiting_for=None,
        )
        for index, session in enumerate(sessions)
    ]
    return Robots(items=reports)


@pytest.mark.parametrize(
    ("absent", "states"), [(None, []), (0.2, ["ok"]), (0.5, ["ok"]), (0.51, ["warning"]), (1.0, ["warning"])]
)
def test_an_object_that_is_probably_absent_is_a_warning(absent: float | None, states: list[str]) -> None:
    own = Session.model_validate_json(stored(absent=absent).body)
    findings = list(check_sessions([own]))
    assert [finding.state for finding in findings] == states
    for finding in findings:
        assert finding.check == "session s"
        assert "object at none of the poses: probability" in finding.seen
        assert bool(finding.advice) is (finding.state == "warning")


def test_the_sessions_are_those_of_robots_each_once(process: str) -> None:
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario(absent=0.6))).id
        own, other = (client.create_session(SessionRequest(scenario=scenario)).id for _ in range(2))
    with httpx2.Client(base_url=process) as http:
        sessions = sessions_of(http, of_robots(own, None, own, "gone", other), Budget(10.0))
    assert [(session.id, session.absent) for session in sessions] == [(own, 0.6), (other, 0.6)]


def test_a_service_that_does_not_answer_has_no_sessions() -> None:
    with httpx2.Client(base_url="http://127.0.0.1:1") as http:
        assert sessions_of(http, of_robots("s"), Budget(10.0)) == []
