"""`voa replay` through a real service, on recorded experiments of every form that their description allows."""

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.recorded import Row, expected, experiment, rows, write
from voa_assets import path as asset
from voa_cli.main import main
from voa_recordings.selection import MATCHED, NOT_STATED, WHOLE

MUG = asset("experiments/mug")
LAB = Path(os.environ.get("VOA_LAB_HOLDER", Path(__file__).resolve().parents[3] / "shared" / "lab-holder"))
needs_lab = pytest.mark.skipif(
    not LAB.is_dir(), reason=f"the lab's data are not at {LAB}; VOA_LAB_HOLDER names another place"
)
FOLDERS = [pytest.param(MUG, id="mug"), pytest.param(LAB, id="lab-holder", marks=needs_lab)]

Report = dict[str, Any]


def replayed(capfd: pytest.CaptureFixture[str], process: str, folder: Path, *more: str) -> Report:
    """The one JSON document on stdout; nothing stands beside it, there or on stderr."""
    code = main(["replay", str(folder), "--json", "--url", process, *more])
    out, err = capfd.readouterr()
    assert (code, err) == (0, "")
    report: Report = json.loads(out)
    return report


def numbers(node: Any, where: str = "") -> Iterator[tuple[str, Any]]:
    """Every leaf by its path."""
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else None
    if children is None:
        yield where, node
    else:
        for key, child in children:
            yield from numbers(child, f"{where}/{key}")


def assert_close(result: Any, wanted: Any, within: float) -> None:
    have, want = dict(numbers(result)), dict(numbers(wanted))
    assert have.keys() == want.keys()
    for where, value in want.items():
        if isinstance(value, float):
            assert have[where] == pytest.approx(value, abs=within), where
        else:
            assert have[where] == value, where


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_report_has_the_form_of_the_contract_and_agrees_with_expected_json(
    capfd: pytest.CaptureFixture[str], process: str, folder: Path
) -> None:
    report = replayed(capfd, process, folder)
    wanted = json.loads((folder / "expected.json").read_text(encoding="utf-8"))
    stated = json.loads((folder / "experiment.json").read_text(encoding="utf-8")).get("selection")
    assert list(report) == [
        "experiment", "poses", "sensors", "before", "rules", "prediction", *(["selection"] if stated else []),
    ]  # fmt: skip
    assert report.get("selection") == stated
    assert list(report["rules"]) == ["margin", "exponential", "gaussian", "inverse_rmsd"]
    assert_close(report["before"], wanted["before"], 1e-6)
    for rule, sensors in wanted["rules"].items():
        for sensor, want in sensors.items():
            have = report["rules"][rule][sensor]
            assert set(have) == {"voa", "aecd", "beliefs"}
            assert have["voa"] == pytest.approx(want["voa"], abs=1e-6)
            assert have["aecd"] == pytest.approx(want["aecd"], abs=1e-6)
            after = {
                measured: dict(zip(report["poses"], belief, strict=True))
                for measured, belief in have["beliefs"].items()
            }
            assert_close(after, want["belief_after_measured_scan"], 1e-6)
    figures = report["prediction"]
    assert set(figures) == {
        "source", "beams", "median_abs_mm", "p95_abs_mm", "max_abs_mm", "against_recorded",
    }  # fmt: skip
    assert figures["source"] == "recorded"
    assert figures["against_recorded"] is None
    assert 0.0 < figures["median_abs_mm"] < figures["p95_abs_mm"] < figures["max_abs_mm"]


@pytest.mark.parametrize("folder", FOLDERS)
def test_predictions_from_the_mesh_are_the_recorded_ones_on_every_listed_beam(
    capfd: pytest.CaptureFixture[str], process: str, folder: Path
) -> None:
    listed = sum(1 for line in (folder / "scans.csv").read_text().splitlines()[1:] if line.split(",")[5])
    figures = replayed(capfd, process, folder, "--predict", "mesh")["prediction"]
    assert figures["source"] == "mesh"
    assert figures["against_recorded"]["beams"] == listed
    assert figures["against_recorded"]["max_abs_m"] < 1e-6


