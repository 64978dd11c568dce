"""`voa replay BAG`: the looks of a robot in a bag, through a real service."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag2 import StoragePlugin

from tests.support.serving import box_obj, data_scenario, mesh_scenario
from tests.voa_recordings.files.bags import START_NS, STEP_NS, STORE, Written, bag, laser_scan
from voa_cli.main import main
from voa_client import Client
from voa_recordings.files.ros_types import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE
from voa_ros.cdr import encode_laser_scan, encode_odometry, encode_pose
from voa_ros.messages import Odometry, Pose, PoseWithCovariance, Stamp

SEEN = [0.5, 0.5, math.inf, 1.0]
"""Prediction of the data scenario from Q1 at P1."""
GRID = {"angle_increment": 0.1, "range_min": 0.1, "range_max": 2.0}


def stamp(at_ns: int) -> Stamp:
    return Stamp(at_ns // 1_000_000_000, at_ns % 1_000_000_000)


def revolutions(count: int, ranges: Sequence[float] = SEEN, first: int = 0, topic: str = "/scan") -> list[Written]:
    made = []
    for index in range(first, first + count):
        at = START_NS + index * STEP_NS
        made.append((topic, LASER_SCAN, at, encode_laser_scan(laser_scan(ranges, at, **GRID))))
    return made


def scenario_file(folder: Path) -> Path:
    path = folder / "scenario.json"
    path.write_text(json.dumps(data_scenario()), encoding="utf-8")
    return path


def replayed(capsys: pytest.CaptureFixture[str], process: str, path: Path, *options: str) -> dict[str, Any]:
    code = main(["replay", str(path), "--json", "--url", process, *options])
    out, err = capsys.readouterr()
    assert (code, err) == (0, ""), err
    document: dict[str, Any] = json.loads(out)
    return document


@pytest.mark.parametrize("storage", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
@pytest.mark.parametrize(("mode", "count"), [("stationary", 1), ("every", 25)])
def test_a_parked_lidar_gives_one_look_or_every_scan_one(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, storage: StoragePlugin, mode: str, count: int
) -> None:
    folder = bag(tmp_path / "bag", revolutions(25), storage)
    document = replayed(
        capsys, process, folder, "--scenario", str(scenario_file(tmp_path)), "--sensor", "Q1", "--look", mode
    )
    assert (document["damage"], document["messages"]) == (None, 25)
    assert [(robot["scans"], robot["looks"]) for robot in document["robots"]] == [(25, count)]
    assert len(document["looks"]) == count
    first = document["looks"][0]
    assert (first["sensor"], first["update"]["accepted"], first["best_grasp"], first["version"]) == (
        "Q1",
        True,
        "G1",
        1,
    )
    assert first["belief"][0] == max(first["belief"])
    assert first["stamp"]["scans"] == (10 if mode == "stationary" else 1)


def test_a_person_reads_a_table(capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path) -> None:
    folder = bag(tmp_path / "bag", revolutions(12), StoragePlugin.MCAP)
    options = ["--scenario", str(scenario_file(tmp_path)), "--sensor", "Q1", "--url", process]
    assert main(["replay", str(folder), *options]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "accepted" in out
    assert "12 scans, 1 looks; at the end it waits for the robot to move on" in out


def test_a_file_that_ends_in_the_middle_says_so_and_is_no_error(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = bag(tmp_path / "bag", revolutions(25), StoragePlugin.MCAP)
    [whole] = folder.glob("*.mcap")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-60])
    options = ["--scenario", str(scenario_file(tmp_path)), "--sensor", "Q1"]
    document = replayed(capsys, process, cut, *options)
    assert (document["damage"], document["messages"], len(document["looks"])) == ("ends in the middle", 25, 1)
    whole.write_bytes(cut.read_bytes())
    assert main(["replay", str(folder), *options, "--url", process]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "! the recording ends in the middle: 25 messages recovered" in out


MAPPING = """
[[robot]]
name = "tb3_1"
session = "live"
lidar = {{ x = -0.032 }}
look = {{ mode = "{mode}", scans = 5 }}
place = {{ from = "{place}", origin = {{ x = 0.4, y = 0.0, yaw_rad = 3.141592653589793 }} }}

