"""ROS 2 robots on the bus: bytes as a bridge and rmw_zenoh put them, made by rosbags and not by this project."""

import math
from pathlib import Path

import pytest

from tests.support.bus import Problem
from tests.support.routers import Router
from tests.support.serving import box_obj, data_scenario, mesh_scenario
from tests.support.waiting import wait_for
from tests.voa_service.zenoh.ros_lab import GOOD, Lab, lab, laser_scan, odometry, robot
from voa_ros.topics import LASER_SCAN, ODOMETRY, rmw_key


@pytest.mark.parametrize("key", ["tb3_1/scan", rmw_key("tb3_1/scan", LASER_SCAN), "0/tb3_1/scan/"
                                 "sensor_msgs::msg::dds_::LaserScan_/TypeHashNotSupported"])  # fmt: skip
def test_a_scan_in_each_form_updates_the_mapped_session(own: Lab, session: str, key: str) -> None:
    own.map(robot(session))
    own.put(key, laser_scan(GOOD, 100.0))
    wait_for(lambda: own.version(session) == 1, "the look")
    assert own.report()["key"] == key
    request = own.last_request(session)
    assert request["sensor"] == "Q1"
    assert request["scan"]["no_return"] == [2]
    assert request["scan"]["ranges"][0] == 0.5
    assert request["scan"]["stamp"]["robot"] == "tb3_1"
    # What a robot puts in JSON, over HTTP, has the same effect.
    twin = own.service.open(own.service.get(f"/v1/sessions/{session}")["scenario"])
    scan = {key: value for key, value in request["scan"].items() if key != "stamp"}
    update = own.service.post(f"/v1/sessions/{twin}/scans", {"sensor": "Q1", "scan": scan})
    assert update["belief"] == own.service.get(f"/v1/sessions/{session}")["belief"]


@pytest.mark.parametrize(
    ("what", "payload", "kind", "says"),
    [
        ("corrupt", b"\xff" * 200, "invalid-request", "LaserScan"),
        ("cut", laser_scan(GOOD, 100.0)[:-9], "invalid-request", "LaserScan"),
        ("empty", b"", "invalid-request", "LaserScan"),
        ("oversized", laser_scan([0.5] * 4000, 100.0), "too-large", "20000 bytes"),
        ("of too many beams", laser_scan([0.5] * 2000, 100.0), "beam-grid-mismatch", "beams"),
        ("another type", odometry(0.0, 0.0, 0.0, 100.0), "invalid-request", "LaserScan"),
        ("JSON", b'{"ranges": [0.5]}', "invalid-request", "LaserScan"),
    ],
)
def test_a_payload_that_is_no_scan_is_refused_and_seen(
    own: Lab, session: str, what: str, payload: bytes, kind: str, says: str
) -> None:
    own.map(robot(session))
    problems = own.bus.subscribe(own.bus.keys.refused(session, "tb3_1"))
    own.put("tb3_1/scan", payload)
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    assert own.report()["last_refusal"].startswith(f"{kind}: ")
    assert says in own.report()["last_refusal"]
    wait_for(lambda: problems, "the problem")
    assert problems[0].json["type"] == f"urn:voa:problem:{kind}"
    assert own.version(session) == 0
    own.put("tb3_1/scan", laser_scan(GOOD, 101.0))  # and it goes on
    wait_for(lambda: own.version(session) == 1, "the next scan")


@pytest.mark.parametrize(
    ("key", "payload", "type_name"),
    [
        ("0/tb3_1/scan/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_ab", b"\0\1\0\0", "sensor_msgs/msg/PointCloud2"),
        (rmw_key("tb3_1/scan", ODOMETRY), odometry(0.0, 0.0, 0.0, 100.0), ODOMETRY.name),
        ("tb3_1/scan", odometry(0.0, 0.0, 0.0, 100.0), ODOMETRY.name),
    ],
)
def test_a_message_of_another_type_is_refused_with_both_types(
    own: Lab, session: str, key: str, payload: bytes, type_name: str
) -> None:
    own.map(robot(session))
    own.put("0/tb3_1/scan/other_topic/below", b"")
    own.put(key, payload)
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    assert own.report()["last_refusal"].startswith(
        f"invalid-request: expected a {LASER_SCAN.name}, found a {type_name}"
    )


def test_a_parked_robot_is_one_look_and_stays_one_over_a_restart(tmp_path: Path, own_router: Router) -> None:
    with lab(tmp_path, own_router) as first:
        session = first.service.open(first.service.create(data_scenario()))
        first.map(robot(session, look="{ scans = 5 }"))
        first.revolutions(30)
        assert first.version(session) == 1
        assert first.last_request(session)["scan"]["stamp"]["scans"] == 5
        assert "move on" in first.report()["waiting_for"]
    with lab(tmp_path, own_router) as second:
        wait_for(lambda: len(second.reports()) == 1, "the mapping")
        second.revolutions(30, first=30)
        assert second.version(session) == 1
        second.revolutions(30, first=60, ranges=(1.5, 1.5, 0.3, 0.3))  # it has driven on
        assert second.version(session) == 2