@needs_lab
def test_the_lab_s_error_figures_come_out(capfd: pytest.CaptureFixture[str], process: str) -> None:
    figures = replayed(capfd, process, LAB)["prediction"]
    assert figures["beams"] == 507
    assert figures["median_abs_mm"] == pytest.approx(2.3, abs=0.05)
    assert 50.0 < figures["max_abs_mm"] < 65.0


FINE = {"beams": 720, "angle_min_deg": -180.0, "angle_increment_deg": 0.5}
COARSE = {"beams": 8, "angle_min_deg": 0.0, "angle_increment_deg": 45.0, "range_max": 2.0}
CLOCKWISE = {"beams": 360, "angle_min_deg": 0.0, "angle_increment_deg": -1.0}


def on_grid(angles: dict[float, float]) -> list[Row]:
    return [(*row[:3], angles[row[3]], *row[4:]) for row in rows()]


FAR: list[Row] = [("Q1", "P1", None, 5.0, 1.7, 0.4), ("Q1", "P2", None, 5.0, 0.99, None)]
VARIANTS: dict[str, tuple[dict[str, Any], list[Row]]] = {
    "names alone, missing predictions and measurements": (experiment(), rows()),
    "names as strings": (experiment(poses=["P1", "P2"], sensors=["Q1", "Q2"]), rows()),
    "grasps as objects": (experiment(grasps=[{"name": "G1", "data": 1}, {"name": "G2"}]), rows()),
    "successes alone": (
        experiment(scores=None, attempts=15, successes={"G1": {"P1": 13, "P2": 0}, "G2": {"P1": 3, "P2": 11}}),
        rows(),
    ),
    "scores win over successes": (
        experiment(attempts=15, successes={"G1": {"P1": 0, "P2": 15}, "G2": {"P1": 15, "P2": 0}}),
        rows(),
    ),
    "finer beams from another angle": (experiment(lidar=FINE), on_grid({0.0: 0.0, 1.0: 1.5, 359.0: -179.5})),
    "eight beams": (experiment(lidar=COARSE), on_grid({0.0: 0.0, 1.0: 45.0, 359.0: 315.0})),
    "beams that turn clockwise": (experiment(lidar=CLOCKWISE), on_grid({0.0: 0.0, 1.0: -1.0, 359.0: -359.0})),
    "a no-return nearer than some rows": (experiment(observation={"no_return": 0.35}), rows()),
    "measured beyond the no-return": (experiment(), [*rows(), *FAR]),
    "no-returns beyond the lidar's range": (experiment(observation={"no_return": 9.0}), rows()),
    "a sensor measured at one pose": (experiment(), [row for row in rows() if row[:2] != ("Q2", "P1")]),
    "a sensor that measured nothing": (experiment(), [(*r[:4], None if r[0] == "Q2" else r[4], r[5]) for r in rows()]),
    "a sensor without rows": (experiment(), [row for row in rows() if row[0] == "Q1"]),
    "no rows at all": (experiment(), []),
    "three poses and one grasp": (
        experiment(poses=["P1", "P2", "P3"], grasps=["G1"], scores={"G1": {"P1": 0.5, "P2": 0.25, "P3": 0.0}}),
        rows(),
    ),
    "one pose": (
        experiment(poses=["P1"], scores={"G1": {"P1": 0.5}, "G2": {"P1": 0.25}}),
        [row for row in rows() if row[1] == "P1"],
    ),
    "grasps that never succeed": (
        experiment(scores={"G1": {"P1": 0.0, "P2": 0.0}, "G2": {"P1": 0.0, "P2": 0.0}}),
        rows(),
    ),
    "fields that nobody knows": (experiment(weather="fine", lidar={"model": "LDS-01", "colour": "black"}), rows()),
}  # fmt: skip


