"""`voa fleet`: pairs at once, options that do not go together, the mapping, pictures."""

import json
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.replicas import replicas
from tests.support.routers import router
from tests.support.waiting import wait_for
from voa_assets import path as asset_path
from voa_cli import fleet
from voa_cli.fleet import pair_names
from voa_cli.main import main
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_fleet.devices.simulated import Scene
from voa_fleet.world.attempts import Watch
from voa_fleet.world.clocks import Clock
from voa_ros.robot_places import OdometryPlace
from voa_ros.robots import load


def reports(capfd: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    documents: list[dict[str, Any]] = json.loads(capfd.readouterr().out)
    return documents


def without_sessions(documents: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in each.items() if name != "session"} for each in documents]


def test_pairs_play_at_once_each_in_its_session(process: str, capfd: pytest.CaptureFixture[str]) -> None:
    arguments = ["fleet", "--url", process, "--looks", "2", "--json"]
    assert main([*arguments, "--pairs", "3"]) == 0
    reported = reports(capfd)
    assert [each["pair"] for each in reported] == list(pair_names(3))
    assert len({each["session"] for each in reported}) == 3
    assert len({each["truth"] for each in reported}) > 1
    assert all(1 <= len(each["looks"]) <= 2 for each in reported)
    assert sum(each["success"] for each in reported) >= 1
    with Client(process) as client:
        for each in reported:
            assert client.get_session(each["session"]).version == len(each["looks"]) + 1, "the outcome is reported"
    # Alone, the first pair does what it did in company.
    assert main(arguments) == 0
    assert without_sessions(reports(capfd)) == without_sessions(reported[:1])


def test_in_a_pipe_it_prints_a_line_for_each_event(process: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["fleet", "--url", process, "--pairs", "2", "--looks", "1", "--policy", "nearest"]) == 0
    said = capfd.readouterr().out
    assert "robot_1 look from " in said
    assert "robot_2 the arm tries " in said
    assert "\x1b" not in said
    assert "of 2 lifted; the true pose of the mallet was" in said


@pytest.mark.parametrize(
    ("noise", "spread"),
    [
        ([], {"xy_m": 0.005, "yaw_rad": pytest.approx(0.0524, abs=1e-4)}),
        (["--object-noise-m", "0.01", "--object-noise-deg", "0"], {"xy_m": 0.01, "yaw_rad": 0.0}),
        (["--object-noise-m", "0", "--object-noise-deg", "0"], None),
    ],
)
def test_the_scenario_states_how_far_the_object_lies_off_its_pose(
    process: str, capfd: pytest.CaptureFixture[str], noise: list[str], spread: dict[str, float] | None
) -> None:
    assert main(["fleet", "--url", process, "--looks", "1", "--json", *noise]) == 0
    (report,) = reports(capfd)
    assert [look["absent"] for look in report["looks"]] == [None]
    with Client(process) as client:
        scenario = client.get_scenario(client.get_session(report["session"]).scenario)
        plain = load_scenario(client, asset_path("mallet") / "scenario.json")
    assert (None if scenario.spread is None else scenario.spread.model_dump()) == spread
    assert (scenario.id == plain.id) is (spread is None)


def test_imperfections_are_named_options(process: str, capfd: pytest.CaptureFixture[str]) -> None:
    wrong = ["--pose-error-m", "0.02", "--pose-error-deg", "2", "--range-noise", "0.01", "--dropout", "0.2"]
    wrong += ["--clutter", "box", "--object-noise-m", "0.01", "--object-noise-deg", "5", "--packet-loss", "0.1"]
    assert main(["fleet", "--url", process, "--looks", "1", "--json", *wrong]) == 0
    (imperfect,) = reports(capfd)
    with Client(process) as client:
        scan = next(entry for entry in client.history(imperfect["session"]) if entry.kind == "scan")
    assert isinstance(scan.request, dict)
    pose = scan.request["sensor_pose"]
    assert isinstance(pose, dict)
    assert pose["std"] == {"xy_m": 0.02, "yaw_rad": pytest.approx(0.0349, abs=1e-4)}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--transport", "zenoh"], "--transport zenoh needs the --url"),
        (["--ros2"], "--ros2 needs the --url"),
        (["--transport", "http", "--url", "zenoh://127.0.0.1:7447"], "contradicts --url"),
        (["--ros2", "--url", "http://127.0.0.1:1"], "expected its zenoh:// URL"),
        (["--view", "--pairs", "2"], "--view shows one pair"),
        (["--ros2", "--url", "zenoh://127.0.0.1:7447", "--revolutions", "1"], "at least 2 --revolutions"),
        (["--looks", "-1"], "expected a number of at least 0"),
        (["--seed", "-1"], "expected a number of at least 0"),
        (["--dropout", "1.5"], "expected a share of at most 1"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    arguments: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["fleet", *arguments])
    assert ended.value.code == 2
    assert said in capfd.readouterr().err


