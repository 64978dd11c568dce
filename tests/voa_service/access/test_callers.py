"""Callers: what their role allows, and which sessions and robots their key is for."""

from collections.abc import Collection
from contextlib import nullcontext
from datetime import UTC, datetime

import pytest

from voa_msgs.callers import Role
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.roles import BY_NAME, CALLS
from voa_service.failures import Forbidden
from voa_store.records import RobotClaim

BOUND = Caller("tb3_1", "sensor", "1234", frozenset({"s1"}), frozenset({"tb3_1"}))


@pytest.mark.parametrize("role", ["sensor", "arm", "viewer", "operator"])
def test_a_role_may_make_the_calls_of_its_rows_alone(role: Role) -> None:
    caller = Caller("anna", role, "1234")
    for call in CALLS:
        if role in call.roles:
            caller.check_role(call)
        else:
            with pytest.raises(Forbidden, match=f"'anna' has the role {role}; this call needs the role .*operator"):
                caller.check_role(call)


def test_a_key_that_is_bound_is_for_its_sessions_and_robots_alone() -> None:
    BOUND.check_subject(BY_NAME["scan.apply"], "s1")
    BOUND.check_subject(BY_NAME["robot.look"], "tb3_1")
    BOUND.check_subject(BY_NAME["lidar.list"], None)
    for name, subject in (("scan.apply", "s2"), ("robot.look", "tb3_2"), ("session.create", None)):
        with pytest.raises(Forbidden, match="'tb3_1' is"):
            BOUND.check_subject(BY_NAME[name], subject)
    with pytest.raises(Forbidden):
        BOUND.check_robot("tb3_2")
    BOUND.check_robot(None)


def bound(sessions: tuple[str, ...] | None, robots: tuple[str, ...] | None) -> Caller:
    only, as_robots = (None if names is None else frozenset(names) for names in (sessions, robots))
    return Caller("k", "sensor", "1", only, as_robots)


class Claims:
    """Claims of two robots for two sessions, and a robot that was released from every session."""

    def claim_of(self, robot: str) -> RobotClaim | None:
        return {"r1": RobotClaim("s1"), "r2": RobotClaim("s2"), "released": RobotClaim(None)}.get(robot)

    def take_part(self, session: str, robots: Collection[str]) -> bool:
        return RobotClaim(session) in map(self.claim_of, robots)


@pytest.mark.parametrize(
    ("sessions", "robots", "session", "robot", "is_allowed"),
    [
        (None, None, "any", None, True),
        (None, None, "any", "any", True),
        (("s1",), None, "s1", None, True),
        (None, ("r1",), "s1", None, True),
        (None, ("r1",), "s1", "r1", True),
        (None, ("r1",), "s2", None, False),
        (None, ("r1",), "s2", "r1", False),
        (None, ("r1",), "s1", "r2", False),
        (None, ("free",), "s1", "free", True),
        (None, ("free",), "s1", None, False),
        (None, ("released",), "s1", "released", False),
        (None, ("released",), "s1", None, False),
        (None, ("free", "r2"), "s2", None, True),
        (("s1",), ("free",), "s1", None, True),
        (("s1",), ("r2",), "s1", "r2", False),
        (None, (), "s1", None, False),
    ],
)
def test_a_key_for_robots_changes_sessions_as_one_of_them(
    sessions: tuple[str, ...] | None, robots: tuple[str, ...] | None, session: str, robot: str | None, is_allowed: bool
) -> None:
    own = bound(sessions, robots)
    with nullcontext() if is_allowed else pytest.raises(Forbidden, match="the key 'k'"):
        own.check_acting(session, robot, Claims())


@pytest.mark.parametrize(
    ("sessions", "robots", "seen"),
    [
        (None, None, {"r1", "r2", "free"}),
        (("s1",), None, {"r1", "free"}),
        (None, ("r2",), {"r2"}),
        (("s1",), ("r1", "r2"), {"r1"}),
    ],
)
def test_the_robots_that_a_key_sees(
    sessions: tuple[str, ...] | None, robots: tuple[str, ...] | None, seen: set[str]
) -> None:
    own = bound(sessions, robots)
    sessions_of = {"r1": "s1", "r2": "s2", "free": None}
    assert {robot for robot, session in sessions_of.items() if own.sees_robot(robot, session)} == seen


def test_an_operator_withdraws_any_look_and_others_their_own() -> None:
    assert (BOUND.withdraws_as, ANONYMOUS.withdraws_as) == ("tb3_1", None)


def test_a_key_that_is_not_bound_is_for_all() -> None:
    for call in CALLS:
        ANONYMOUS.check_role(call)
        ANONYMOUS.check_subject(call, "any")
    ANONYMOUS.check_robot("any")


def test_the_message_lists_what_a_program_may_offer() -> None:
    message = BOUND.message()
    assert (message.name, message.role, message.key, message.sessions, message.robots) == (
        "tb3_1",
        "sensor",
        "1234",
        ["s1"],
        ["tb3_1"],
    )
    assert {"scan.apply", "session.get"} <= set(message.calls)
    assert "session.list" in message.calls, "it lists the sessions of the key"
    assert not {"session.create", "outcome.report", "unlisted"} & set(message.calls)
    at = datetime(2027, 1, 1, tzinfo=UTC)
    free = Caller("anna", "operator", "5678", expires_at=at).message()
    assert (free.sessions, free.robots, free.expires_at) == (None, None, at)
    assert free.calls == sorted(call.name for call in CALLS)