@pytest.mark.parametrize(("content", "scans"), VARIANTS.values(), ids=VARIANTS)
def test_every_form_of_an_experiment_gives_the_twin_s_numbers(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: dict[str, Any], scans: list[Row]
) -> None:
    report = replayed(capfd, process, write(tmp_path / "experiment", content, scans))
    figures = report.pop("prediction")
    assert_close(report, expected(content, scans), 1e-9)
    errors = sorted(1e3 * abs(row[4] - row[5]) for row in scans if row[4] is not None and row[5] is not None)
    assert figures["beams"] == len(errors)
    if errors:
        assert figures["max_abs_mm"] == pytest.approx(errors[-1])
    else:
        assert [figures[name] for name in ("median_abs_mm", "p95_abs_mm", "max_abs_mm")] == [None] * 3


def test_a_person_reads_a_table_and_that_the_numbers_agree(capfd: pytest.CaptureFixture[str], process: str) -> None:
    assert main(["replay", str(MUG), "--url", process, "--rules", "exponential"]) == 0
    out = capfd.readouterr().out
    assert "best grasp before any look" in out
    assert "expected.json: agrees" in out


@pytest.mark.parametrize(
    ("stated", "says"),
    [({}, NOT_STATED), ({"selection": "whole"}, WHOLE), ({"selection": "matched"}, MATCHED)],
    ids=["not stated", "whole", "matched"],
)
def test_a_person_reads_how_the_rows_were_chosen(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, stated: dict[str, str], says: str
) -> None:
    folder = write(tmp_path, experiment(**stated))
    assert main(["replay", str(folder), "--url", process, "--rules", "exponential"]) == 0
    out = " ".join(capfd.readouterr().out.split())
    assert [sentence for sentence in (NOT_STATED, WHOLE, MATCHED) if sentence in out] == [says]
    assert ("Caution" in out) == (stated.get("selection") == "matched")


def test_numbers_that_do_not_agree_are_an_error(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = tmp_path / "mug"
    shutil.copytree(MUG, folder)
    wanted = json.loads((folder / "expected.json").read_text(encoding="utf-8"))
    wanted["rules"]["exponential"]["ENE"]["voa"] += 1e-3
    (folder / "expected.json").write_text(json.dumps(wanted), encoding="utf-8")
    assert main(["replay", str(folder), "--url", process, "--rules", "exponential"]) == 1
    assert "DISAGREES, largest difference 1.0e-03" in capfd.readouterr().out


def test_a_service_of_its_own_is_started_where_none_is_named(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    folder = write(tmp_path / "experiment")
    assert main(["replay", str(folder), "--json"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert json.loads(out) == replayed(capfd, process, folder)


GEOMETRY = {
    "object": {"mesh": "box.obj", "scale": 1.0},
    "poses": [
        {"name": name, "position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]} for name in ("P1", "P2")
    ],
    "sensors": [{"name": name, "x": 0.3, "y": 0.0, "yaw_deg": 180.0} for name in ("Q1", "Q2")],
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "scans", "mesh", "says"),
    [
        ({}, rows(), False, "no mesh"),
        (GEOMETRY, rows(), False, "no mesh"),
        (GEOMETRY | {"poses": ["P1", "P2"]}, rows(), True, "position and quaternion_wxyz"),
        (GEOMETRY, [(*row[:2], None, *row[3:]) for row in rows()], True, "plane heights"),
        (GEOMETRY | {"sensors": ["Q1", "Q2"]}, rows(), True, "x, y and yaw_deg"),
    ],
)
def test_predictions_from_a_mesh_need_one_and_geometry(
    capfd: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    changes: dict[str, Any],
    scans: list[Row],
    mesh: bool,
    says: str,
) -> None:
    folder = write(tmp_path / "experiment", experiment(**changes), scans)
    if mesh:
        shutil.copy(asset("mug/mug.obj"), folder / "box.obj")
    assert main(["replay", str(folder), "--predict", "mesh", "--json", "--url", process]) == 1
    out, err = capfd.readouterr()
    assert out == ""
    assert says in err
