"""The robot that carries the lidar: its looks are announced, and a failure ends the announcement."""

import asyncio
import json

import pytest

from tests.support.serving import mesh_scenario
from tests.voa_client.roles import (
    ANNOUNCED,
    COLOURS,
    GRASP,
    NOT_THERE,
    AsyncReplies,
    Json,
    Replies,
    Robot,
    calling,
    ranked,
    sensor_role,
    session,
    updated,
)
from tests.voa_client.test_attempts import problem
from voa_client import (
    AsyncClient,
    AsyncSensorClient,
    CandidateSensor,
    Location,
    NotFoundError,
    PoseUncertainty,
    ProblemError,
    Scan,
    UnreachableError,
)
from voa_client._responses import Response

STD = PoseUncertainty(xy_m=0.01, yaw_rad=0.02)
LOOK = Response(json.dumps(ANNOUNCED).encode())
DONE = Response(b"")


def service(**replies: Response | BaseException | list[Response | BaseException]) -> Replies:
    """A service that recommends one look from Q1, then to grasp; `replies` by call, as in `voa_rank`."""
    usual: dict[str, list[Response | BaseException]] = {
        "voa.rank": [ranked("Q1"), GRASP],
        "look.announce": [LOOK],
        "look.cancel": [DONE],
        "scan.apply": [updated()],
        "session.get": [session()],
    }
    given = {
        name.replace("_", ".", 1): reply if isinstance(reply, list) else [reply] for name, reply in replies.items()
    }
    return Replies(usual | given)


@pytest.mark.parametrize("colour", COLOURS)
def test_a_look_is_announced_before_the_drive_and_ended_by_its_scan(colour: str) -> None:
    replies, robot = service(), Robot()
    with calling(replies, colour) as client:
        tour = robot.run(client, role=sensor_role(client, robot="scout"))
    assert robot.been == ["Q1"]
    assert replies.rpcs() == ["voa.rank", "look.announce", "scan.apply", "voa.rank"]
    assert replies.payloads("look.announce") == [{"session": "s", "sensor": "Q1", "robot": "scout"}]
    assert (tour.advice.action, tour.warnings) == ("grasp", ())


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("failure", [RuntimeError("stuck"), KeyboardInterrupt(), ProcessLookupError()])
@pytest.mark.parametrize("where", ["drive", "scan"])
def test_a_failure_on_the_way_ends_the_announcement(colour: str, failure: BaseException, where: str) -> None:
    robot = Robot(failure=failure) if where == "drive" else Robot(blind=failure)
    replies = service()
    with calling(replies, colour) as client, pytest.raises(type(failure)):
        robot.run(client)
    assert replies.rpcs() == ["voa.rank", "look.announce", "look.cancel"]
    assert replies.payloads("look.cancel") == [{"session": "s", "look": "look-1"}]


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("cancelled", [DONE, NOT_THERE, UnreachableError("gone")])
def test_a_scan_that_fails_ends_the_announcement_and_is_raised_whatever_that_gives(
    colour: str, cancelled: Response | BaseException
) -> None:
    replies = service(scan_apply=problem("beam-grid-mismatch", 422), look_cancel=cancelled)
    with calling(replies, colour) as client, pytest.raises(ProblemError, match="because") as refused:
        Robot().run(client)
    assert refused.value.kind == "beam-grid-mismatch"
    assert replies.rpcs()[-1] == "look.cancel"


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("under_way", [[], [ANNOUNCED | {"id": "of another robot"}], [ANNOUNCED]])
def test_an_announcement_that_a_refused_scan_leaves_is_ended(colour: str, under_way: list[Json]) -> None:
    replies = service(scan_apply=updated(0, accepted=False, under_way=under_way))
    with calling(replies, colour) as client:
        Robot().run(client)
    assert ("look.cancel" in replies.rpcs()) is (under_way == [ANNOUNCED])


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("refusal", [NOT_THERE, problem("method-not-allowed", 405)])
def test_an_older_service_gets_no_announcements(colour: str, refusal: Response) -> None:
    replies, robot = service(voa_rank=[ranked("Q1"), ranked("Q2"), GRASP], look_announce=refusal), Robot()
    with calling(replies, colour) as client:
        tour = robot.run(client)
    assert robot.been == ["Q1", "Q2"]
    assert len(tour.looks) == 2
    assert replies.rpcs().count("look.announce") == 1
    assert all(payload.keys() <= {"session", "sensors", "grasps"} for payload in replies.payloads("voa.rank"))


