"""`voa experiment`: begun, filled, checked, and made from a recording, up to the replay."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.recorded import write
from tests.support.standing_robots import Bench, Standing, messages, robot_of
from tests.support.standing_robots import write as write_mcap
from tests.voa_assets.mugs import object_of
from voa_assets import path as asset
from voa_cli import experiment
from voa_cli.main import main
from voa_client.message_files import read_file
from voa_client.scenario_files import InvalidScenarioFile, ScenarioFile
from voa_core.poses import PoseSet
from voa_recordings.experiment import read_experiment
from voa_ros.motions import Motion

MUG = asset("mug/scenario.json")
SCENARIO = read_file(ScenarioFile, MUG, InvalidScenarioFile)
POSES = ("U_0", "U_90", "D_90")
MOUNT = Motion(-0.032, 0.0, 0.1)
ORIGIN = Motion(0.5, -0.2, 2.0)
ROBOTS = """
[[robot]]
name = "tb3_1"
session = "live"
lidar = { x = -0.032, yaw_rad = 0.1 }
look = { mode = "stationary", scans = 5 }
place = { from = "odometry", origin = { x = 0.5, y = -0.2, yaw_rad = 2.0 } }
"""


def bench() -> Bench:
    return Bench(
        object_of(asset("mug/mug.obj")),
        PoseSet.from_arrays(
            [pose.name for pose in SCENARIO.poses],
            [pose.position or () for pose in SCENARIO.poses],
            [pose.quaternion_wxyz or () for pose in SCENARIO.poses],
        ),
        0.05,
    )


def standing(sensor: str, pose: str, off_m: float = 0.0) -> Standing:
    [place] = [each for each in SCENARIO.sensors if each.name == sensor]
    lidar = Motion(place.x + off_m, place.y, place.yaw_rad)
    return Standing(lidar, robot_of(lidar, MOUNT, ORIGIN), pose)


def drive(folder: Path, stops: list[Standing], topic: str = "/tb3_1/scan") -> Path:
    return write_mcap(folder / "run.mcap", messages(bench(), stops, np.random.default_rng(1), topic=topic))


def table(folder: Path, text: str) -> Path:
    file = folder / "poses.csv"
    file.write_text(text, encoding="utf-8")
    return file


def checked(folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    code = experiment.main(["check", str(folder)])
    return code, " ".join(capsys.readouterr().out.split())


def test_an_experiment_is_begun_filled_checked_and_replayed(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "mug"
    assert experiment.main(["new", str(folder), "--scenario", str(MUG), "--url", process]) == 0
    assert f"voa replay {folder}" in capsys.readouterr().out
    code, out = checked(folder, capsys)
    assert code == 1
    assert "no scan is measured yet" in out
    assert "0 of 48 scans measured" in out
    with (folder / "scans.csv").open(encoding="utf-8", newline="") as file:
        empty = list(csv.DictReader(file))
    assert {row["measured"] for row in empty} == {""}
    with (folder / "scans.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(empty[0]))
        writer.writeheader()
        writer.writerows(row | {"measured": row["predicted"]} for row in empty)
    assert checked(folder, capsys)[0] == 0
    read = read_experiment(folder)
    assert (read.selection, read.no_return_m, read.attempts) == ("whole", 0.47, 15)
    assert main(["replay", str(folder), "--json", "--url", process, "--rules", "margin"]) == 0
    report = json.loads(capsys.readouterr().out)
    for look in report["rules"]["margin"].values():
        assert look["voa"] == pytest.approx(look["aecd"])


def test_a_recording_with_a_table_of_times_becomes_an_experiment(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The robot stands at one place while the object is changed, then drives to the next."""
    order = [(sensor, pose) for sensor in ("ENE", "NNW") for pose in POSES]
    bag = drive(tmp_path, [standing(sensor, pose, 0.004) for sensor, pose in order])
    lines = [f"{pose},{index * 2.4 + 0.3:.1f},{index * 2.4 + 2.0:.1f}" for index, (_, pose) in enumerate(order)]
    robots = tmp_path / "robots.toml"
    robots.write_text(ROBOTS, encoding="utf-8")
    made = tmp_path / "made"
    poses = table(tmp_path, "\n".join(["pose,from,to", *lines]) + "\n")
    options = ["--scenario", str(MUG), "--robots", str(robots), "--poses", str(poses), "-o", str(made)]
    assert experiment.main(["from-recording", str(bag), *options, "--url", process]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "6 of 12 scans measured" in out
    read = read_experiment(made)
    assert [sensor.name for sensor in read.sensors] == ["ENE", "NNW"]
    assert sorted(pair for pair, scan in read.scans.items() if scan.was_measured) == sorted(order)
    exact = bench().ranges(standing("NNW", "D_90", 0.004).lidar, "D_90")
    for index, value in enumerate(read.measured_ranges("NNW", "D_90")):
        assert value == pytest.approx(exact[index], abs=0.008) if exact[index] < 1.0 else value is None
    assert main(["replay", str(made), "--json", "--url", process, "--rules", "margin"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["rules"]["margin"]["ENE"]["beliefs"].keys() == set(POSES)
    assert report["prediction"]["median_abs_mm"] < 6.0
    assert main(["evaluate", "all", "--recorded", str(made), "--url", process, "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "report.html").is_file()


def test_a_table_of_looks_and_places_needs_no_mapping(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = drive(tmp_path, [standing("ENE", "U_0"), standing("WSW", "U_0")], "/scan")
    poses = table(tmp_path, "pose,sensor,from,to\nU_0,ENE,0,2.3\nU_0,WSW,2.4,4.8\n")
    made = tmp_path / "made"
    options = ["--scenario", str(MUG), "--poses", str(poses), "-o", str(made), "--url", process]
    assert experiment.main(["from-recording", str(bag), *options]) == 0
    assert "2 of 12 scans measured" in capsys.readouterr().out
    assert experiment.main(["from-recording", str(bag), *options]) == 1
    assert "has a file experiment.json already" in capsys.readouterr().err
    without = table(tmp_path, "pose,look\nU_0,1\n")
    options = ["--scenario", str(MUG), "--poses", str(without), "-o", str(tmp_path / "other"), "--url", process]
    assert experiment.main(["from-recording", str(bag), *options]) == 1
    assert "expected the option --robots, or a column `sensor`" in capsys.readouterr().err


def test_a_scan_under_the_wrong_name_is_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The measured ranges of two poses are exchanged from one place."""
    folder = tmp_path / "mug"
    shutil.copytree(asset("experiments/mug"), folder)
    with (folder / "scans.csv").open(encoding="utf-8", newline="") as file:
        cells = list(csv.DictReader(file))
    exchanged = {"U_0": "U_180", "U_180": "U_0"}
    kept = [row for row in cells if row["sensor"] != "NNW" or row["pose"] not in exchanged]
    by_beam = {(row["pose"], row["angle_deg"]): row for row in cells if row["sensor"] == "NNW"}
    for pose, other in exchanged.items():
        for angle in sorted({angle for own, angle in by_beam if own in exchanged}):
            predicted, measured = by_beam.get((pose, angle), {}), by_beam.get((other, angle), {})
            row = {"sensor": "NNW", "pose": pose, "plane_height": "0.050", "angle_deg": angle}
            ranges = {"measured": measured.get("measured", ""), "predicted": predicted.get("predicted", "")}
            kept.append(row | ranges)
    with (folder / "scans.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(cells[0]))
        writer.writeheader()
        writer.writerows(kept)
    code, out = checked(folder, capsys)
    assert code == 0
    assert "NNW at U_0: the scan fits U_180 better" in out
    assert "NNW at U_180: the scan fits U_0 better" in out
    assert out.count("did the object lie") == 2


def test_what_is_wrong_has_a_line_and_exit_code_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write(tmp_path)
    with (folder / "scans.csv").open("a", encoding="utf-8") as file:
        file.write("Q9,P1,0.01,0,0.3,\nQ1,P1,0.01,0,near,\n")
    code, out = checked(folder, capsys)
    assert code == 1
    assert "line 8: experiment.json has no sensor 'Q9', only Q1, Q2" in out
    assert "line 9: measured: expected a number of metres, or nothing, got 'near'" in out
    assert "2 errors" in out
    code, out = checked(tmp_path / "nowhere", capsys)
    assert (code, "has no experiment.json" in out) == (1, True)
