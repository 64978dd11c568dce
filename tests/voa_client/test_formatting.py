"""Figures and rankings as a person reads them: no figure contradicts the sentence beside it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voa_client.formatting import bar, ranks, recommendation, scale, share, signed, signed_apart, unsigned
from voa_msgs.rankings import GraspNow, Look, RankedSensor, Ranking

TIE = 1e-6
FIGURE = re.compile(r"its net value (.+) is more than|\((?:all|Q0): ([^)]+)\)")


def ranking(*net_values: float, min_gain: float = 0.005, grasp: str | None = "G4") -> Ranking:
    """Make the ranking that the service would answer for looks with these net values, best first."""
    first = net_values[0] if net_values else 0.0
    looks = [
        RankedSensor(
            sensor=f"Q{index}",
            voa=value,
            standard_error=None,
            cost=0.0,
            net_value=value,
            expected_score_after=0.5 + value,
            ties_with_first=first - value <= TIE,
        )
        for index, value in enumerate(net_values)
    ]
    look = Look(action="look", sensor="Q0", net_value=first)
    now = GraspNow(action="grasp", grasp=grasp, expected_score=0.93)
    return Ranking(
        version=0,
        definition="posterior",
        method="exact",
        precision="float64",
        expected_score_before=0.5,
        best_grasp_before=grasp,
        ranking=looks,
        recommendation=look if first > min_gain else now,
    )


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1549, "+0.155"),
        (-0.0104, "-0.010"),
        (0.0, "0"),
        (-0.0, "0"),
        (-1e-17, "0"),
        (0.0004, "< 0.001"),
        (-0.0004, "> -0.001"),
        (0.0006, "+0.001"),
        (1.0, "+1.000"),
    ],
)
def test_differences_are_never_rounded_to_nothing(value: float, text: str) -> None:
    assert signed(value) == text
    assert unsigned(abs(value)) == signed(abs(value)).lstrip("+")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1.0, "1"), (1.0 + 1e-13, "1"), (0.004, "< 0.01"), (0.996, "> 0.99"), (0.125, "0.12"), (0.5, "0.50")],
)
def test_shares_are_0_and_1_only_where_they_are(value: float, text: str) -> None:
    assert share(value) == text


@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_a_figure_shows_on_which_side_of_a_limit_it_lies(value: float, limit: float) -> None:
    text = signed_apart(value, limit)
    assert text not in ("+0.000", "-0.000")
    if "<" in text or ">" in text:  # only far from the limit: less than half a thousandth, or its like
        assert abs(value) < abs(value - limit) + 0.0005
    elif abs(value - limit) > 1e-9:
        assert (float(text) > limit) == (value > limit) or float(text) == pytest.approx(limit, abs=1e-3)


@given(st.lists(st.floats(-0.3, 0.9), min_size=1, max_size=6), st.sampled_from([0.0, 0.0004, 0.005, 0.3]))
def test_no_sentence_contradicts_its_figures(net_values: list[float], min_gain: float) -> None:
    answer = ranking(*sorted(net_values, reverse=True), min_gain=min_gain)
    text = recommendation(answer, min_gain)
    figure = FIGURE.search(text)
    assert figure is not None, text
    assert f"min_gain {min_gain:g}" in text
    if isinstance(answer.recommendation, Look):
        if answer.recommendation.net_value - min_gain > 1e-11:
            assert float(figure[1]) > min_gain, text
        assert text.startswith("look from Q0 first")
    else:
        assert figure[2].startswith(("<", ">")) or float(figure[2]) <= min_gain, text
        assert text.startswith("grasp G4 now, expected score 0.930: no look's net value is more than")


def test_the_sentence_says_why() -> None:
    assert recommendation(ranking(0.155, 0.1), 0.005) == (
        "look from Q0 first: its net value +0.155 is more than min_gain 0.005"
    )
    assert recommendation(ranking(0.00504, 0.00504, 0.00504), 0.005) == (
        "look from Q0 first: its net value +0.00504 is more than min_gain 0.005 (2 others tie with it)"
    )
    assert recommendation(ranking(0.003, 0.0), 0.005) == (
        "grasp G4 now, expected score 0.930: no look's net value is more than min_gain 0.005 (Q0: +0.003)"
    )
    assert recommendation(ranking(0.0, 0.0), 0.005).endswith("min_gain 0.005 (all: 0)")
    assert recommendation(ranking(0.0, grasp=None), 0.005) == (
        "no look's net value is more than min_gain 0.005 (Q0: 0), and no grasp can succeed"
    )
    assert recommendation(ranking(), 0.005).endswith("there is no place to look from")


@pytest.mark.parametrize(
    ("net_values", "numbers"),
    [
        ((0.3, 0.2, 0.1), ["1", "2", "3"]),
        ((0.3, 0.3, 0.1), ["=1", "=1", "3"]),
        ((0.3, 0.3 - 5e-7, 0.3 - 2e-6), ["=1", "=1", "3"]),
        ((0.3, 0.0, 0.0, -0.1), ["1", "=2", "=2", "4"]),
        ((0.0, 0.0), ["=1", "=1"]),
        ((), []),
    ],
)
def test_looks_that_tie_share_their_rank(net_values: tuple[float, ...], numbers: list[str]) -> None:
    assert ranks(ranking(*net_values)) == numbers


def test_bars_are_drawn_where_their_scale_is_stated() -> None:
    assert (scale(0.5), bar(0.25, 0.5, 8)) == ("0 to 0.5", "████")
    assert (scale(1e-16), bar(1e-16, 1e-16, 8)) == ("", "")
    assert bar(-0.1, 0.5, 8) == bar(0.0, 0.5, 8) == ""
