"""The arm: it waits for looks that pay, also those of other robots, and does not grasp where probably nothing lies."""

import json
from collections.abc import Sequence
from typing import Any

import pytest

from tests.voa_client.roles import ANNOUNCED, COLOURS, GRASP, Json, Replies, arm_role, calling, ranked, session, updated
from voa_assets import path
from voa_client import UsageError, Waited
from voa_client._responses import Response

LOOK = ranked("Q1")


def grasps(score: float) -> Response:
    return Response(json.dumps({"version": 0, "grasps": [{"name": "G1", "expected_score": score}]}).encode())


def waiting(
    colour: str,
    scores: Sequence[float],
    rankings: Sequence[Response],
    *sessions: Json,
    now: Sequence[Json] = (),
    timeout_s: float = 5.0,
    **more: float,
) -> tuple[Waited, Replies]:
    """Let the arm wait for a score of 0.9.

    Args:
        colour: of the client.
        scores: of the best grasp, at one version after another.
        rankings: at one after another.
        sessions: further fields of the versions that it receives, from version 0.
        now: fields of the sessions that it requests after it has received the first version.
        timeout_s: longest wait.
        more: further arguments of the wait.
    """
    bodies = [session(version, **fields) for version, fields in enumerate(sessions)]
    replies = Replies(
        {
            "session.get": [
                bodies[0],
                bodies[0],
                *[session(**({"version": 0} | fields)) for fields in now],
                bodies[-1],
            ],
            "grasp.rank": [grasps(score) for score in scores],
            "voa.rank": list(rankings),
            "outcome.report": [updated()],
        },
        tuple(body.body for body in bodies),
    )
    with calling(replies, colour) as client:
        return arm_role(client).wait_until(0.9, timeout_s=timeout_s, **more), replies


@pytest.mark.parametrize("colour", COLOURS)
def test_no_grasp_is_good_enough_while_the_object_is_probably_absent(colour: str) -> None:
    waited, _ = waiting(colour, [0.95], [LOOK], {"absent": 0.8}, {"absent": 0.51}, {"absent": 0.5})
    assert (waited.reason, waited.session.version) == ("score", 2)


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("score", [0.5, 0.95])
def test_where_no_look_pays_either_the_wait_ends_with_that_reason(colour: str, score: float) -> None:
    waited, _ = waiting(colour, [score], [GRASP], {"absent": 0.8})
    assert (waited.reason, waited.session.absent) == ("probably_absent", 0.8)


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize(
    ("absent", "most_absent", "reason"), [(0.8, 0.8, "score"), (0.8, 1.0, "score"), (0.3, 0.2, "probably_absent")]
)
def test_the_caller_may_set_another_limit(colour: str, absent: float, most_absent: float, reason: str) -> None:
    waited, _ = waiting(colour, [0.95], [GRASP], {"absent": absent}, most_absent=most_absent)
    assert waited.reason == reason


@pytest.mark.parametrize("colour", COLOURS)
def test_a_scenario_without_absence_is_as_ever(colour: str) -> None:
    assert waiting(colour, [0.5], [GRASP], {})[0].reason == "no_look_pays"


@pytest.mark.parametrize("colour", COLOURS)
def test_a_look_under_way_that_pays_is_waited_for(colour: str) -> None:
    under_way = {"under_way": [ANNOUNCED]}
    waited, replies = waiting(colour, [0.5, 0.95], [GRASP, LOOK], {}, {}, now=[under_way])
    assert (waited.reason, waited.session.version) == ("score", 1)
    assert replies.payloads("voa.rank") == [
        {"session": "s", "grasps": None},
        {"session": "s", "grasps": None, "pending": []},
    ]


@pytest.mark.parametrize("colour", COLOURS)
def test_a_look_under_way_that_does_not_pay_is_not_waited_for(colour: str) -> None:
    waited, _ = waiting(colour, [0.5], [GRASP], {}, now=[{"under_way": [ANNOUNCED]}])
    assert (waited.reason, waited.session.version) == ("no_look_pays", 0)


@pytest.mark.parametrize("colour", COLOURS)
def test_a_look_that_has_arrived_in_the_meantime_is_taken_into_account(colour: str) -> None:
    waited, _ = waiting(colour, [0.5, 0.95], [GRASP], {}, {}, now=[{"version": 1}])
    assert (waited.reason, waited.session.version) == ("score", 1)


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize(
    ("moved", "sent"), [({}, {}), ({"object_moved": 0.0}, {}), ({"object_moved": 0.3}, {"object_moved": 0.3})]
)
def test_an_outcome_may_say_that_the_object_was_moved(colour: str, moved: Json, sent: Json) -> None:
    replies = Replies({"outcome.report": [updated()]})
    with calling(replies, colour) as client:
        arm_role(client).report("G1", success=False, **moved)
    assert replies.payloads("outcome.report") == [{"session": "s", "grasp": "G1", "success": False} | sent]


def scenario(data: Any) -> Response:
    """The mug's scenario, whose grasp TD90 has other data."""
    body = json.loads(path("mug/scenario.json").read_text(encoding="utf-8"))
    body["grasps"][1]["data"] = data
    return Response(json.dumps(body | {"id": "m", "created_at": "2026-01-01T00:00:00Z"}).encode())


@pytest.mark.parametrize("colour", COLOURS)
def test_the_geometry_of_a_grasp_is_read_from_its_data_with_one_request(colour: str) -> None:
    replies = Replies({"session.get": [session()], "scenario.get": [scenario({"joints": [0.1, 0.2]})]})
    with calling(replies, colour) as client:
        arm = arm_role(client)
        geometry = arm.geometry("OI90")
        assert geometry is not None
        assert (geometry.tool_centre_point, geometry.approach) == ((0.0, 0.052, 0.0475), (0.0, -1.0, 0.0))
        assert arm.geometry("TD90") is None
        with pytest.raises(UsageError, match="the scenario has no grasp 'X'; there are: TD0, TD90, OI90, TDH0"):
            arm.geometry("X")
    assert replies.rpcs() == ["session.get", "scenario.get"]


@pytest.mark.parametrize("colour", COLOURS)
def test_data_that_is_no_geometry_is_refused(colour: str) -> None:
    wrong = {"tool_centre_point": [0, 0, 0], "approach": [0, 0, -1]}
    replies = Replies({"session.get": [session()], "scenario.get": [scenario(wrong)]})
    with (
        calling(replies, colour) as client,
        pytest.raises(UsageError, match=r"'TD90' .* data\.closing: Field required"),
    ):
        arm_role(client).geometry("TD90")
