"""`voa calibrate` on recordings of simulated stops: what it prints, and the lines for robots.toml."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.support.standing_robots import CORNER, Standing, bench_of, facing, messages, prism, robot_of, write
from voa_cli.main import main
from voa_core.objects import Object
from voa_ros.motions import Motion

MOUNT, ORIGIN = Motion(-0.032, 0.0, 0.1), Motion(0.5, -0.2, 2.0)
ROBOTS = """
[[robot]]
name = "tb3_1"
session = "live"
lidar = {{ x = -0.032, yaw_rad = 0.1, height_m = 0.05 }}
place = {{ from = "odometry", origin = {{ x = {x}, y = -0.2, yaw_rad = 2.0 }} }}
"""


def lab(folder: Path, mesh: Object, *, x: float = 0.5) -> list[str]:
    """Scenario file with its mesh, and mapping; returns the options of the command."""
    lines = [f"v {a} {b} {c}" for a, b, c in mesh.vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces]
    (folder / "object.obj").write_text("\n".join(lines) + "\n")
    scenario = {
        "name": "bracket",
        "object": "object.obj",
        "poses": [{"name": "as made", "position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}],
        "grasps": [{"name": "G"}],
        "scores": {"probabilities": [[1.0]]},
        "sensors": [{"name": "E", "x": 0.4, "y": 0.0, "yaw_rad": 3.14}],
        "lidar": {"preset": "lds-01"},
    }
    (folder / "scenario.json").write_text(json.dumps(scenario))
    (folder / "robots.toml").write_text(ROBOTS.format(x=x))
    return ["--scenario", str(folder / "scenario.json"), "--robots", str(folder / "robots.toml"), "--pose", "as made"]


def recorded(folder: Path, mesh: Object, bearings: tuple[float, ...], *, hangs: bool = False) -> Path:
    stops = []
    for bearing in bearings:
        lidar = facing(bearing, 0.4, 0.3)
        stops.append(Standing(lidar, robot_of(lidar, MOUNT, ORIGIN), "as made"))
    made = messages(bench_of(mesh), stops, np.random.default_rng(2), hangs=hangs)
    return write(folder / f"run{len(bearings)}.mcap", made)


def test_the_origin_is_printed_with_its_uncertainty_and_as_toml(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = prism(CORNER)
    options = lab(tmp_path, mesh, x=0.6)
    bag = recorded(tmp_path, mesh, (0.9,))
    assert main(["calibrate", str(bag), *options, "--estimate", "origin"]) == 0
    out = capsys.readouterr().out
    assert "tb3_1: 1 stop" in out
    assert "does not separate an error of the mount from one of the origin" in out
    [line] = re.findall(r"^origin = \{.*\}", out, re.MULTILINE)
    origin = tomllib.loads(line)["origin"]
    assert origin["x"] == pytest.approx(0.5, abs=0.01)
    assert origin["y"] == pytest.approx(-0.2, abs=0.01)
    assert origin["yaw_rad"] == pytest.approx(2.0, abs=0.02)


def test_an_upside_down_lidar_is_stated_in_the_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = prism(CORNER)
    options = lab(tmp_path, mesh)
    bags = [str(recorded(tmp_path, mesh, bearings, hangs=True)) for bearings in ((0.9,), (2.5, -1.5))]
    assert main(["calibrate", *bags, *options, "--estimate", "mount", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["stops"], document["determined"], document["sign_determined"]) == (3, True, True)
    lidar = tomllib.loads(document["toml"][0])["lidar"]
    assert lidar["upside_down"] is True
    assert (lidar["x"], lidar["yaw_rad"], lidar["height_m"]) == pytest.approx((-0.032, 0.1, 0.05), abs=0.01)
    assert main(["calibrate", *bags, *options, "--estimate", "origin"]) == 0
    out = capsys.readouterr().out
    assert "unlike the mapping states" in out
    assert "upside_down = true }" in out


def test_a_can_gives_no_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    mesh = prism([(0.04 * np.cos(angle), 0.04 * np.sin(angle)) for angle in angles])
    options = lab(tmp_path, mesh)
    assert main(["calibrate", str(recorded(tmp_path, mesh, (0.9,))), *options, "--estimate", "origin"]) == 1
    out = capsys.readouterr().out
    assert "NOT DETERMINED: from which side the object was seen" in out
    assert "origin = {" not in out


def test_what_is_wrong_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = prism(CORNER)
    options = lab(tmp_path, mesh)
    bag = str(recorded(tmp_path, mesh, (0.9,)))
    assert main(["calibrate", bag, *options, "--estimate", "origin", "--robot", "tb3_2"]) == 1
    assert "maps no robot 'tb3_2': expected one of tb3_1" in capsys.readouterr().err
    assert main(["calibrate", bag, *options, "--estimate", "origin", "--stop", "2"]) == 1
    assert "have 1 stops, counted from 1" in capsys.readouterr().err