[[robot]]
name = "tb3_2"
session = "live"
place = {{ from = "sensor", sensor = "N" }}
"""


def drive(at_places: Sequence[float], *, amcl: bool = False) -> list[Written]:
    """A robot that stands at each x for eight revolutions, and drives in between."""
    made: list[Written] = []
    xs = []
    for index, x in enumerate(at_places):
        xs += [x] * 8
        if index + 1 < len(at_places):
            xs += [x + share * (at_places[index + 1] - x) for share in (0.2, 0.4, 0.6, 0.8)]
    for index, x in enumerate(xs):
        at = START_NS + index * STEP_NS
        pose = Pose.planar(x, 0.0, 0.0)
        odometry = Odometry(stamp(at), "odom", "base_footprint", pose)
        made.append(("/tb3_1/odom", ODOMETRY, at, encode_odometry(odometry)))
        if amcl and index == 0:
            document = PoseWithCovariance(stamp(at), "map", pose, (0.01, *(0.0,) * 6, 0.01, *(0.0,) * 27, 0.0))
            made.append(("/tb3_1/amcl_pose", POSE_WITH_COVARIANCE, at, encode_pose(document)))
        ranges = [0.4 + 0.1 * x] * 360
        made.append(("/tb3_1/scan", LASER_SCAN, at, encode_laser_scan(laser_scan(ranges, at))))
    return made


@pytest.mark.parametrize("place", ["odometry", "amcl"])
@pytest.mark.parametrize("mode", ["stationary", "on_request"])
def test_a_mapping_finds_looks_and_places_as_live(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, place: str, mode: str
) -> None:
    scenario = tmp_path / "scenario.json"
    (tmp_path / "box.obj").write_text(box_obj(), encoding="utf-8")
    scenario.write_text(json.dumps(mesh_scenario("box.obj")), encoding="utf-8")
    mapping = tmp_path / "robots.toml"
    mapping.write_text(MAPPING.format(mode=mode, place=place), encoding="utf-8")
    folder = bag(tmp_path / "bag", drive([0.0, 0.2], amcl=place == "amcl"), StoragePlugin.SQLITE3)
    document = replayed(capsys, process, folder, "--scenario", str(scenario), "--robots", str(mapping))
    assert [(look["robot"], look["sensor"]) for look in document["looks"]] == [("tb3_1", None)] * 2
    poses = [look["sensor_pose"] for look in document["looks"]]
    assert [pose["x"] for pose in poses] == pytest.approx([0.432, 0.232])
    assert [abs(pose["yaw_rad"]) for pose in poses] == pytest.approx([math.pi] * 2)
    assert (poses[0].get("std") is not None) == (place == "amcl")
    one, other = document["robots"]
    assert one["session"] == other["session"]
    assert (other["scans"], other["waiting_for"]) == (0, "a scan")


def test_a_look_that_the_service_refuses_is_reported(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = bag(tmp_path / "bag", revolutions(12, [0.5] * 7), StoragePlugin.MCAP)
    document = replayed(capsys, process, folder, "--scenario", str(scenario_file(tmp_path)), "--sensor", "Q1")
    [look] = document["looks"]
    assert look["update"] is None
    assert look["refused"].startswith("beam-grid-mismatch")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--sensor", "Q1", "--topic", "/other"], "no sensor_msgs/msg/LaserScan on /other (found: /scan"),
        (["--sensor", "Q9"], "the scenario has no sensor configuration 'Q9'; it has Q1, Q2"),
        (["--sensor", "Q1", "--topic", "a b"], "expected a topic like"),
        (["--robots", "robots.toml"], "place.from: recordings have no attachments"),
        (["--robots", "broken.toml"], "expected TOML"),
        (["--robots", "empty.toml"], "maps no robot"),
        (["--robots", "gone.toml"], "gone.toml"),
    ],
)
def test_what_cannot_work_is_said_so(
    capsys: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    says: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robots.toml").write_text('[[robot]]\nname = "r"\nsession = "s"\nplace = { from = "attachment" }\n')
    Path("broken.toml").write_text("[[robot")
    Path("empty.toml").write_text("")
    folder = bag(tmp_path / "bag", revolutions(3), StoragePlugin.MCAP)
    command = ["replay", str(folder), "--scenario", str(scenario_file(tmp_path)), "--url", process, *options]
    assert main(command) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err


@pytest.mark.parametrize("content", [b"nonsense", b"\x89MCAP0\r\n"])
def test_no_session_stays_behind_where_there_is_nothing_to_replay(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: bytes
) -> None:
    path = tmp_path / "look.mcap"
    path.write_bytes(content)
    with Client(process) as client:
        before = [session.id for session in client.list_sessions()]
        command = ["replay", str(path), "--scenario", str(scenario_file(tmp_path)), "--url", process]
        assert main([*command, "--sensor", "Q1", "--topic", "/scan"]) == 1
        assert str(path) in (err := capsys.readouterr().err) or "no sensor_msgs/msg/LaserScan on /scan" in err
        assert [session.id for session in client.list_sessions()] == before


def test_a_bag_with_neither_sessions_nor_a_scenario_names_its_topics(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = bag(tmp_path / "bag", revolutions(3), StoragePlugin.MCAP)
    assert main(["replay", str(folder), "--url", process]) == 1
    said = capsys.readouterr().err
    assert "holds no session" in said
    assert "/scan (sensor_msgs/msg/LaserScan)" in said
    assert "--scenario" in said


def test_scans_that_cannot_be_read_are_reported(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = bag(tmp_path / "bag", [("/scan", LASER_SCAN, START_NS, b"\0\1\0\0nonsense")], StoragePlugin.MCAP)
    command = ["replay", str(folder), "--scenario", str(scenario_file(tmp_path)), "--sensor", "Q1", "--url", process]
    assert main(command) == 1
    assert "expected a sensor_msgs/msg/LaserScan" in capsys.readouterr().err


@pytest.mark.parametrize("storage", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
@pytest.mark.parametrize("type_name", [ODOMETRY, "sensor_msgs/msg/PointCloud2"])
def test_a_topic_of_another_type_is_reported_with_the_expected_type(
    capsys: pytest.CaptureFixture[str], process: str, tmp_path: Path, type_name: str, storage: StoragePlugin
) -> None:
    folder = bag(tmp_path / "bag", [("/scan", type_name, START_NS, bytes(4))], storage)
    command = ["replay", str(folder), "--scenario", str(scenario_file(tmp_path)), "--url", process, "--sensor", "Q1"]
    assert main([*command, "--topic", "/scan"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"voa replay: no {LASER_SCAN} on /scan")
    assert f"/scan: expected a {LASER_SCAN} in cdr, found a {type_name}" in line
    assert main(command) == 1
    assert f"/scan ({type_name})" in capsys.readouterr().err


@pytest.mark.parametrize("options", [["--scenario", "s"], ["--sensor", "Q1"], ["--robots", "x.toml"]])
def test_a_scenario_and_places_go_together(capsys: pytest.CaptureFixture[str], options: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["replay", "bag", *options])
    assert ended.value.code == 2
    assert "--scenario" in capsys.readouterr().err


def test_the_bags_of_these_tests_are_what_ros_2_defines() -> None:
    assert STORE.fielddefs.keys() >= {LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE}
