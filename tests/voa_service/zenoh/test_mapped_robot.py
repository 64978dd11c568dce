"""Looks of mapped robots on the bus: what becomes of one is published, counted and shown, and none is lost."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import zenoh
from zenoh.ext import CacheConfig, declare_advanced_publisher

from tests.support.audit import audited
from tests.support.bus import Sample
from tests.support.replaying import replayed
from tests.support.routers import Router
from tests.support.serving import Json, box_obj, data_scenario, mesh_scenario, scan_of
from tests.support.waiting import wait_for
from tests.voa_service.zenoh.ros_lab import GOOD, Lab, lab, laser_scan, odometry, robot
from voa_msgs.links import session_config
from voa_ros.cdr import decode_laser_scan, encode_laser_scan, encode_pose
from voa_ros.messages import Pose, PoseWithCovariance, Stamp
from voa_ros.topics import POSE_WITH_COVARIANCE_STAMPED, rmw_key
from voa_service.mapping.looks import record_of
from voa_service.zenoh.mailboxes import Mailboxes
from voa_service.zenoh.replicas import Replicas
from voa_store.errors import Busy

NOTHING = (0.0, 0.0, 0.0, 0.0)
"""As a lidar sends that spins up: no look of it is accepted."""
REFUSED = "urn:voa:problem:not-accepted"


def on(scenario: str, look: str = "{ scans = 3 }") -> str:
    """The mapping of a robot to a scenario."""
    return robot("", look=look).replace('session = ""', f'scenario = "{scenario}"')


def problems(received: list[Sample], type_: str = REFUSED) -> list[Json]:
    return [sample.json for sample in received if sample.json["type"] == type_]


def events(own: Lab, event: str) -> int:
    """Count of an event on Zenoh, from the service's metrics."""
    lines = own.service.http.get("/metrics").text.splitlines()
    counters = [line for line in lines if "_total" in line and f'event="{event}"' in line]
    return sum(int(float(line.split()[-1])) for line in counters)


def test_a_look_that_is_not_accepted_is_published_counted_and_shown_and_the_next_scans_make_another(
    own: Lab, session: str
) -> None:
    own.map(robot(session, look="{ scans = 3 }"))
    received = own.bus.subscribe(own.bus.keys.refused(session, "tb3_1"))
    own.revolutions(4, ranges=NOTHING)
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    shown = own.report()
    assert shown["last_refusal"].startswith("not-accepted: the belief is unchanged, no_beams")
    assert (shown["looks"], shown["last_look"]["accepted"], shown["last_look"]["reason"]) == (1, False, "no_beams")
    assert shown["last_look"]["version"] == own.version(session) == 0
    assert shown["waiting_for"].endswith("; the last look was not accepted (no_beams)")
    assert events(own, "ROS message refused: not-accepted") == 1

    own.revolutions(3, first=10)  # of the same stop
    wait_for(lambda: own.report()["looks"] == 2, "the look, which is counted after its commit")
    assert own.version(session) == 1
    shown = own.report()
    assert (shown["looks"], shown["refused"], shown["last_look"]["accepted"]) == (2, 1, True)
    assert shown["waiting_for"] == "the robot to move on: this stop's look is taken"
    own.revolutions(6, first=20)
    assert own.version(session) == 1
    (problem,) = problems(received)
    assert (problem["reason"], problem["status"]) == ("no_beams", 422)


def test_a_requested_look_that_is_not_accepted_stays_requested(own: Lab, session: str) -> None:
    own.map(robot(session, look='{ mode = "on_request", scans = 3 }'))
    own.service.http.post("/v1/robots/tb3_1/look").raise_for_status()
    own.revolutions(3, ranges=NOTHING)
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    own.revolutions(3, first=10)
    wait_for(lambda: own.version(session) == 1, "the look")
    own.revolutions(6, first=20)
    assert (own.version(session), own.report()["waiting_for"]) == (1, "a request")


