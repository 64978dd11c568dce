"""Ratios are judged by the gates, and the median of several runs counts."""

import importlib
import re
from pathlib import Path

import pytest

from tests.benchmarks import gates
from tests.benchmarks.gates import GATES, GOALS, gate_of, goal_of, median_of, missed
from tests.benchmarks.measure import Result

REPOSITORY = Path(__file__).parents[2]
NUMPY = "ranking, 20 grasps, float32 / numpy loop"
SPREAD = "spread, beam: weights of 256 scans, a place / without"


def result(name: str, ratio: float | None, ours: float = 1.0) -> Result:
    return Result(name, ratio, ours, None, "ms")


@pytest.mark.parametrize(
    ("name", "ratio", "kept"),
    [
        (NUMPY, 1.5, True),
        (NUMPY, 1.49, False),
        (SPREAD, 8.0, True),
        (SPREAD, 8.01, False),
        ("growth: unjudged", 0.0, True),
    ],
)
def test_a_ratio_on_the_wrong_side_of_its_gate_is_missed(name: str, ratio: float, *, kept: bool) -> None:
    assert missed([result(name, ratio)]) == ([] if kept else [name])


def test_a_result_with_a_gate_and_no_ratio_is_missed() -> None:
    assert missed([result(NUMPY, None)]) == [NUMPY]


@pytest.mark.parametrize("gate", GATES, ids=lambda gate: gate.pattern)
def test_the_margin_is_1_at_the_gate_and_more_at_the_goal(gate: gates.Gate) -> None:
    assert gate.margin(gate.bound) == 1.0
    assert gate.kept_by(gate.bound)
    if gate.goal is None:
        assert not gate.reached_by(gate.bound)
    else:
        assert gate.margin(gate.goal) > 1.0
        assert gate.reached_by(gate.goal)
        assert not gate.reached_by(gate.bound)


def test_the_median_of_whole_runs_is_one_of_their_results() -> None:
    runs = [
        [result(NUMPY, ratio, ours), result("bare", None, ours)] for ratio, ours in ((3.0, 1.0), (1.0, 2.0), (2.0, 9.0))
    ]
    assert median_of(runs) == [runs[2][0], runs[1][1]]


def test_every_gate_is_stated_on_the_page() -> None:
    page = (REPOSITORY / "deploy" / "docs" / "speed.md").read_text(encoding="utf-8")
    demands = page[: page.index("## What the newest runs printed")]
    stated = [float(number) for number in re.findall(r"\d+(?:\.\d+)?", demands)]
    for gate in GATES:
        assert gate.bound in stated, gate
        assert gate.goal is None or gate.goal in stated, gate
    for pattern, goal in GOALS:
        assert goal in stated, pattern


def test_a_result_may_have_a_goal_without_a_gate() -> None:
    windowed = "prediction, 10k faces, general poses / embree kernel, windowed beams"
    assert gate_of(windowed) is None
    assert goal_of(windowed) == 1.0
    assert missed([result(windowed, 0.5)]) == []
    assert goal_of(SPREAD) == gate_of(SPREAD).goal  # type: ignore[union-attr] # it has a gate
    assert goal_of("growth: unjudged") is None


def test_no_gate_is_left_without_a_result_by_a_name_that_has_changed() -> None:
    sources = "".join(
        Path(importlib.import_module(f"tests.benchmarks.{name}").__file__ or "").read_text(encoding="utf-8")
        for name in ("prediction", "weights", "ranking", "spread", "huge", "service", "startup", "durable", "bus")
    )
    peers = ("embree kernel", "trimesh+embreex", "scipy cdist", "numpy loop", "filterpy loop (scaled)")
    for words in (*(f"/ {peer}" for peer in peers), "/ bare transactions by 16 threads"):
        assert words in sources
        assert any(words in gate.pattern.replace("\\", "") for gate in GATES)
    assert gate_of(NUMPY) is not gate_of(SPREAD) is not None
