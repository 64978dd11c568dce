"""The check of a recorded experiment lists every mistake, and counts the scans of each pose and place."""

from pathlib import Path
from typing import Any

import pytest

from tests.support.recorded import Row, experiment, rows, write
from voa_assets import path as asset
from voa_recordings.experiment_check import check_experiment


def errors(folder: Path) -> str:
    return "\n".join(remark.text for remark in check_experiment(folder).remarks if remark.severity == "error")


def warnings(folder: Path) -> str:
    return "\n".join(remark.text for remark in check_experiment(folder).remarks if remark.severity == "warning")


def test_a_shipped_experiment_has_nothing_wrong() -> None:
    check = check_experiment(asset("experiments/mug"))
    assert check.remarks == []
    assert len(check.measured) == 24


def test_scans_and_beams_are_counted_by_place_and_pose(tmp_path: Path) -> None:
    check = check_experiment(write(tmp_path, experiment(selection="whole")))
    assert check.errors == 0
    assert check.beams == {("Q1", "P1"): 2, ("Q1", "P2"): 1, ("Q2", "P1"): 1, ("Q2", "P2"): 1}
    assert set(check.measured.values()) == {1}


@pytest.mark.parametrize(
    ("document", "says"),
    [
        (experiment(scores=None), "expected `scores`, or `successes` with `attempts`"),
        (experiment(scores={"G1": {"P1": 0.5}, "G2": {"P1": 1.0, "P2": 0.0}}), "grasp 'G1' has none at P2"),
        (experiment(scores={"G1": {"P1": 1.5, "P2": 0.0}, "G2": {"P1": 1, "P2": 0}}), "'G1' at 'P1': expected 0 to 1"),
        (
            experiment(scores=None, attempts=5, successes={"G1": {"P1": 6, "P2": 0}, "G2": {"P1": 1, "P2": 0}}),
            "successes: 'G1' at 'P1': expected 0 to 5, got 6",
        ),
        (experiment(object={"mesh": "absent.obj"}), "there is no file"),
        (experiment(observation={"no_return": 0.1}), "counts as a no-return"),
        (experiment(poses=5), "poses"),
    ],
)
def test_a_mistake_of_the_description_is_listed(tmp_path: Path, document: dict[str, Any], says: str) -> None:
    assert says in errors(write(tmp_path, document))


@pytest.mark.parametrize(
    ("scans", "says"),
    [
        ([*rows(), ("Q1", "P1", 0.01, 0.0, 0.3, 0.3)], "line 8: line 2 has that beam of Q1 at P1 already"),
        (
            [*rows(), ("Q1", "P1", 0.02, 9.0, 0.3, 0.3)],
            "plane_height: expected 0.01 m as in the other rows of Q1 at P1",
        ),
        ([*rows(), ("Q1", "P1", 0.01, 0.5, 0.3, 0.3)], "line 8: there is no beam at 0.5 degrees"),
        ([("Q1", "P1", 0.01, 0.0, None, 0.3)], "no scan is measured yet"),
        ([(*row[:4], 1000.0 * (row[4] or 0.3), row[5]) for row in rows()], "expected metres, not millimetres"),
        ([("Q9", "P1", 0.01, float(angle), 0.3, 0.3) for angle in range(30)], "10 more rows are wrong"),
    ],
)
def test_a_mistake_of_the_rows_is_listed(tmp_path: Path, scans: list[Row], says: str) -> None:
    assert says in errors(write(tmp_path, scans=scans))


def test_what_is_missing_is_a_warning(tmp_path: Path) -> None:
    folder = write(tmp_path, scans=[row for row in rows() if row[:2] != ("Q1", "P2") and row[0] != "Q2"])
    assert "Q1: no scan at P2" in warnings(folder)
    assert "Q2: no scan at any pose" in warnings(folder)
    assert '"selection"' in warnings(folder)
    assert errors(folder) == ""


@pytest.mark.parametrize("name", ["experiment.json", "scans.csv"])
def test_a_file_that_is_not_there_is_named(tmp_path: Path, name: str) -> None:
    folder = write(tmp_path)
    (folder / name).unlink()
    assert name in errors(folder)
