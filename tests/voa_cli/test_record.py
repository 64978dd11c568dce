"""`voa record` beside a real router and service, and the recording through another service."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from tests.deploy.pages import page
from tests.support.routers import router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from tests.voa_cli.labs import Lab, service_on
from tests.voa_recordings.files.bags import START_NS, laser_scan
from tests.voa_recordings.recorders import json_bodies, messages, recording
from voa_assets import path as asset_path
from voa_cli.main import main
from voa_client import Client, ZenohAddress
from voa_client.scenario_files import load_scenario
from voa_client.zenoh_session import joined
from voa_msgs.keys import Keys
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, SessionRequest
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import LASER_SCAN, RosTypes
from voa_recordings.files.sessions import recorded_sessions
from voa_ros.cdr import encode_laser_scan
from voa_ros.topics import LASER_SCAN as ROS_LASER_SCAN
from voa_ros.topics import MessageType, RmwAttachment, rmw_key

TYPES = RosTypes()
SCAN = ScanRequest(sensor="Q1", scan=Scan(ranges=[0.5, 0.5, None, 1.0], no_return=[2]))


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with router() as own, service_on(own, tmp_path_factory.mktemp("lab")) as service:
        yield service


def sessions_in(path: Path) -> dict[str, int]:
    """The sessions that can be rebuilt from what is on the disk now, and how many versions of each."""
    result = recorded_sessions(Recording(path, TYPES).messages())
    return {content.session: len(content.file.history) for content in result if content.file is not None}


def moved_session(client: Client) -> str:
    """A session with versions of every kind."""
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    own = client.create_session(SessionRequest(scenario=scenario.id)).id
    client.apply_scan(own, SCAN)
    client.report_outcome(own, OutcomeRequest(grasp="G1", success=False))
    return own


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_session_is_recorded_and_rebuilt_elsewhere(
    lab: Lab, process: str, tmp_path: Path, number: signal.Signals, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "look.mcap"
    with Client(lab.url) as client, recording(path, "--url", lab.zenoh) as own:
        session = moved_session(client)
        client.put_belief(session, BeliefRequest(belief=None))
        last = client.apply_scan(session, SCAN)
        wait_for(lambda: sessions_in(path).get(session) == 5, "all versions are recorded")
        printed = own.stop(number)
    assert f"/voa/{session}/belief" in printed
    kinds = [topic.rpartition("/")[2] for topic, _, _ in messages(path) if session in topic]
    assert kinds.count("scenario") == 1
    assert (kinds.count("history"), last.version) == (5, 4)
    assert main(["replay", str(path), "--url", process, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["damage"] is None
    [again] = [item for item in content["sessions"] if item["recorded"] == session]
    assert (again["same"], again["session"]["belief"]) == (True, last.belief)
    assert main(["replay", str(path), "--url", process]) == 0
    assert "its belief is exactly the recorded one" in " ".join(capsys.readouterr().out.split())


def test_a_recording_shows_each_version_and_stock_readers_read_all_of_it(
    lab: Lab, process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "shown.mcap"
    mug = asset_path("mug")
    topics = ["--topic", "/tb3_1/scan"]
    with (
        Client(lab.url, timeout_s=30.0) as client,
        recording(path, "--url", lab.zenoh, "--rank", "always", *topics) as own,
        joined(ZenohAddress.parse(lab.zenoh)) as robot,
    ):
        scenario = load_scenario(client, mug / "scenario.json")
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        robot.put("tb3_1/scan", encode_laser_scan(laser_scan([0.5] * 360)))
        client.report_outcome(session, OutcomeRequest(grasp=scenario.grasps[0].name, success=False))
        wait_for(lambda: topics_of(path).count(f"/voa/{session}/scene") == 2, "both versions are drawn")
        printed = own.stop(signal.SIGINT)
        history = list(client.history(session, beliefs=True))
    assert "not shown completely" not in printed
    with AnyReader([path]) as theirs:
        decoded = [(of.topic, theirs.deserialize(data, of.msgtype)) for of, _, data in theirs.messages()]
    by_topic: dict[str, list[Any]] = {}
    for topic, message in decoded:
        by_topic.setdefault(topic, []).append(message)
    entropies: dict[str, Any] = {}
    exec(page("on-your-robots").program("def entropies").text, entropies)  # noqa: S102 - our own page
    assert entropies["entropies"](path, session) == [entry.entropy_nats for entry in history]
    assert len(by_topic["/tb3_1/scan"][0].ranges) == 360
    scenes = [{entity.id: entity for entity in scene.entities} for scene in by_topic[f"/voa/{session}/scene"]]
    models = [bytes(scene["belief"].models[0].data) for scene in scenes]
    beliefs = [entry.belief or [] for entry in history]
    likely = [sum(part > 1e-3 * max(belief) for part in belief) for belief in beliefs]
    assert [model.count(b'"mesh":') for model in models] == likely, "a ghost for each pose that is not unlikely"
    assert [len(scene["looks"].cylinders) for scene in scenes] == [len(scenario.sensors)] * 2
    assert [list(each.data) for each in by_topic[f"/voa/{session}/probabilities"]] == beliefs
    scores = [each.data for each in by_topic[f"/voa/{session}/expected_score"]]
    assert scores == [entry.expected_score for entry in history]
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert sum(1 for _ in reader.iter_decoded_messages()) == len(decoded)
    assert main(["replay", str(path), "--url", process, "--mesh", str(mug / "mug.obj"), "--json"]) == 0
    (again,) = json.loads(capsys.readouterr().out)["sessions"]
    assert (again["same"], again["session"]["belief"]) == (True, beliefs[-1])
    assert all("belief" not in entry for entry in json_bodies(path, f"/voa/{session}/history")), "it has its own topic"


def topics_of(path: Path) -> list[str]:
    """The topic of each message that is on the disk now."""
    return [message.topic for message in Recording(path, TYPES).messages()]


def test_what_robots_put_is_recorded_as_it_came(lab: Lab, tmp_path: Path) -> None:
    path = tmp_path / "look.mcap"
    topics = ["--topic", "/tb3_1/scan", "--topic", "*/scan", "--topic", "tb3_1/other"]
    payload = encode_laser_scan(laser_scan([0.5] * 360))
    gid = bytes(range(16))
    address = ZenohAddress.parse(lab.zenoh)
    with Client(lab.url) as client, recording(path, "--url", lab.zenoh, *topics) as own, joined(address) as robot:
        session = moved_session(client)
        robot.put("tb3_1/scan", payload)
        beside = RmwAttachment(7, START_NS + 5, gid).encode()
        robot.put(rmw_key("tb3_1/scan", ROS_LASER_SCAN), payload, attachment=beside)
        robot.put("tb3_1/other", b"\0\1\0\0something else")
        robot.put("tb3_2/scan", payload)
        robot.put(Keys().scan(session, "r1"), SCAN.model_dump_json(), attachment=b'{"id": "look-1", "key": "secret"}')
        robot.put(Keys().scan(session, "r1"), b"{}")
        wait_for(lambda: refusals(lab) > 0, "the second scan is refused")
        printed = own.stop(signal.SIGINT)
    result = messages(path)
    scans = [message for topic, _, message in result if topic == "/tb3_1/scan"]
    assert [message.data for message in scans] == [payload] * 2
    assert 7 in [message.sequence for message in scans]
    assert all(0 <= message.log_time - message.publish_time < 60_000_000_000 for message in scans)
    assert [message.data for topic, _, message in result if topic == "/tb3_2/scan"] == [payload]
    assert SCAN.model_dump(mode="json") in json_bodies(path, f"/voa/{session}/scan")
    assert json_bodies(path, f"/voa/{session}/scan_attachment") == [{"id": "look-1"}]
    assert b"secret" not in path.read_bytes()
    assert json_bodies(path, f"/voa/{session}/refused")[0]["status"] == 422
    assert "1 messages have no type" in printed
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert LASER_SCAN in [schema.name for schema in summary.schemas.values()]


def test_all_topics_of_a_robot_are_recorded_with_their_types(lab: Lab, tmp_path: Path) -> None:
    path = tmp_path / "all.mcap"
    scan = encode_laser_scan(laser_scan([0.5] * 5_521, angle_increment=0.001))
    imu = MessageType("sensor_msgs/msg/Imu", TYPES.store.hash_rihs01("sensor_msgs/msg/Imu"))
    address = ZenohAddress.parse(lab.zenoh)
    topics = ["--topic", "/rb/**", "--topic", "/*/end"]
    with joined(address) as robot, recording(path, "--url", lab.zenoh, *topics) as own:
        token: Any = robot.liveliness().declare_token("@/a1/@ros2_lv/MP/rb§arm§joints/sensor_msgs§msg§JointState/:::")

        def typed() -> bool:
            robot.put("rb/arm/joints", b"\0\1\0\0")
            return types_in(path).get("/rb/arm/joints") == "sensor_msgs/msg/JointState"

        wait_for(typed, "the type that the bridge announces is known")
        robot.put("rb/scan", scan)
        robot.put("rb/own", b"\0\1\0\0")
        robot.put(rmw_key("rb/imu", imu), b"\0\1\0\0")
        robot.put(rmw_key("rb/a/b/own", MessageType("lab/msg/Own", "TypeHashNotSupported")), b"\0\1\0\0")
        robot.put("fleet/rb/other/thing", b"\0\1\0\0")
        robot.put("rb/end", scan)
        wait_for(lambda: "/rb/end" in types_in(path), "the last one is recorded")
        token.undeclare()
        printed = " ".join(own.stop(signal.SIGINT).split())
    assert types_in(path) == {
        "/rb/scan": LASER_SCAN,
        "/rb/own": "",
        "/rb/imu": "sensor_msgs/msg/Imu",
        "/rb/a/b/own": "lab/msg/Own",
        "/rb/arm/joints": "sensor_msgs/msg/JointState",
        "/rb/end": LASER_SCAN,
    }
    assert "/rb/own (1)" in printed
    assert "/rb/scan has scans of 5521 beams" in printed
    assert "VOA_LIMITS__BEAMS=5521" in printed


def types_in(path: Path) -> dict[str, str]:
    """The type of the newest message on each topic."""
    return {message.topic: message.type_name for message in Recording(path, TYPES).messages()}


def test_a_limit_that_is_none_is_said_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("VOA_LIMITS__BEAMS", "many")
    assert main(["record", "-o", str(tmp_path / "x.mcap")]) == 1
    assert "VOA_LIMITS__BEAMS: expected a positive whole number" in capsys.readouterr().err


def refusals(lab: Lab) -> int:
    with Client(lab.url) as client:
        return sum(report.refused for report in client.robots().items)


def test_one_session_alone_is_recorded_whole_although_nothing_happens(lab: Lab, process: str, tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with Client(lab.url) as client:
        session, other = moved_session(client), moved_session(client)
        with recording(path, "--url", lab.zenoh, "--session", session) as own:
            client.apply_scan(other, SCAN)
            wait_for(lambda: sessions_in(path).get(session) == 3, "the session is recorded")
            own.stop(signal.SIGINT)
    assert not [topic for topic, _, _ in messages(path) if other in topic]
    assert main(["replay", str(path), "--url", process]) == 0


def test_a_recorder_that_was_killed_leaves_what_it_received(
    lab: Lab, process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "killed.mcap"
    with Client(lab.url) as client, recording(path, "--url", lab.zenoh) as own:
        session = moved_session(client)
        wait_for(lambda: sessions_in(path).get(session) == 3, "it is on the disk")
        own.process.kill()
        own.process.wait()
    assert main(["replay", str(path), "--url", process, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["damage"] == "ends in the middle"
    assert session in [again["recorded"] for again in content["sessions"] if again["same"]]
    assert main(["replay", str(path), "--url", process]) == 0
    assert "the recording ends in the middle:" in " ".join(capsys.readouterr().out.split())


def test_it_ends_by_itself_after_so_many_seconds(lab: Lab, tmp_path: Path) -> None:
    assert main(["record", "-o", str(tmp_path / "x.mcap"), "--url", lab.zenoh, "--seconds", "0.1"]) == 0
    assert messages(tmp_path / "x.mcap") == []


def test_an_existing_file_is_kept_without_force(lab: Lab, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.mcap"
    path.write_text("precious")
    command = ["record", "-o", str(path), "--url", lab.zenoh, "--seconds", "0.1"]
    assert main(command) == 1
    assert "--force overwrites it" in capsys.readouterr().err
    assert path.read_text() == "precious"
    assert main([*command, "--force"]) == 0
    assert messages(path) == []


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--url", "zenoh://127.0.0.1:1"], "no Zenoh router accepted the connection to tcp/127.0.0.1:1"),
        (["--url", "http://127.0.0.1:8000"], "expected a URL with zenoh://"),
        (["--topic", "a//b"], "expected a topic like /tb3_1/scan"),
        (["--url", "zenoh://h/bad root"], "expected a root like"),
    ],
)
def test_what_cannot_work_is_said_so(
    tmp_path: Path, options: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.mcap"
    assert main(["record", "-o", str(path), *options]) == 1
    assert says in capsys.readouterr().err
    assert not path.exists()


def test_a_router_that_restarts_is_joined_again(tmp_path: Path) -> None:
    with router() as own, service_on(own, tmp_path / "service") as lab, Client(lab.url) as client:
        path = tmp_path / "x.mcap"
        with recording(path, "--url", lab.zenoh) as recorder:
            moved_session(client)
            own.kill()
            own.start()
            session = moved_session(client)

            def received() -> bool:
                client.apply_scan(session, SCAN)
                return session in sessions_in(path)

            wait_for(received, "a message of the session is received again")
            recorder.stop(signal.SIGINT)
