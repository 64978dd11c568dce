"""Observation prediction, over simulated scans and over recorded ones."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tests.support import recorded
from voa_assets import path
from voa_cli.evaluate import command as evaluate
from voa_cli.evaluate import observation
from voa_evaluation.observation import ComparedBeam, errors_of, has_predictions, recorded_errors, simulated_errors
from voa_fleet.world.imperfections import Clutter, Imperfections, room
from voa_fleet.world.objects import FleetObject
from voa_recordings.experiment import read_experiment


def test_without_imperfections_prediction_is_exact(mug: FleetObject) -> None:
    errors = simulated_errors(mug, 1, Imperfections(clutter=room(2.0)), 0)
    overall = errors.overall
    assert errors.scans == 48
    assert overall.beams > 400
    assert overall.median_abs is not None
    assert overall.median_abs < 1e-3
    assert overall.p95_abs is not None
    assert overall.p95_abs < 1e-3
    assert overall.only_measured + overall.only_predicted <= 2  # beams along a facet


def test_noise_comes_back_as_spread(mug: FleetObject) -> None:
    counts: list[int] = []
    imperfections = Imperfections(range_noise_m=0.003, clutter=room(2.0))
    errors = simulated_errors(mug, 4, imperfections, 0, counts.append)
    assert sum(counts) == errors.scans == 192
    assert errors.overall.std == pytest.approx(3.0, rel=0.1)
    assert abs(errors.overall.mean or 0.0) < 0.3


def test_a_robot_in_the_wrong_place_errs_by_as_much(mug: FleetObject) -> None:
    errors = simulated_errors(mug, 2, Imperfections(robot_xy_m=0.02, clutter=room(2.0)), 0)
    assert errors.overall.std is not None
    assert errors.overall.std > 10.0
    assert errors.overall.only_measured > 0
    assert errors.overall.only_predicted > 0


def test_the_seed_decides(mug: FleetObject) -> None:
    imperfections = Imperfections.of_lds_01()
    assert simulated_errors(mug, 1, imperfections, 3) == simulated_errors(mug, 1, imperfections, 3)
    assert simulated_errors(mug, 1, imperfections, 3) != simulated_errors(mug, 1, imperfections, 4)


def test_what_stands_in_front_of_the_workspace_says_nothing_of_the_object(mug: FleetObject) -> None:
    box = Clutter("box", (0.25, 0.09), (0.02, 0.3, 0.2), 0.35)
    hidden = simulated_errors(mug, 1, Imperfections(clutter=(box,)), 0)
    assert all(beam.sensor != "ENE" for beam in hidden.beams)
    assert any(beam.sensor == "WSW" for beam in hidden.beams)


def test_errors_are_measured_minus_predicted() -> None:
    pairs = [(0.301, 0.300), (0.310, 0.312), (0.398, 0.400), (None, 0.405), (0.25, None)]
    errors = errors_of(ComparedBeam("Q1", "P1", 0.0, measured, predicted) for measured, predicted in pairs)
    assert (errors.beams, errors.only_measured, errors.only_predicted) == (3, 1, 1)
    assert errors.mean == pytest.approx(-1.0)
    assert errors.median == pytest.approx(-2.0)
    assert errors.std == pytest.approx(np.std([1.0, -2.0, -2.0]))
    assert (errors.lowest, errors.highest) == pytest.approx((-2.0, 1.0))
    assert errors.median_abs == pytest.approx(2.0)
    assert errors_of([]).mean is None


def test_a_recorded_experiment_is_compared_row_by_row(tmp_path: Path) -> None:
    errors = recorded_errors(read_experiment(recorded.write(tmp_path)), "recorded")
    assert errors.scans == 4
    assert {sensor: errors.beams for sensor, errors in errors.by_sensor().items()} == {"Q1": 3, "Q2": 1}
    assert errors.by_sensor()["Q2"].only_measured == 1
    assert errors.by_beam()["Q1", 0.0].beams == 2
    assert list(errors.by_beam()) == [("Q1", 0.0), ("Q1", 1.0), ("Q1", 359.0), ("Q2", 0.0)]


def test_the_mesh_predicts_what_was_recorded_as_predicted() -> None:
    experiment = read_experiment(path("experiments/mug"))
    by_record, by_mesh = (recorded_errors(experiment, source) for source in ("recorded", "mesh"))
    assert by_mesh.overall.beams == by_record.overall.beams > 150
    assert by_mesh.overall.median_abs == pytest.approx(by_record.overall.median_abs, abs=1e-3)
    assert by_record.overall.median_abs == pytest.approx(2.1, abs=0.6)


def test_an_experiment_without_predictions_is_compared_with_its_mesh(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "bare"
    folder.mkdir()
    for file in ("experiment.json", "mug.obj"):
        (folder / file).write_bytes(path(f"experiments/mug/{file}").read_bytes())
    with (
        path("experiments/mug/scans.csv").open(encoding="utf-8", newline="") as source,
        (folder / "scans.csv").open("w", encoding="utf-8", newline="") as target,
    ):
        rows = csv.DictReader(source)
        writer = csv.DictWriter(target, rows.fieldnames or [])
        writer.writeheader()
        writer.writerows(row | {"predicted": ""} for row in rows)
    assert not has_predictions(read_experiment(folder))
    assert observation.main(["--recorded", str(folder), "--out", str(tmp_path / "out"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["source"] == "mesh"
    assert report["overall"]["beams"] > 150


def test_the_command_writes_tables_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["observation", "--recorded", str(path("experiments/mug")), "--out", str(tmp_path), "--json"]
    assert evaluate.main(arguments) == 0
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert said.err == ""
    with (tmp_path / "observation-mug-beams.csv").open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == len(report["beams"])
    assert float(rows[0]["mean_mm"] or "nan") == pytest.approx(report["beams"][0]["mean"], abs=1e-3, nan_ok=True)
    with (tmp_path / "observation-mug-sensors.csv").open(encoding="utf-8", newline="") as lines:
        sensors = {row["sensor"]: row for row in csv.DictReader(lines)}
    assert list(sensors) == [*report["sensors"], "all"]
    assert int(sensors["all"]["beams"]) == report["overall"]["beams"]
    for picture in ("observation-mug-errors.png", "observation-mug-scans.png"):
        assert (tmp_path / picture).read_bytes().startswith(b"\x89PNG")


def test_the_command_looks_at_a_simulated_object(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert observation.main(["block", "--scans", "1", "--range-noise-mm", "2", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "block: measured minus predicted, mm" in said
    assert "beams of 48 scans return in both" in said
    assert all(name in said for name in ("ENE", "SSW", "all"))


def test_what_is_no_experiment_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert observation.main(["--recorded", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    assert "experiment.json" in capsys.readouterr().err
    recorded.write(tmp_path / "tiny")
    arguments = ["--recorded", str(tmp_path / "tiny"), "--predict", "mesh", "--out", str(tmp_path / "out")]
    assert observation.main(arguments) == 1
    assert "predictions from the mesh need a mesh file" in capsys.readouterr().err
