"""Runs are kept a line each, and drawn beside their gates."""

from pathlib import Path

from tests.benchmarks import history
from tests.benchmarks.history import Run
from tests.benchmarks.measure import Result

NUMPY = "ranking, 20 grasps, float32 / numpy loop"
RESULTS = [Result(NUMPY, 1.23456, 2.0, 3.0, "ms"), Result("growth: no gate", 1.0, 1.0, 1.0, "ms")]


def test_a_run_is_kept_with_its_commit_and_the_ratios_that_have_a_gate(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    assert history.kept(path) == []
    run = history.run_of(RESULTS, "2026-11-29 12:00 UTC", "a machine, 2 cores")
    assert run.ratios == {NUMPY: 1.235}
    assert len(run.commit.rstrip("+")) >= 7
    for _ in range(2):
        history.keep(run, path)
    assert history.kept(path) == [run, run]
    assert len(path.read_text(encoding="utf-8").splitlines()) == 2


def test_the_picture_names_each_ratio_and_does_not_change_with_the_time(tmp_path: Path) -> None:
    runs = [Run("0000000", "then", "a machine", {NUMPY: ratio, "of another time": 1.0}) for ratio in (0.8, 1.6)]
    pictures = [tmp_path / "one.svg", tmp_path / "two.svg"]
    for picture in pictures:
        history.draw(runs, picture)
    first, second = (picture.read_text(encoding="utf-8") for picture in pictures)
    assert first == second
    assert NUMPY in first
    assert "of another time" not in first


def test_the_runs_that_are_kept_can_be_drawn(tmp_path: Path) -> None:
    runs = history.kept()
    assert runs, f"expected at least one run in {history.HISTORY}"
    history.draw(runs, tmp_path / "history.svg")
    assert history.PICTURE.exists()
