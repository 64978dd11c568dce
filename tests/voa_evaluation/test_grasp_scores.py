"""Grasp scores: the same table in any order on any number of processes, and files that others can read."""

import csv
import json
from pathlib import Path

import pytest

from voa_assets import path
from voa_cli.evaluate import command as evaluate
from voa_cli.evaluate import grasp_score
from voa_cli.evaluate.documents import grasp_score_document
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_evaluation.grasp_scores import GraspScores, score_grasps
from voa_fleet.statistics import wilson
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import MeasuredScores, ScenarioRequest

NOISE = Imperfections(object_xy_m=0.005, object_yaw_rad=0.0523598775598298)
POSES, GRASPS = ["U_90", "U_45"], ["OI90", "TD0"]


@pytest.fixture(scope="module")
def scores(mug: FleetObject) -> GraspScores:
    return score_grasps(mug, 3, NOISE, seed=5, poses=POSES, grasps=GRASPS)


def test_the_order_does_not_matter(mug: FleetObject, scores: GraspScores) -> None:
    turned = score_grasps(mug, 3, NOISE, seed=5, poses=POSES[::-1], grasps=GRASPS[::-1])
    assert {cell.pose + cell.grasp: cell for row in turned.cells for cell in row} == {
        cell.pose + cell.grasp: cell for row in scores.cells for cell in row
    }


def test_the_number_of_processes_does_not_matter(mug: FleetObject, scores: GraspScores) -> None:
    assert score_grasps(mug, 3, NOISE, seed=5, poses=POSES, grasps=GRASPS, processes=2) == scores


def test_more_attempts_contain_the_first_ones(mug: FleetObject) -> None:
    few = score_grasps(mug, 2, NOISE, seed=5, poses=["U_45"], grasps=["TD0"]).cells[0][0]
    more = score_grasps(mug, 4, NOISE, seed=5, poses=["U_45"], grasps=["TD0"]).cells[0][0]
    assert all(more.results.get(result, 0) >= count for result, count in few.results.items())


def test_another_seed_gives_other_noise(mug: FleetObject) -> None:
    strong = Imperfections(object_xy_m=0.01, object_yaw_rad=0.1)
    tables = {
        tuple(score_grasps(mug, 6, strong, seed, poses=["U_45"], grasps=["TD0"]).cells[0][0].results.items())
        for seed in range(4)
    }
    assert len(tables) > 1


def test_every_attempt_is_counted_and_progress_reported(mug: FleetObject) -> None:
    counts: list[int] = []
    scores = score_grasps(mug, 2, NOISE, 0, poses=POSES, grasps=["TDH0"], progress=counts.append)
    assert counts == [2, 2]
    assert [cell.attempts for row in scores.cells for cell in row] == [2, 2]
    assert scores.successes == [[0, 0]]


def test_the_scenario_gets_the_measured_scores(mug: FleetObject) -> None:
    scores = score_grasps(mug, 1, Imperfections(), 0)
    request = scores.scenario(mug.scenario)
    assert isinstance(request.scores, MeasuredScores)
    assert request.scores.attempts == 1
    assert request.scores.successes == [
        [0, 1, 0, 1, 1, 1],
        [1, 0, 0, 1, 1, 1],
        [0, 1, 1, 0, 0, 0],
        [1, 0, 0, 0, 0, 0],
    ]
    assert request.model_dump(exclude={"scores"}) == mug.scenario.model_dump(exclude={"scores"})
    assert grasp_score_document(scores)["successes"] == request.scores.successes


def test_scores_of_a_part_are_no_scenario(mug: FleetObject, scores: GraspScores) -> None:
    with pytest.raises(ValueError, match="expected scores of"):
        scores.scenario(mug.scenario)


@pytest.mark.parametrize(("name", "pose", "grasp"), [("mallet", "S_90", "TOP"), ("block", "U_180", "TD180")])
def test_the_scores_of_a_shipped_scenario_are_what_the_command_measures(
    targets: dict[str, FleetObject], name: str, pose: str, grasp: str
) -> None:
    target = targets[name]
    assert isinstance(target.scenario.scores, MeasuredScores)
    shipped = target.scenario.scores.successes[target.grasps.index(grasp)][target.poses.index(pose)]
    cell = score_grasps(target, 15, NOISE, 0, poses=[pose], grasps=[grasp]).cells[0][0]
    assert (cell.successes, cell.attempts) == (shipped, target.scenario.scores.attempts)


@pytest.mark.parametrize(
    ("successes", "attempts", "low", "high"), [(0, 15, 0.0, 0.2039), (15, 15, 0.7961, 1.0), (8, 15, 0.3012, 0.7519)]
)
def test_wilson_s_interval(successes: int, attempts: int, low: float, high: float) -> None:
    assert wilson(successes, attempts) == pytest.approx((low, high), abs=1e-4)


def test_the_command_writes_files_that_others_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = [
        "block",
        "--attempts",
        "1",
        "--noise-xy-mm",
        "0",
        "--noise-yaw-deg",
        "0",
        "--out",
        str(tmp_path),
        "--json",
    ]
    assert evaluate.main(["grasp-score", *options]) == 0
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert said.err == ""
    with (tmp_path / "grasp-score-block.csv").open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == len(report["cells"]) == 36
    assert [int(row["successes"]) for row in rows] == [cell["successes"] for cell in report["cells"]]
    assert sum(int(row["stopped on approach"]) for row in rows) == 20
    request = ScenarioRequest.model_validate_json((tmp_path / "block.json").read_bytes())
    assert isinstance(request.scores, MeasuredScores)
    assert request.scores.successes == report["successes"]
    assert (tmp_path / "block.obj").read_bytes() == path("block/block.obj").read_bytes()
    assert (tmp_path / "grasp-score-block.png").read_bytes().startswith(b"\x89PNG")


def test_the_service_takes_the_scenario_file(mug: FleetObject, tmp_path: Path, process: str) -> None:
    scores = score_grasps(mug, 1, Imperfections(), 0)
    files = grasp_score.write_scores(tmp_path, mug, scores)
    with Client(process) as client:
        stored = load_scenario(client, files["scenario"])
    assert isinstance(stored.scores, MeasuredScores)
    assert stored.scores.successes == scores.successes
    assert stored.object is not None


def test_the_command_prints_the_table_and_why_grasps_fail(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    options = ["mug", "--attempts", "1", "--noise-xy-mm", "0", "--noise-yaw-deg", "0", "--out", str(tmp_path)]
    assert grasp_score.main(options) == 0
    said = capsys.readouterr().out
    assert "s stopped on approach, n nothing between the fingers" in said
    assert "1" in next(line for line in said.splitlines() if "U_180" in line)
    assert str(tmp_path / "mug.json") in said


@pytest.mark.parametrize(
    ("options", "message"),
    [(["teapot"], "no object 'teapot'"), (["mug", "--opening-mm", "900"], "opening_m")],
)
def test_what_cannot_be_is_refused(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert grasp_score.main([*options, "--out", str(tmp_path)]) == 1
    assert message in capsys.readouterr().err


def test_an_evaluation_that_does_not_exist_is_refused_with_those_that_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert evaluate.main(["everything"]) == 2
    assert "grasp-score" in capsys.readouterr().err
    assert evaluate.main([]) == 0
    assert "observation" in capsys.readouterr().out
