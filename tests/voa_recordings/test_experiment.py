"""Recorded experiments that cannot be read say which file, and where in it."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.recorded import Row, experiment, rows, write
from voa_recordings.experiment import read_experiment
from voa_recordings.experiment_parts import ExperimentLidar, InvalidExperiment


def without(name: str) -> dict[str, Any]:
    return {key: value for key, value in experiment().items() if key != name}


@pytest.mark.parametrize(
    ("document", "says"),
    [
        (without("name"), "name"),
        (without("poses"), "poses"),
        (without("sensors"), "sensors"),
        (without("grasps"), "grasps"),
        (without("scores"), "expected `scores`, or `successes` with `attempts`"),
        (experiment(poses=[]), "poses"),
        (experiment(sensors=[]), "sensors"),
        (experiment(grasps=[]), "grasps"),
        (experiment(poses="P1"), "poses"),
        (experiment(poses=5), "poses"),
        (experiment(grasps=5), "grasps"),
        (experiment(grasps=None), "grasps"),
        (experiment(poses=[{"position": [0, 0, 0]}]), "poses.0.name"),
        (experiment(poses=[{"name": "P1", "position": [0, 0]}, {"name": "P2"}]), "poses.0.position"),
        (experiment(scores={"G1": {"P1": 1.0, "P2": 1.0}}), "G2"),
        (experiment(scores={"G1": {"P1": 1.0, "P2": 1.0}, "G2": {"P1": 1.0}}), "P2"),
        (experiment(scores=None, successes={"G1": {"P1": 1}}), "`attempts`"),
        (experiment(lidar={"beams": 0}), "lidar.beams"),
        (experiment(lidar={"angle_increment_deg": 0}), "lidar"),
        (experiment(observation={"no_return": 0}), "observation.no_return"),
        (experiment(object={"mesh": "a.obj", "scale": 0}), "object.scale"),
        (experiment(poses=["P1", "P1"]), "'P1' twice"),
        (experiment(sensors=["Q1", "Q2", "Q1"]), "'Q1' twice"),
        (experiment(grasps=["G1", "G1"]), "'G1' twice"),
        (experiment(selection="some"), "selection"),
    ],
)
def test_an_experiment_file_that_is_wrong_is_named_with_its_field(
    tmp_path: Path, document: dict[str, Any], says: str
) -> None:
    with pytest.raises(InvalidExperiment) as wrong:
        read_experiment(write(tmp_path, document))
    assert "experiment.json" in str(wrong.value)
    assert says in str(wrong.value)


@pytest.mark.parametrize(
    ("row", "says"),
    [
        (("Q9", "P1", 0.01, 0.0, 0.3, 0.3), "'Q9'"),
        (("Q1", "P9", 0.01, 0.0, 0.3, 0.3), "'P9'"),
        (("Q1", "P1", 0.01, 0.5, 0.3, 0.3), "no beam at 0.5 degrees"),
        (("Q1", "P1", 0.01, 999.0, 0.3, 0.3), "no beam at 999.0 degrees"),
    ],
)
def test_a_row_that_is_wrong_is_named_by_its_line(tmp_path: Path, row: Row, says: str) -> None:
    with pytest.raises(InvalidExperiment) as wrong:
        read_experiment(write(tmp_path, scans=[*rows(), row]))
    assert "scans.csv, line 8: " in str(wrong.value)
    assert says in str(wrong.value)


@pytest.mark.parametrize(
    "line",
    ["Q1,P1,0.01,east,0.3,0.3", "Q1,P1,0.01,0,near,0.3", "Q1,P1,0.01,0,0.3,far", "Q1,P1,high,0,0.3,0.3", "Q1,P1", "Q1"],
)
def test_a_line_that_is_no_row_is_named(tmp_path: Path, line: str) -> None:
    folder = write(tmp_path)
    with (folder / "scans.csv").open("a") as file:
        file.write(line + "\n")
    with pytest.raises(InvalidExperiment, match=r"scans\.csv, line 8: "):
        read_experiment(folder)


def test_a_range_below_0_is_no_range(tmp_path: Path) -> None:
    with pytest.raises(InvalidExperiment, match=r"scans\.csv, line 2: .*-0\.3"):
        read_experiment(write(tmp_path, scans=[("Q1", "P1", 0.01, 0.0, -0.3, 0.3)]))


@pytest.mark.parametrize("name", ["experiment.json", "scans.csv"])
def test_a_file_that_is_not_there_is_named(tmp_path: Path, name: str) -> None:
    folder = write(tmp_path)
    (folder / name).unlink()
    with pytest.raises(InvalidExperiment, match=name):
        read_experiment(folder)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("experiment.json", b"{"),
        ("experiment.json", b"[]"),
        ("experiment.json", b"\xff\xfe"),
        ("expected.json", b"{"),
        ("scans.csv", b"\xff\xfe\x00"),
        ("scans.csv", b""),
        ("scans.csv", b"a,b,c\n1,2,3\n"),
    ],
)
def test_a_file_that_is_something_else_is_named(tmp_path: Path, name: str, content: bytes) -> None:
    folder = write(tmp_path)
    (folder / name).write_bytes(content)
    with pytest.raises(InvalidExperiment, match=name):
        read_experiment(folder)


def test_an_experiment_is_read_as_it_is_described(tmp_path: Path) -> None:
    read = read_experiment(write(tmp_path))
    assert read.pose_names == ["P1", "P2"]
    assert read.no_return_m == 1.0
    assert (read.mesh, read.expected, read.successes) == (None, None, None)
    assert read.measured_ranges("Q1", "P1")[:3] == [0.301, 0.310, None]
    assert read.predicted_ranges("Q1", "P2")[359] == 0.405
    assert len(read.predicted_ranges("Q1", "P2")) == 360
    assert not read.scan("Q3", "P1").was_measured
    assert read.height_m("Q9", "P1") == 0.01  # the most usual one
    assert read.selection is None


@pytest.mark.parametrize("selection", ["whole", "matched"])
def test_an_experiment_states_how_its_rows_were_chosen(tmp_path: Path, selection: str) -> None:
    assert read_experiment(write(tmp_path, experiment(selection=selection))).selection == selection


@pytest.mark.parametrize("text", ["nan", "inf", " ", ""])
def test_a_cell_without_a_number_is_a_no_return(tmp_path: Path, text: str) -> None:
    folder = write(tmp_path, scans=[])
    with (folder / "scans.csv").open("a") as file:
        file.write(f"Q1,P1,0.01,0,{text},{text}\n")
    read = read_experiment(folder)
    assert read.measured_ranges("Q1", "P1")[0] is None
    assert read.predicted_ranges("Q1", "P1")[0] is None


def test_what_is_expected_is_read_where_it_is_known(tmp_path: Path) -> None:
    folder = write(tmp_path)
    before = {"best_grasp": "G1", "expected_score": 0.5}
    (folder / "expected.json").write_text(json.dumps({"before": before, "rules": {}, "note": "measured twice"}))
    expected = read_experiment(folder).expected
    assert expected is not None
    assert expected.model_dump() == {"before": before, "rules": {}}


def test_expected_results_without_figures_are_refused(tmp_path: Path) -> None:
    folder = write(tmp_path)
    (folder / "expected.json").write_text(json.dumps({"before": {}}))
    with pytest.raises(InvalidExperiment, match=r"expected\.json: before\.best_grasp"):
        read_experiment(folder)


@pytest.mark.parametrize(
    ("lidar", "angle", "beam"),
    [
        (ExperimentLidar(), 0.0, 0),
        (ExperimentLidar(), 359.0, 359),
        (ExperimentLidar(), 360.0, 0),
        (ExperimentLidar(), -1.0, 359),
        (ExperimentLidar(beams=720, angle_min_deg=-180.0, angle_increment_deg=0.5), 0.0, 360),
        (ExperimentLidar(beams=720, angle_min_deg=-180.0, angle_increment_deg=0.5), 180.5, 1),
        (ExperimentLidar(angle_increment_deg=-1.0), -5.0, 5),
        (ExperimentLidar(angle_increment_deg=-1.0), 355.0, 5),
        (ExperimentLidar(beams=3, angle_increment_deg=1 / 3), 0.333, 1),
    ],
)
def test_angles_find_their_beams_whole_turns_aside(lidar: ExperimentLidar, angle: float, beam: int) -> None:
    assert lidar.beam(angle) == beam
