"""scores.csv: written for a person to fill, read back, and refused with row and column."""

from pathlib import Path

import pytest

from voa_msgs.scenarios import GivenScores, MeasuredScores
from voa_setup.scores.table import InvalidScores, read_scores, write_empty_scores, write_scores

GRASPS, POSES = ["rim", "handle"], ["upright 0", "upright 90"]
SCORES = MeasuredScores(attempts=15, successes=[[15, 0], [3, 7]])


def test_scores_are_written_and_read(tmp_path: Path) -> None:
    file = tmp_path / "scores.csv"
    write_scores(file, GRASPS, POSES, SCORES)
    assert file.read_text(encoding="utf-8").splitlines()[:2] == ["grasp,pose,successes,attempts", "rim,upright 0,15,15"]
    assert read_scores(file, GRASPS, POSES) == SCORES


def test_the_order_of_rows_and_columns_other_columns_and_the_separator_do_not_matter(tmp_path: Path) -> None:
    file = tmp_path / "scores.csv"
    rows = ["15;who;upright 90;rim;0", "15;ab;upright 0;rim;15", ";;;;", "15;;upright 90;handle;7"]
    rows += ["15;;upright 0;handle;3"]
    file.write_text("\n".join(["attempts;by;pose;grasp;successes", *rows]), encoding="utf-8-sig")
    assert read_scores(file, GRASPS, POSES) == SCORES


def test_different_numbers_of_attempts_become_shares(tmp_path: Path) -> None:
    file = tmp_path / "scores.csv"
    file.write_text("grasp,pose,successes,attempts\nrim,a,1,2\nrim,b,1,4\n", encoding="utf-8")
    assert read_scores(file, ["rim"], ["a", "b"]) == GivenScores(probabilities=[[0.5, 0.25]])


def test_an_empty_table_says_which_cell_to_fill(tmp_path: Path) -> None:
    file = tmp_path / "scores.csv"
    write_empty_scores(file, GRASPS, POSES)
    assert len(file.read_text(encoding="utf-8").splitlines()) == 5
    with pytest.raises(
        InvalidScores, match=r"row 2, column attempts: expected a whole number from 1 .* 'an empty cell'"
    ):
        read_scores(file, GRASPS, POSES)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "row 1: expected the columns grasp, pose, successes, attempts; missing: grasp, pose"),
        ("grasp,pose,k,n\n", "missing: successes, attempts"),
        ("grasp,pose,successes,attempts\nrim,a,16,15\n", "row 2, column successes: .* from 0 to 15 .* got '16'"),
        ("grasp,pose,successes,attempts\nrim,a,1.5,15\n", "column successes: .* got '1.5'"),
        ("grasp,pose,successes,attempts\nrim,a,1\n", "row 2: expected 4 columns, got 3"),
        (
            "grasp,pose,successes,attempts\nbase,a,1,15\n",
            "row 2, column grasp: .* no grasp 'base'; expected one of 'rim'",
        ),
        ("grasp,pose,successes,attempts\nrim,c,1,15\n", "row 2, column pose: .* no pose 'c'; expected one of 'a', 'b'"),
        ("grasp,pose,successes,attempts\nrim,a,1,15\nrim,a,1,15\n", "row 3: expected one row for grasp 'rim' at pose"),
        ("grasp,pose,successes,attempts\nrim,a,1,15\n", "missing: grasp 'rim' at pose 'b'"),
    ],
)
def test_a_mistake_is_named_with_its_row_and_column(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "scores.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidScores, match=message):
        read_scores(file, ["rim"], ["a", "b"])


def test_a_file_that_is_absent_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidScores, match=r"absent\.csv"):
        read_scores(tmp_path / "absent.csv", ["rim"], ["a"])