def test_an_unknown_object_is_reported(process: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["fleet", "--url", process, "--object", "vase"]) == 1
    assert (
        "voa fleet: no object 'vase'; there are: mug, mallet, block, goblet, coupling, a folder"
        in capfd.readouterr().err
    )


def test_without_the_viewers_library_it_says_what_to_install(
    process: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco.viewer", None)
    assert main(["fleet", "--url", process, "--view"]) == 1
    assert "MuJoCo's viewer is not installed" in capfd.readouterr().err


def test_ros_2_pairs_work_with_the_mapping_that_it_prints(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    mapping = tmp_path / "robots.toml"
    mapping.write_text("")
    command = ["fleet", "--pairs", "2", "--looks", "1", "--pose-error-m", "0.005", "--ros2"]
    with router() as bus:
        options = ("--zenoh", bus.endpoint, "--robots", str(mapping))
        with replicas(f"sqlite:///{tmp_path / 'voa.db'}", tmp_path, 1, *options) as (service,):
            url = f"zenoh://127.0.0.1:{bus.port}"
            assert main([*command, "--print-mapping"]) == 0
            printed = capfd.readouterr().out
            assert main([*command, "--url", service.url, "--print-mapping"]) == 0
            assert capfd.readouterr().out == printed  # any service names a scenario alike
            robots = load(printed)
            assert [robot.scan_topic for robot in robots] == ["robot_1/scan", "robot_2/scan"]
            assert len({robot.scenario for robot in robots}) == 1
            place = robots[0].place
            assert isinstance(place, OdometryPlace)
            assert place.std is not None
            assert place.std.xy_m == 0.005
            assert len(tomllib.loads(printed)["robot"]) == 2
            mapping.write_text(printed)
            with Client(service.url) as client:
                wait_for(lambda: len(client.robots().items) == 2, "the mapping")
            assert main([*command, "--url", url, "--json"]) == 0
            reported = reports(capfd)
            assert [len(each["looks"]) for each in reported] == [1, 1]
            with Client(service.url) as client:
                for each in reported:
                    kinds = [entry.kind for entry in client.history(each["session"])]
                    assert kinds[:2] == ["prior", "scan"]
                claimed = {robot.robot: robot.session for robot in client.robots().items}
                assert claimed == {each["pair"]: each["session"] for each in reported}


def test_a_mapping_is_printed_while_there_is_no_router(capfd: pytest.CaptureFixture[str]) -> None:
    with router() as bus:
        url = f"zenoh://127.0.0.1:{bus.port}"
    began = time.monotonic()
    assert main(["fleet", "--ros2", "--url", url, "--print-mapping"]) == 0
    assert [robot.name for robot in load(capfd.readouterr().out)] == ["robot_1"]
    assert time.monotonic() - began < 60.0  # a call waits 120 s for a router


@pytest.mark.parametrize("way", [[], ["--ros2"]])
def test_a_router_that_is_not_there_is_soon_missed(way: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    with router() as bus:
        url = f"zenoh://127.0.0.1:{bus.port}"
    began = time.monotonic()
    assert main(["fleet", "--url", url, *way]) == 1
    assert "no Zenoh router" in capfd.readouterr().err
    assert time.monotonic() - began < 30.0


def test_a_video_is_of_the_first_pair(
    process: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    video, filmed = tmp_path / "episode.gif", []

    @contextmanager
    def camera(scene: Scene, _clock: Clock, file: Path) -> Iterator[Watch]:
        seen: list[float] = []
        yield lambda data: seen.append(float(data.time))
        filmed.append((scene.world.robots, file, seen))

    monkeypatch.setattr(fleet, "filmed", camera)
    play = ["fleet", "--url", process, "--looks", "0", "--policy", "none", "--pairs", "2", "--video", str(video)]
    assert main(play) == 0
    ((robots, file, seen),) = filmed
    assert (robots, file) == (("robot_1",), video)
    assert len(seen) > 300  # every 10 ms of the arm
    assert seen == sorted(seen)
