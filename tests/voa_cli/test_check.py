"""`voa check`: what is probably wrong with a scenario file, in words and as JSON."""

import json
from pathlib import Path

import pytest

from tests.support.serving import box_obj, mesh_scenario
from voa_assets import path as asset
from voa_cli.main import main
from voa_client import Client
from voa_fleet.world.objects import OBJECTS


def write(folder: Path, **changes: object) -> Path:
    (folder / "box.obj").write_text(box_obj(), encoding="utf-8")
    file = folder / "scenario.json"
    file.write_text(json.dumps(mesh_scenario("box.obj", **changes)), encoding="utf-8")
    return file


@pytest.mark.parametrize("name", OBJECTS)
def test_the_shipped_scenarios_are_as_they_should_be(
    capfd: pytest.CaptureFixture[str], process: str, name: str
) -> None:
    assert main(["check", str(asset(f"{name}/scenario.json")), "--url", process]) == 0
    out, err = capfd.readouterr()
    assert "nothing looks wrong" in out
    assert err == ""
    with Client(process) as client:
        stored = out.rstrip().rpartition("stored as scenario ")[2]
        assert client.get_scenario(stored).id == stored


def test_warnings_are_named_explained_and_counted(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    sensors = [{"name": "E", "x": 300.0, "y": 0.0, "yaw_rad": 180.0}]
    file = write(tmp_path, sensors=sensors)
    assert main(["check", str(file), "--url", process]) == 1
    out, _ = capfd.readouterr()
    for words in ("angle-in-degrees", "180 degrees are 3.142 rad", "length-in-millimetres", "no-workspace", "place-"):
        assert words in " ".join(out.split())
    assert main(["check", str(file), "--url", process, "--json"]) == 1
    result = json.loads(capfd.readouterr().out)["items"]
    assert {"angle-in-degrees", "length-in-millimetres", "no-workspace"} <= {item["kind"] for item in result}
    assert all(item["detail"] for item in result)


def test_every_pair_of_pose_and_place_is_looked_at(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    poses = [
        {"name": f"P{i}", "position": [0.0, 0.0, 0.01 * (i == 7)], "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]}
        for i in range(2500)
    ]
    scores = {"probabilities": [[i / 5000.0 for i in range(2500)]] * 2}
    file = write(tmp_path, poses=poses, scores=scores)
    assert main(["check", str(file), "--url", process, "--json"]) == 1
    items = json.loads(capfd.readouterr().out)["items"]
    assert [item["poses"] for item in items if item["kind"] == "pose-height"] == [["P7"]]
    # The scenario's own answer looks at fewer pairs.
    with Client(process) as client:
        newest = list(client.list_scenarios())[-1]
        assert "pose-height" not in {warning.kind for warning in client.get_scenario(newest.id).warnings}


def test_a_file_that_cannot_be_used_is_no_warning(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    file = write(tmp_path, poses=[])
    assert main(["check", str(file), "--url", process]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("voa check: ")
    assert "poses" in err


def test_what_is_warned_of_about_the_mesh_is_not_lost_on_the_way(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    file = write(tmp_path, workspace={"min": [-0.1, -0.1], "max": [0.1, 0.1]})
    body = json.loads(file.read_text(encoding="utf-8"))
    flat = "".join(
        "v {} {} {}\n".format(*line.split()[1::2], line.split()[2]) if line.startswith("v ") else f"{line}\n"
        for line in box_obj().splitlines()
    )  # y and z change places: the box stands on y = 0
    (tmp_path / "box.obj").write_text(flat, encoding="utf-8")
    for command in ("check", "rank"):
        main([command, str(file), "--url", process])
        content = " ".join("".join(capfd.readouterr()).split())
        assert "warning: up-axis" in content
        assert "stands on its file's plane y = 0" in content
    large = tmp_path / "large.json"
    large.write_text(json.dumps(body | {"scale": 100}), encoding="utf-8")
    main(["rank", str(large), "--url", process])
    assert "warning: extent" in "".join(capfd.readouterr())