def test_a_look_on_request_is_taken_when_it_is_requested(own: Lab, session: str) -> None:
    own.map(robot(session, look='{ mode = "on_request", scans = 3 }'))
    own.revolutions(10)
    assert (own.version(session), own.report()["waiting_for"]) == (0, "a request")
    assert own.service.http.post("/v1/robots/tb3_1/look").status_code == 200
    own.revolutions(10, first=10)
    assert own.version(session) == 1
    own.bus.call("robot.look", {"robot": "tb3_1"})
    own.revolutions(10, first=20)
    assert own.version(session) == 2


def test_a_look_that_was_requested_is_not_forgotten(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    own.map(
        f'name = "tb3_1"\nscenario = "{scenario}"\nlook = {{ mode = "on_request", scans = 3 }}\n'
        'place = { from = "sensor", sensor = "Q1" }\n'
    )
    first = own.service.open(scenario)
    own.bus.call("robot.look", {"robot": "tb3_1"})  # before its first scan
    own.revolutions(3)
    wait_for(lambda: own.version(first) == 1, "the look")


def test_a_session_that_is_deleted_does_not_send_the_robot_to_an_older_one(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    own.map(
        f'name = "tb3_1"\nscenario = "{scenario}"\nlook = {{ mode = "every" }}\n'
        'place = { from = "sensor", sensor = "Q1" }\n'
    )
    older, newer = own.service.open(scenario), own.service.open(scenario)
    own.revolutions(1)
    wait_for(lambda: own.version(newer) == 1, "the look")
    own.bus.call("session.delete", {"session": newer})
    turns = iter(range(1, 1_000))

    def refused_by_name() -> bool:
        own.put("tb3_1/scan", laser_scan(GOOD, 200.0 + next(turns)))
        return "session yet on scenario" in str(own.report()["last_refusal"])

    wait_for(refused_by_name, "the refusal")
    assert own.version(older) == 0


def test_a_look_of_a_robot_that_takes_none_on_request_is_refused(own: Lab, session: str) -> None:
    own.map(robot(session))
    with pytest.raises(Problem, match="on_request"):
        own.bus.call("robot.look", {"robot": "tb3_1"})


def test_odometry_says_where_the_lidar_was_when_the_scan_was_taken(own: Lab) -> None:
    box = own.service.upload(box_obj())
    scenario = mesh_scenario(box, lidar={"preset": "lds-01", "beams": 4, "angle_increment": 0.1, "height_m": 0.02})
    session = own.service.open(own.service.create(scenario))
    own.map(
        f'name = "tb3_1"\nsession = "{session}"\nlook = {{ mode = "every" }}\nstamp = "after_revolution"\n'
        "lidar = { x = 0.1, y = 0.0, yaw_rad = 0.0 }\n"
        '[robot.place]\nfrom = "odometry"\norigin = { x = 1.0, y = 0.0, yaw_rad = 0.0 }\n'
        "std = { xy_m = 0.01, yaw_rad = 0.0 }\n"
    )
    own.put("tb3_1/scan", laser_scan([0.3] * 4, 100.0))
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    assert "no odometry was received yet" in own.report()["last_refusal"]
    # It drives along y at 1 m/s, facing y; the revolution ends at 100.0 and its middle is at 99.9.
    for at_s, y in ((99.8, 0.8), (100.0, 1.0)):
        own.put("tb3_1/odom", odometry(0.0, y, math.pi / 2, at_s))
    own.put("tb3_1/scan", laser_scan([0.31] * 4, 100.0))
    wait_for(lambda: own.version(session) == 1, "the look")
    pose = own.last_request(session)["sensor_pose"]
    assert (pose["x"], pose["y"], pose["yaw_rad"]) == pytest.approx((1.0, 1.0, math.pi / 2), abs=1e-6)
    assert pose["std"] == {"xy_m": 0.01, "yaw_rad": 0.0}
    pose["height_m"] = None
    report, shown = own.report(), own.service.get("/v1/robots/tb3_1/scan")
    assert (report["sensor_pose"], report["sensor"], report["gathered"]) == (pose, None, None)
    assert (shown["sensor_pose"], shown["session"], shown["source"]) == (pose, session, "ros2")
    assert shown["scan"]["ranges"] == [0.31] * 4
    assert own.bus.call("robot.scan", {"robot": "tb3_1"}) == shown


def test_a_robot_is_reported_at_the_place_where_it_stands(own: Lab) -> None:
    box = own.service.upload(box_obj())
    scenario = mesh_scenario(box, lidar={"preset": "lds-01", "beams": 4, "angle_increment": 0.1, "height_m": 0.02})
    session = own.service.open(own.service.create(scenario))
    own.map(f'name = "tb3_1"\nsession = "{session}"\nlook = {{ scans = 5 }}\nplace = {{ from = "odometry" }}\n')
    for turn in range(3):
        own.put("tb3_1/odom", odometry(0.33, -0.02, 3.1, 100.0 + 0.2 * turn))
        own.put("tb3_1/scan", laser_scan([0.3 + 0.001 * turn] * 4, 100.0 + 0.2 * turn))
    wait_for(lambda: own.report()["gathered"] == 3, "three revolutions")
    report = own.report()
    assert (report["sensor"], report["wanted"], report["looks"]) == ("E", 5, 0)
    assert report["sensor_pose"]["x"] == pytest.approx(0.33)


def test_the_newest_scan_is_shown_although_no_session_takes_it(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    place = 'place = { from = "sensor", sensor = "Q1" }'
    own.map(f'name = "tb3_1"\nscenario = "{scenario}"\n{place}\n')
    assert own.service.http.get("/v1/robots/tb3_1/scan").status_code == 404
    own.put("tb3_1/scan", laser_scan([0.6, 0.6, 0.6, 0.6], 100.0))
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    shown = own.service.get("/v1/robots/tb3_1/scan")
    assert (shown["sensor"], shown["session"], shown["scan"]["ranges"]) == ("Q1", None, [0.6] * 4)
    (refusal,) = own.report()["refusals"]
    assert (refusal["reason"], refusal["times"]) == (own.report()["last_refusal"], 1)


def test_the_place_may_come_beside_each_scan(own: Lab, session: str) -> None:
    own.map(robot(session, place='{ from = "attachment" }'))
    own.put("tb3_1/scan", laser_scan(GOOD, 100.0))
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    own.put("tb3_1/scan", laser_scan(GOOD, 101.0), '{"sensor": "Q2"}')
    wait_for(lambda: own.version(session) == 1, "the look")
    assert own.last_request(session)["sensor"] == "Q2"


def test_a_scenario_in_the_mapping_means_its_newest_session(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    own.map(
        f'name = "tb3_1"\nscenario = "{scenario}"\nlook = {{ mode = "every" }}\n'
        'place = { from = "sensor", sensor = "Q1" }\n'
    )
    own.put("tb3_1/scan", laser_scan(GOOD, 100.0))
    wait_for(lambda: own.report()["refused"] == 1, "the refusal")
    assert own.report()["last_refusal"].startswith("not-found: ")
    first = own.service.open(scenario)
    own.put("tb3_1/scan", laser_scan(GOOD, 101.0))
    wait_for(lambda: own.version(first) == 1, "the look")
    second = own.service.open(scenario)  # another one: the robot keeps its own
    own.service.post("/v1/rankings", {"scenario": scenario, "belief": None})
    own.revolutions(20, first=10)
    wait_for(lambda: own.version(first) == 21, "the looks")
    assert own.version(second) == 0
    own.service.http.put("/v1/robots/tb3_1/session", json={"session": second}).raise_for_status()
    turns = iter(range(1_000))

    def goes_to_the_second() -> bool:
        own.put("tb3_1/scan", laser_scan(GOOD, 202.0 + next(turns)))
        return own.version(second) > 0

    wait_for(goes_to_the_second, "the claim to be noticed")
    third = own.service.post("/v1/sessions", {"scenario": scenario, "robots": ["tb3_1"]})["id"]

    def goes_to_the_third() -> bool:
        own.put("tb3_1/scan", laser_scan(GOOD, 2000.0 + next(turns)))
        return own.version(third) > 0

    wait_for(goes_to_the_third, "the claim to be noticed")
    assert own.report()["session"] == third


def test_robots_have_their_namespaces_and_sessions(own: Lab) -> None:
    scenario = own.service.create(data_scenario())
    sessions = [own.service.open(scenario) for _ in range(2)]
    own.map(
        *(
            f'name = "tb3_{number}"\nsession = "{session}"\nlook = {{ mode = "every" }}\n'
            'place = { from = "sensor", sensor = "Q1" }\n'
            for number, session in enumerate(sessions)
        )
    )
    own.revolutions(3, robot="tb3_0")
    own.revolutions(2, robot="tb3_1")
    wait_for(lambda: [own.version(session) for session in sessions] == [3, 2], "the looks of both")


def test_a_mapping_with_a_mistake_is_reported_and_the_old_one_stays_in_use(own: Lab, session: str) -> None:
    own.map(robot(session))
    own.mapping.write_text('[[robot]]\nname = "tb3_1"\ncolour = "red"\n')
    wrong = wait_for(lambda: own.service.get("/v1/robots")["mapping_error"], "the mistake")
    assert "tb3_1" in wrong
    assert "colour" in wrong
    own.revolutions(1)
    wait_for(lambda: own.version(session) == 1, "the look")
    own.map(robot(session, look='{ mode = "on_request" }'))
    wait_for(lambda: own.service.get("/v1/robots")["mapping_error"] is None, "the corrected mapping")
