"""Conformance suite for every transport, sync and async, against the real service."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest

from tests.support.serving import data_scenario, mesh_scenario
from tests.support.waiting import given_time
from tests.voa_client.blocking import is_blocking, role_of
from voa_client import (
    Client,
    InvalidRequestError,
    NotFoundError,
    PoseUncertainty,
    ProblemError,
    SensorClient,
    StaleVersionError,
    UsageError,
    VoaClientError,
    poses_of,
)
from voa_meshes import read_mesh
from voa_msgs import WIRE_VERSION
from voa_msgs.geometry import Candidate, CandidateSensor
from voa_msgs.looks import LookAnnouncement
from voa_msgs.rankings import RankingRequest, VoaRequest
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import (
    BeliefRequest,
    OutcomeRequest,
    Scan,
    ScanRequest,
    SessionRequest,
    UpdatedSession,
    UpdateRequest,
)

GOOD = ScanRequest(sensor="Q1", scan=Scan(ranges=[0.5, 0.5, None, 1.0]))
EMPTY = ScanRequest(sensor="Q1", scan=Scan(ranges=[None] * 4))
END_S = 30.0


def test_the_service_says_how_it_is(client: Client) -> None:
    for health in (client.ready(), client.health()):
        assert (health.status, health.wire_version) == ("ready", WIRE_VERSION)
        assert health.now is not None


def test_a_session_from_beginning_to_end(client: Client, scenario: str) -> None:
    opened = client.create_session(SessionRequest(scenario=scenario))
    assert client.get_session(opened.id) == opened
    assert opened.id in [each.id for each in client.list_sessions()]
    ranking = client.rank_looks(opened.id, VoaRequest(outcomes=True))
    assert ranking.version == 0
    assert ranking.ranking[0].outcomes
    once = client.update_once(UpdateRequest(scenario=scenario, belief=opened.belief, sensor="Q1", scan=GOOD.scan))
    after = client.apply_scan(opened.id, GOOD)
    assert isinstance(after, UpdatedSession)
    assert after.belief == once.belief != opened.belief
    assert client.rank_once(RankingRequest(scenario=scenario, belief=after.belief)).version is None
    assert [grasp.name for grasp in client.rank_grasps(opened.id, ["G2"]).grasps] == ["G2"]
    assert len(client.rank_grasps(opened.id).grasps) == 2
    assert client.report_outcome(opened.id, OutcomeRequest(grasp="G1", success=False)).version == 2
    assert client.put_belief(opened.id, BeliefRequest(belief=None)).belief == opened.belief
    kinds = [entry.kind for entry in client.history(opened.id)]
    assert kinds == ["prior", "scan", "outcome", "belief"]
    client.delete_session(opened.id)
    with pytest.raises(NotFoundError, match=opened.id):
        client.get_session(opened.id)


def test_objects_and_scenarios(client: Client, box: Path) -> None:
    stored = client.create_object(box, "crate", 2.0)
    assert stored.name == "crate"
    assert stored.extents == pytest.approx([0.08, 0.12, 0.10])
    assert client.create_object(box, scale=2.0).id == stored.id
    turned = client.create_object(box, "crate", 2.0, "+Y")
    assert (stored.up, turned.up) == ("+Z", "+Y")
    assert turned.extents == pytest.approx([0.08, 0.10, 0.12])
    assert client.get_object(stored.id) == stored
    result = [client.find_object(box, 2.0), client.find_object(box, 2.0, "+Y")]
    assert [each and each.model_copy(update={"sha256": None}) for each in result] == [stored, turned]
    assert client.find_object(box, 3.0) is None
    assert stored in list(client.list_objects())
    assert client.stable_poses(stored.id).items
    mesh = read_mesh(client.object_mesh(stored.id), "stl")
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.08, 0.12, 0.10])
    assert client.object_mesh(stored.id, most_faces=100) == client.object_mesh(stored.id)
    made = client.create_scenario(ScenarioRequest.model_validate(mesh_scenario(stored.id)))
    assert client.get_scenario(made.id) == made
    assert made.id in [each.id for each in client.list_scenarios()]
    predicted = client.predict(made.id, PredictionsRequest(sensors=["E"]))
    assert (predicted.sensors, len(predicted.ranges[0])) == (["E"], 2)
    assert len(client.predict(made.id).sensors) == 2
    assert "lds-01" in [preset.name for preset in client.lidars().items]


def test_lists_longer_than_a_page_come_whole(client: Client, session: str) -> None:
    for _ in range(105):
        client.put_belief(session, BeliefRequest(belief=[0.2, 0.3, 0.5]))
    assert [entry.version for entry in client.history(session)] == list(range(106))
    beliefs = [entry.belief for entry in client.history(session, beliefs=True)]
    assert beliefs[1:] == [[0.2, 0.3, 0.5]] * 105
    assert {entry.belief for entry in client.history(session)} == {None}
    assert [entry.version for entry in client.history(session, after=102)] == [103, 104, 105]


def test_robots(client: Client) -> None:
    assert client.robots().items == []
    with pytest.raises(NotFoundError):
        client.request_look("nobody")
    with pytest.raises(NotFoundError, match="no scan of robot 'nobody'"):
        client.robot_scan("nobody")


def test_a_robot_is_claimed_over_http_and_said_to_be_so_elsewhere(client: Client, way: str, session: str) -> None:
    for claimed in (session, None):
        if way.startswith("http"):
            with pytest.raises(NotFoundError, match="no mapped robot 'nobody'"):
                client.claim_robot("nobody", claimed)
        else:
            with pytest.raises(UsageError, match="can be called over HTTP only"):
                client.claim_robot("nobody", claimed)


def test_a_session_for_robots_that_are_not_mapped_is_not_opened(client: Client, scenario: str) -> None:
    with pytest.raises(InvalidRequestError, match="no mapped robot 'nobody'"):
        client.create_session(SessionRequest(scenario=scenario, robots=["nobody"]))


def test_no_belief_is_the_scenario_s_prior(client: Client, scenario: str, session: str) -> None:
    ranking = client.rank_once(RankingRequest(scenario=scenario, belief=None))
    assert ranking == client.rank_looks(session).model_copy(update={"version": None})
    once = client.update_once(UpdateRequest(scenario=scenario, belief=None, sensor="Q1", scan=GOOD.scan))
    assert once.belief == client.apply_scan(session, GOOD).belief


@pytest.mark.parametrize("odd", ["nothing", "a/b", "..", ".", "%2F", "*", "**", "$*", "a b", "ä", "a?b=c#d"])
def test_an_unknown_id_is_refused_whatever_it_looks_like(client: Client, odd: str) -> None:
    for call in (client.get_session, client.get_scenario, client.get_object, client.delete_session):
        with pytest.raises(NotFoundError) as refused:
            call(odd)
        assert refused.value.kind == "not-found"
    with pytest.raises(NotFoundError):
        next(iter(client.follow(odd)))


def test_an_empty_id_is_not_sent(client: Client) -> None:
    with pytest.raises(UsageError, match="session"):
        client.get_session("")


def test_a_refusal_says_why(client: Client, session: str) -> None:
    with pytest.raises(InvalidRequestError) as refused:
        client.apply_scan(session, ScanRequest(sensor="Q9", scan=GOOD.scan))
    assert (refused.value.kind, refused.value.problem.known) == ("unknown-name", ["Q1", "Q2"])
    assert refused.value.problem.request_id
    with pytest.raises(InvalidRequestError, match="belief"):
        client.put_belief(session, BeliefRequest(belief=[0.5, 0.5]))


def test_the_same_key_takes_effect_once(client: Client, other: Client, session: str, scenario: str) -> None:
    first = client.apply_scan(session, GOOD, key="look 1")
    assert other.apply_scan(session, GOOD, key="look 1") == first
    assert client.get_session(session).version == 1
    with pytest.raises(ProblemError) as refused:
        client.apply_scan(session, EMPTY, key="look 1")
    assert refused.value.kind == "idempotency-key-reused"
    assert client.apply_scan(session, GOOD).version == 2, "a new key each time"
    request = SessionRequest(scenario=scenario)
    named = f"{session} begins"
    assert client.create_session(request, key=named).id == other.create_session(request, key=named).id


@pytest.mark.parametrize("key", ["", "x" * 256, "ä", "a\nb"])
def test_a_key_that_cannot_be_sent_is_refused_here(client: Client, session: str, key: str) -> None:
    with pytest.raises(UsageError, match="key"):
        client.apply_scan(session, GOOD, key=key)


def test_a_scan_that_is_not_accepted_says_so(client: Client, session: str) -> None:
    answer = client.apply_scan(session, EMPTY)
    assert (answer.update.accepted, answer.update.reason, answer.version) == (False, "no_beams", 0)


def test_a_write_can_require_a_version(client: Client, way: str, session: str) -> None:
    if not way.startswith("http"):
        with pytest.raises(UsageError, match="over HTTP"):
            client.apply_scan(session, GOOD, if_match=0)
        return
    assert client.apply_scan(session, GOOD, if_match=0).version == 1
    with pytest.raises(StaleVersionError) as stale:
        client.report_outcome(session, OutcomeRequest(grasp="G1", success=True), if_match=0)
    assert stale.value.version == 1
    with pytest.raises(StaleVersionError):
        client.put_belief(session, BeliefRequest(belief=None), if_match=7)
    with pytest.raises(StaleVersionError):
        client.delete_session(session, if_match=0)
    client.delete_session(session, if_match=1)


def test_followers_see_the_state_then_each_newer_version_until_the_end(
    client: Client, other: Client, session: str
) -> None:
    other.apply_scan(session, GOOD)
    seen = []
    for followed in client.follow(session):
        seen.append(followed)
        if len(seen) < 4:
            other.apply_scan(session, GOOD)
        elif len(seen) == 4:
            other.delete_session(session)
    assert [each.version for each in seen] == [1, 2, 3, 4]
    assert type(seen[0]).__name__ == "Session"


def test_followers_in_a_crowd_miss_no_last_version_and_see_none_twice(
    client: Client, other: Client, session: str
) -> None:
    def write() -> None:
        for _ in range(30):
            other.put_belief(session, BeliefRequest(belief=[0.2, 0.3, 0.5]))

    writing = threading.Thread(target=write)
    versions: list[int] = []
    for followed in client.follow(session, END_S):
        if not versions:
            writing.start()
        versions.append(followed.version or 0)
        if followed.version == 30:
            break
    writing.join()
    assert versions == sorted(set(versions))
    assert (versions[0], versions[-1]) == (0, 30)


def test_following_ends_in_time(client: Client, session: str) -> None:
    def followed(seconds: float) -> tuple[list[int | None], float]:
        began = time.monotonic()
        return [each.version for each in client.follow(session, seconds)], (time.monotonic() - began) / seconds

    versions, share = given_time(followed)
    assert versions == [0]
    assert 1.0 <= share < 25.0


def test_the_sensor_drives_where_it_is_worth_most_until_grasping_is_better(client: Client, session: str) -> None:
    sensor = role_of(client, "sensor", session)
    been: list[str] = []
    ranges = data_scenario()["predictions"]["Q1"]["P2"]

    def drive(name: str) -> None:
        been.append(name)

    def take_scan() -> Scan:
        return Scan(ranges=ranges, no_return=[1, 2])

    async def drive_there(name: str) -> None:
        drive(name)

    async def take_it() -> Scan:
        return take_scan()

    sync = not is_blocking(client)
    advice = sensor.where_to_look()
    assert (advice.action, advice.sensor) == ("look", "Q1")
    tour = sensor.run(drive if sync else drive_there, take_scan if sync else take_it, ["Q1"], most_looks=6)
    assert been == ["Q1"] * len(tour.looks)
    assert len(tour.looks) == 6 or tour.advice.action == "grasp"
    assert tour.looks[-1].after.version == len(tour.looks)
    assert tour.looks[-1].after.best_grasp == "G2"
    sent = sensor.send_scan(Scan(ranges=ranges), "Q1", key="again")
    assert sensor.send_scan(Scan(ranges=ranges), "Q1", key="again") == sent


def test_the_sensor_sends_along_a_pose_that_the_scenario_does_not_know(client: Client, box: Path) -> None:
    made = client.create_scenario(ScenarioRequest.model_validate(mesh_scenario(client.create_object(box).id)))
    session = client.create_session(SessionRequest(scenario=made.id)).id
    places = [
        CandidateSensor(x=0.3, y=0.0, yaw_rad=3.141592653589793),
        CandidateSensor(name="far", x=3, y=3, yaw_rad=0),
    ]
    sensor = role_of(client, "sensor", session)
    taken = client.predict(made.id, PredictionsRequest(sensors=list(places))).ranges[0][0]
    scan = Scan(ranges=taken, no_return=[index for index, value in enumerate(taken) if value is None])

    async def drive(name: str) -> None:
        assert name == "0"

    async def take_scan() -> Scan:
        return scan

    if is_blocking(client):
        tour = sensor.run(drive, take_scan, places, most_looks=1)
    else:
        tour = sensor.run(lambda name: None, lambda: scan, places, most_looks=1)
    (look,) = tour.looks
    assert look.sensor == "0"
    (entry,) = [each for each in client.history(session) if each.kind == "scan"]
    assert isinstance(entry.request, dict)
    assert entry.request["sensor_pose"] == {"x": 0.3, "y": 0.0, "yaw_rad": 3.141592653589793, "height_m": None}


def test_the_arm_waits_for_a_score_or_for_looks_to_stop_paying(client: Client, other: Client, session: str) -> None:
    arm = role_of(client, "arm", session)
    assert given_time(lambda seconds: arm.wait_until(0.9, timeout_s=seconds)).reason == "timeout"
    assert arm.wait_until(0.2).reason == "score"
    other.put_belief(session, BeliefRequest(belief=[1.0, 0.0, 0.0]))
    done = arm.wait_until(0.95)
    assert (done.reason, done.session.version, done.session.best_grasp) == ("no_look_pays", 1, "G1")
    assert arm.best_grasp().name == "G1"
    assert arm.best_grasp(["G2"]).name == "G2"
    assert arm.wait_until(0.85).reason == "score"
    assert arm.wait_until(0.85, ["G2"]).reason == "no_look_pays"
    assert arm.report("G1", success=True, key="attempt 1") == arm.report("G1", success=True, key="attempt 1")
    assert given_time(lambda seconds: [each.version for each in arm.follow(seconds)]) == [2]


def test_the_arm_learns_that_the_session_has_ended(client: Client, other: Client, session: str) -> None:
    arm = role_of(client, "arm", session)
    ending = threading.Timer(0.3, other.delete_session, [session])
    began = time.monotonic()
    ending.start()
    done = arm.wait_until(0.99, timeout_s=END_S)
    assert time.monotonic() - began < 2.5, "the deletion is published, not polled for"
    ending.join()
    assert (done.reason, done.session.version) == ("deleted", 0)
    with pytest.raises(VoaClientError):
        arm.best_grasp()


def test_announced_looks_are_listed_until_they_end(client: Client, other: Client, session: str) -> None:
    look = client.announce_look(session, LookAnnouncement(sensor="Q1", robot="scout"), key="announcement 1")
    assert (look.sensor, look.sensor_pose, look.robot) == ("Q1", None, "scout")
    assert look.expires_at > client.get_session(session).created_at
    assert client.announce_look(session, LookAnnouncement(sensor="Q1", robot="scout"), key="announcement 1") == look
    second = client.announce_look(session, LookAnnouncement(sensor="Q2"))
    assert other.get_session(session).under_way == [look, second]
    assert other.get_session(session).version == 0
    client.cancel_look(session, second.id)
    assert other.get_session(session).under_way == [look]
    with pytest.raises(NotFoundError):
        client.cancel_look(session, second.id)
    assert client.apply_scan(session, GOOD).under_way == []
    with pytest.raises(InvalidRequestError, match="Q9"):
        client.announce_look(session, LookAnnouncement(sensor="Q9"))
    with pytest.raises(NotFoundError):
        client.announce_look("nothing", LookAnnouncement(sensor="Q1"))


def test_robots_see_each_other_s_looks_under_way(client: Client, other: Client, session: str) -> None:
    """The second robot ranks looks by what they add to that of the first."""
    first, second = role_of(client, "sensor", session, robot="first"), SensorClient(other, session, robot="second")
    assert second.where_to_look().action == "look"
    seen: list[str | None] = []
    ranked: list[dict[str, float]] = []

    def drive(name: str) -> None:
        under_way = other.get_session(session).under_way
        seen.extend(look.robot for look in under_way)
        others: tuple[list[Candidate] | None, ...] = (None, [name], [])
        values = (other.rank_looks(session, VoaRequest(pending=pending)) for pending in others)
        ranked.extend({look.sensor: look.voa for look in ranking.ranking} for ranking in values)

    async def drive_there(name: str) -> None:
        drive(name)

    async def take_it() -> Scan:
        return GOOD.scan

    if is_blocking(client):
        first.run(drive_there, take_it, most_looks=1)
    else:
        first.run(drive, lambda: GOOD.scan, most_looks=1)
    assert seen == ["first"]
    pending, stated, alone = ranked
    assert pending == stated
    assert pending != alone
    assert client.get_session(session).under_way == []


def test_a_failed_drive_leaves_no_announcement(client: Client, session: str) -> None:
    sensor = role_of(client, "sensor", session)

    def stuck(_name: str) -> None:
        assert len(client.get_session(session).under_way) == 1
        raise RuntimeError("stuck")

    async def stuck_too(_name: str) -> None:
        raise RuntimeError("stuck")

    with pytest.raises(RuntimeError, match="stuck"):
        sensor.run(stuck_too if is_blocking(client) else stuck, lambda: GOOD.scan)
    assert client.get_session(session).under_way == []


def test_an_attempt_that_moved_the_object_mixes_the_prior_in(client: Client, session: str) -> None:
    prior = client.get_session(session).belief
    looked = client.apply_scan(session, GOOD)
    assert looked.places
    moved = role_of(client, "arm", session).report("G1", success=False, object_moved=1.0)
    assert moved.belief == pytest.approx(prior)
    assert moved.places == []


def test_a_probably_absent_object_is_not_grasped(client: Client) -> None:
    made = client.create_scenario(ScenarioRequest.model_validate(data_scenario(name="maybe", absent=0.9)))
    session = client.create_session(SessionRequest(scenario=made.id, prior=[1.0, 0.0, 0.0])).id
    arm = role_of(client, "arm", session)
    waited = arm.wait_until(0.5)
    assert (waited.reason, waited.session.absent) == ("probably_absent", pytest.approx(0.9))
    assert arm.wait_until(0.5, most_absent=0.95).reason == "score"
    ranking = client.rank_looks(session)
    assert "probably-absent" in [warning.kind for warning in ranking.warnings]
    once = client.update_once(UpdateRequest(scenario=made.id, belief=None, absent=0.2, sensor="Q1", scan=GOOD.scan))
    assert once.absent is not None
    assert once.absent < 0.2
    assert client.rank_once(RankingRequest(scenario=made.id, belief=None, absent=0.2)).warnings == []


def test_a_tour_states_the_robot_s_errors_and_drives(client: Client, box: Path) -> None:
    made = client.create_scenario(ScenarioRequest.model_validate(mesh_scenario(client.create_object(box).id)))
    session = client.create_session(SessionRequest(scenario=made.id)).id
    ranges = client.predict(made.id, PredictionsRequest(sensors=["E"])).ranges[0][0]
    scan = Scan(ranges=ranges, no_return=[index for index, value in enumerate(ranges) if value is None])
    std = PoseUncertainty(xy_m=0.005, yaw_rad=0.02)
    sensor = role_of(client, "sensor", session, sensor_std=std, cost_per_m=0.001)

    async def drive(name: str) -> None:
        assert name == "E"

    async def take_scan() -> Scan:
        return scan

    if is_blocking(client):
        tour = sensor.run(drive, take_scan, ["E"], most_looks=2, stands_at="E")
    else:
        tour = sensor.run(lambda name: None, lambda: scan, ["E"], most_looks=2, stands_at="E")
    assert tour.looks
    after = client.get_session(session)
    (place,) = after.places
    assert (place.sensor, place.looks) == (None, len(tour.looks))
    ranking = client.rank_looks(session, VoaRequest(sensors=[poses_of(made)[0]]))
    assert (ranking.scans, ranking.ranking[0].looks_taken) == ("simulated", len(tour.looks))