@pytest.mark.parametrize("body", [scan_of([None] * 4), laser_scan(NOTHING, 100.0)])
def test_a_raw_scan_that_is_not_accepted_is_published_too(own: Lab, session: str, body: bytes | Json) -> None:
    received = own.bus.subscribe(own.bus.keys.refused(session, "r1"))
    beside: Json = {"sensor": "Q1"} if isinstance(body, bytes) else {}
    own.bus.put_scan(session, body, **beside)
    wait_for(lambda: received, "the refusal")
    (problem,) = problems(received)
    assert problem["reason"] == "no_beams"
    (report,) = own.reports()
    assert (report["looks"], report["refused"], report["last_look"]["accepted"]) == (1, 1, False)
    assert report["last_refusal"].startswith("not-accepted: ")
    own.bus.put_scan(session, scan_of([0.5, 0.5, None, 1.0]))
    wait_for(lambda: own.version(session) == 1, "the next scan")
    assert (len(received), own.reports()[0]["refused"]) == (1, 1)


def contradicting() -> bytes:
    """A scan whose increment has the other sign than its angles."""
    scan = decode_laser_scan(laser_scan(GOOD, 100.0))
    return encode_laser_scan(replace(scan, angle_increment=-scan.angle_increment))


def test_a_header_that_contradicts_itself_is_refused_with_both_numbers(own: Lab, session: str) -> None:
    received = own.bus.subscribe(own.bus.keys.refused(session, "*"))
    own.map(robot(session))
    own.bus.put_scan(session, contradicting(), sensor="Q1")
    own.put("tb3_1/scan", contradicting())
    wait_for(lambda: len(received) == 2, "both refusals")
    assert {sample.json["type"] for sample in received} == {"urn:voa:problem:beam-grid-mismatch"}
    assert all("-0.1" in sample.json["detail"] and "0.3" in sample.json["detail"] for sample in received)
    assert own.version(session) == 0


def amcl(x: float) -> bytes:
    return encode_pose(PoseWithCovariance(Stamp.of(7.0), "map", Pose.planar(x, 0.0, 0.0)))


@contextmanager
def keeping(endpoint: str, key: str, payload: bytes) -> Iterator[None]:
    """A publisher that keeps its last message for those who come later, and has put one."""
    config = zenoh.Config()
    for path, value in session_config([endpoint], open_ms=5_000).items():
        config.insert_json5(path, json.dumps(value))
    config.insert_json5("timestamping/enabled", "true")
    with zenoh.open(config) as session:
        publisher = declare_advanced_publisher(session, key, cache=CacheConfig(max_samples=1), publisher_detection=True)
        publisher.put(payload)
        yield


@pytest.mark.parametrize("key", ["tb3_1/amcl_pose", rmw_key("tb3_1/amcl_pose", POSE_WITH_COVARIANCE_STAMPED)])
@pytest.mark.parametrize("late", [False, True])
def test_a_pose_that_was_published_before_the_mapping_is_fetched(
    own: Lab, own_router: Router, key: str, late: bool
) -> None:
    box = own.service.upload(box_obj())
    scenario = mesh_scenario(box, lidar={"preset": "lds-01", "beams": 4, "angle_increment": 0.1, "height_m": 0.02})
    session = own.service.open(own.service.create(scenario))
    mapped = f'name = "tb3_1"\nsession = "{session}"\nlook = {{ mode = "every" }}\n[robot.place]\nfrom = "amcl"\n'
    if late:
        own.map(mapped)
    with keeping(own_router.endpoint, key, amcl(1.5)):
        if not late:
            own.map(mapped)
        turns = iter(range(1_000))

        def looked() -> bool:
            turn = next(turns)
            own.put("tb3_1/odom", odometry(0.0, 0.0, 0.0, 100.0 + 0.2 * turn))
            own.put("tb3_1/scan", laser_scan([0.3] * 4, 100.0 + 0.2 * turn))
            return own.version(session) > 0

        wait_for(looked, "the look")
    assert own.last_request(session)["sensor_pose"]["x"] == 1.5


