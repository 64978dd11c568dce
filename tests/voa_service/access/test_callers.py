"""Callers: what their role allows, and which sessions and robots their key is for."""

from datetime import UTC, datetime

import pytest

from voa_msgs.callers import Role
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.roles import BY_NAME, CALLS
from voa_service.failures import Forbidden

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
    for name, subject in (("scan.apply", "s2"), ("robot.look", "tb3_2"), ("session.list", None)):
        with pytest.raises(Forbidden, match="'tb3_1' is"):
            BOUND.check_subject(BY_NAME[name], subject)
    with pytest.raises(Forbidden):
        BOUND.check_robot("tb3_2")
    BOUND.check_robot(None)


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
    assert not {"session.list", "outcome.report", "unlisted"} & set(message.calls)
    at = datetime(2027, 1, 1, tzinfo=UTC)
    free = Caller("anna", "operator", "5678", expires_at=at).message()
    assert (free.sessions, free.robots, free.expires_at) == (None, None, at)
    assert free.calls == sorted(call.name for call in CALLS)
