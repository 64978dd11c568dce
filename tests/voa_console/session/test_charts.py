"""Charts of the belief and of the time line."""

import pytest

from tests.voa_console.session.test_moments import HISTORY
from voa_console.session.charts import MOST_BARS, belief_chart, belief_chart_height, time_chart


def test_the_likeliest_poses_come_first_and_the_others_are_summed_up() -> None:
    poses = [f"P{index}" for index in range(20)]
    belief = [0.02] * 19 + [0.62]
    options = belief_chart(poses, belief)
    assert options["yAxis"]["data"][0] == "P19"
    assert options["yAxis"]["data"][-1] == f"{20 - MOST_BARS} others"
    bars = options["series"][0]["data"]
    assert sum(bar["value"] for bar in bars) == pytest.approx(1.0)
    assert bars[0]["label"]["formatter"] == "0.620"
    assert bars[0]["itemStyle"]["color"] != bars[1]["itemStyle"]["color"]


def test_a_few_poses_are_all_shown() -> None:
    options = belief_chart(["A", "B"], [0.25, 0.75])
    assert options["yAxis"]["data"] == ["B", "A"]
    assert belief_chart_height(2) < belief_chart_height(8) < belief_chart_height(1000) == belief_chart_height(2000)


def test_the_time_line_has_both_figures_of_every_version_and_marks_the_one_shown() -> None:
    score, entropy = time_chart(HISTORY, 1)["series"]
    assert score["data"] == [[0, 0.4], [1, 0.4], [2, 0.4]]
    assert entropy["data"] == [[0, 0.6], [1, 0.6], [2, 0.6]]
    assert score["markLine"]["data"] == [{"xAxis": 1}]
    assert score["yAxisIndex"] != entropy["yAxisIndex"]