def test_looks_by_odometry_share_a_place_as_unsure_as_the_mapping_says(own: Lab) -> None:
    lidar = {"preset": "lds-01", "beams": 4, "angle_increment": 0.1, "height_m": 0.02}
    session = own.service.open(own.service.create(mesh_scenario(own.service.upload(box_obj()), lidar=lidar)))
    own.map(
        f'name = "tb3_1"\nsession = "{session}"\nlook = {{ mode = "every" }}\n'
        '[robot.place]\nfrom = "odometry"\nstd = { xy_m = 0.01, yaw_rad = 0.02 }\n'
    )
    own.service.post(f"/v1/sessions/{session}/looks", {"sensor_pose": {"x": 0.3, "y": 0.0, "yaw_rad": 3.1}})
    for number, x in enumerate((0.3, 0.31, 0.5), start=1):
        own.put("tb3_1/odom", odometry(x, 0.0, 3.1, 100.0 + number))
        own.put("tb3_1/scan", laser_scan([0.28] * 4, 100.0 + number))
        wait_for(lambda number=number: own.version(session) == number, "the look")  # type: ignore[misc] # bound in each round, which mypy cannot infer
    assert own.last_request(session)["sensor_pose"]["std"] == {"xy_m": 0.01, "yaw_rad": 0.02}
    state = own.service.get(f"/v1/sessions/{session}")
    assert [place["looks"] for place in state["places"]] == [2, 1]
    assert state["places"][0]["sensor_pose"]["x"] == pytest.approx(0.3)
    assert state["under_way"] == [], "a look by the robot ends what it has announced"
    places = record_of(own.service.inside.sessions.state(session).looks).places
    assert [place.copies for place in places] == [64, 64]
    ranking = own.service.get(f"/v1/sessions/{session}/voa")
    assert ranking["scans"] == "simulated"
    assert ranking == own.service.post(f"/v1/sessions/{session}/voa", {"sensor_std": {"xy_m": 0.01, "yaw_rad": 0.02}})
    entries = own.service.inside.sessions.store.history(session, -1, 9)
    scenario = own.service.inside.sessions.model_of(entries[-1].state).scenario
    *_, estimate = replayed(scenario, entries)
    assert state["belief"] == estimate.belief.p.tolist()


@pytest.mark.parametrize(
    ("to", "what"),
    [('session = "nothing"', "there is no session 'nothing'"), ('scenario = "nothing"', "there is no scenario")],
)
def test_a_mapping_of_what_is_not_there_is_shown_and_only_its_scans_are_refused(own: Lab, to: str, what: str) -> None:
    own.map(f'name = "tb3_1"\n{to}\n[robot.place]\nfrom = "odometry"\n')
    assert own.report()["waiting_for"] == "a scan"
    for turn in range(50):
        own.put("tb3_1/odom", odometry(0.0, 0.0, 0.0, 100.0 + 0.02 * turn))
    own.revolutions(2)
    wait_for(lambda: own.report()["refused"] == 2, "the refusals")
    assert own.report()["last_refusal"].startswith("not-found: " + what)
    assert own.report()["waiting_for"].startswith("the mapping's scenario or session: " + what)


def drive_until(own: Lab, session: str) -> None:
    """Send revolutions until a session has a look."""
    turns = iter(range(10, 1_000))

    def looked() -> bool:
        own.revolutions(1, first=next(turns))
        return own.version(session) > 0

    wait_for(looked, "the look")