@pytest.mark.parametrize("colour", COLOURS)
def test_a_session_that_does_not_exist_is_no_older_service(colour: str) -> None:
    replies, robot = service(look_announce=NOT_THERE, session_get=NOT_THERE), Robot()
    with calling(replies, colour) as client, pytest.raises(NotFoundError):
        robot.run(client)
    assert robot.been == []


@pytest.mark.parametrize("colour", COLOURS)
def test_a_refused_announcement_is_raised_before_the_drive(colour: str) -> None:
    replies, robot = service(look_announce=problem("forbidden", 403)), Robot()
    with calling(replies, colour) as client, pytest.raises(ProblemError):
        robot.run(client)
    assert robot.been == []


@pytest.mark.parametrize("colour", COLOURS)
def test_both_looks_of_a_pair_are_taken(colour: str) -> None:
    replies = service(voa_rank=[ranked("Q1", then="Q2"), ranked(None, Q2=0.001), ranked(None, Q2=0.001)])
    robot = Robot()
    with calling(replies, colour) as client:
        tour = robot.run(client)
    assert robot.been == ["Q1", "Q2"]
    assert tour.advice.action == "grasp"


@pytest.mark.parametrize("colour", COLOURS)
def test_a_robot_that_states_its_errors_and_its_costs_does_so_in_each_request(colour: str) -> None:
    scenario = Response(json.dumps(mesh_scenario("box", id="c", created_at="2026-01-01T00:00:00Z")).encode())
    replies = service(voa_rank=[ranked("E"), ranked("0"), GRASP])
    replies.by_rpc["scenario.get"] = [scenario]
    places = ["E", CandidateSensor(name="0", x=0.0, y=0.4, yaw_rad=0.0)]
    with calling(replies, colour) as client:
        role = sensor_role(client, sensor_std=STD, cost_per_m=0.1)
        Robot().run(client, places, role=role, stands_at=Location(x=1.0, y=1.0))
        role.where_to_look(places, ["G1"], stands_at="E")
    std = {"xy_m": 0.01, "yaw_rad": 0.02}
    first, second, third, question = replies.payloads("voa.rank")
    assert [first["from"], second["from"], third["from"], question["from"]] == [
        {"x": 1.0, "y": 1.0},
        {"x": 0.3, "y": 0.0},
        {"x": 0.0, "y": 0.4},
        "E",
    ]
    for payload in (first, second, third, question):
        assert (payload["sensor_std"], payload["cost_per_m"]) == (std, 0.1)
        assert [each["name"] for each in payload["sensors"]] == ["E", "0"]
    assert question["grasps"] == ["G1"]
    for rpc in ("look.announce", "scan.apply"):
        poses = [payload["sensor_pose"] for payload in replies.payloads(rpc)]
        assert [(pose["x"], pose["std"]) for pose in poses] == [(0.3, std), (0.0, std)]


def test_a_cancelled_tour_ends_its_announcement() -> None:
    replies = service()

    async def never(_name: str) -> None:
        await asyncio.Event().wait()

    async def take_scan() -> Scan:
        raise AssertionError("the robot never arrives")

    async def story() -> None:
        async with AsyncClient(AsyncReplies(replies)) as client:
            tour = asyncio.create_task(AsyncSensorClient(client, "s").run(never, take_scan))
            while "look.announce" not in replies.rpcs():
                await asyncio.sleep(0)
            tour.cancel()
            with pytest.raises(asyncio.CancelledError):
                await tour

    asyncio.run(story())
    assert replies.rpcs()[-1] == "look.cancel"