def test_a_robot_without_a_session_loses_no_stop_when_one_is_opened(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    own.map(on(scenario))
    own.revolutions(7)
    wait_for(lambda: own.report()["refused"] == 7, "the refusals")
    assert str(own.report()["waiting_for"]).startswith("a session on scenario")
    first = own.service.open(scenario)
    own.revolutions(3, first=10)
    wait_for(lambda: own.version(first) == 1, "the look of the stop")
    own.revolutions(6, first=20)
    assert own.version(first) == 1
    assert own.report()["waiting_for"] == "the robot to move on: this stop's look is taken"


def test_a_robot_whose_session_is_deleted_looks_for_the_next_one(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    first = own.service.open(scenario)
    own.map(on(scenario))
    own.revolutions(3)
    wait_for(lambda: own.version(first) == 1, "the look")
    own.bus.call("session.delete", {"session": first})
    second = own.service.open(scenario)
    drive_until(own, second)
    own.revolutions(6, first=2_000)
    assert own.version(second) == 1


def test_a_claimed_robot_takes_one_look_of_its_stop_for_each_session(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    first, second = own.service.open(scenario), own.service.open(scenario, robots=[])
    own.map(on(scenario))
    own.service.http.put("/v1/robots/tb3_1/session", json={"session": first}).raise_for_status()
    own.revolutions(4)
    own.service.http.put("/v1/robots/tb3_1/session", json={"session": second}).raise_for_status()
    drive_until(own, second)
    own.revolutions(8, first=2_000)
    assert (own.version(first), own.version(second)) == (1, 1)


def test_a_robot_that_is_nobody_s_has_no_looks_until_it_is_claimed(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    first = own.service.open(scenario)
    own.map(on(scenario))
    own.service.http.put("/v1/robots/tb3_1/session", json={"session": None}).raise_for_status()
    own.revolutions(8)
    wait_for(lambda: own.report()["refused"] == 8, "the refusals")
    assert (own.version(first), own.report()["session"]) == (0, None)
    own.service.http.put("/v1/robots/tb3_1/session", json={"session": first}).raise_for_status()
    own.revolutions(3, first=10)
    wait_for(lambda: own.version(first) == 1, "the look")


def failing_once(call: Callable[..., Any]) -> Callable[..., Any]:
    calls = iter([True])

    def called(*given: Any) -> Any:
        if next(calls, False):
            raise Busy("the database does not answer")
        return call(*given)

    return called


def test_a_look_that_the_database_did_not_take_is_taken_again(
    own: Lab, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    own.map(robot(session, look="{ scans = 3 }"))
    received = own.bus.subscribe(own.bus.keys.refused(session, "tb3_1"))
    store = own.service.inside.sessions.store
    monkeypatch.setattr(store, "change", failing_once(store.change))
    with audited() as audit:
        own.revolutions(3)
        wait_for(lambda: problems(received, "urn:voa:problem:overloaded"), "the refusal")
    assert audit.of("look.apply", "caller", "session", "robot", "result") == [("mapping", session, "tb3_1", 503)]
    assert "not accepted (overloaded)" in own.report()["waiting_for"]
    own.revolutions(3, first=10)
    wait_for(lambda: own.version(session) == 1, "the look")


def test_a_look_that_waited_and_finds_no_room_is_taken_again(
    tmp_path: Path, own_router: Router, monkeypatch: pytest.MonkeyPatch
) -> None:
    put, calls = Mailboxes.put, iter([True])

    def full_once(self: Any, name: str, item: Any, size: int) -> bool:
        return bool(put(self, name, item, size)) if size or not next(calls, False) else False

    monkeypatch.setattr(Replicas, "owns", lambda _, name: False)
    monkeypatch.setattr(Mailboxes, "put", full_once)
    with lab(tmp_path, own_router, grace_seconds=0.05) as own:
        session = own.service.open(own.service.create(data_scenario()))
        own.map(robot(session, look="{ scans = 3 }"))
        own.revolutions(3)
        wait_for(lambda: own.report()["refused"] == 1, "the refusal")
        assert own.report()["last_refusal"].startswith("overloaded: ")
        own.revolutions(3, first=10)
        wait_for(lambda: own.version(session) == 1, "the look")


@pytest.mark.parametrize("method", ["settle_robot", "change"])
def test_reports_do_not_wait_for_a_robot_whose_look_is_being_applied(
    own: Lab, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    scenario = own.service.create(data_scenario())
    session = own.service.open(scenario)
    own.map(on(scenario))
    own.revolutions(1)
    store = own.service.inside.sessions.store
    call, entered, go_on = getattr(store, method), threading.Event(), threading.Event()

    def slow(*given: Any) -> Any:
        entered.set()
        assert go_on.wait(30.0)
        return call(*given)

    monkeypatch.setattr(store, method, slow)
    for turn in range(3):
        own.put("tb3_1/scan", laser_scan(GOOD, 200.0 + 0.2 * turn))
    wait_for(entered.is_set, "the look to be applied")
    assert own.report()["robot"] == "tb3_1"
    go_on.set()
    wait_for(lambda: own.version(session) == 1, "the look")
