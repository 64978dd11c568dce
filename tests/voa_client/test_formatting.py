"""Figures and rankings as a person reads them: no figure contradicts the sentence beside it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voa_client.formatting import (
    absence,
    bar,
    perfect_information,
    ranks,
    recommendation,
    scale,
    scans,
    score_error,
    share,
    signed,
    signed_apart,
    unsigned,
    with_article,
    with_error,
)
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


def simulated(*looks: tuple[float, float], ties: tuple[bool, ...] = (), **changes: object) -> Ranking:
    """Make a ranking over simulated scans of looks with these net values and standard errors, best first."""
    tied = (*ties, *[False] * len(looks))[: len(looks)] if ties else (True, *[False] * (len(looks) - 1))
    answer = ranking(*(value for value, _ in looks))
    ranked = [
        look.model_copy(update={"standard_error": error, "ties_with_first": tie, "score_standard_error": 0.01 * index})
        for index, (look, (_, error), tie) in enumerate(zip(answer.ranking, looks, tied, strict=True))
    ]
    fields = {"ranking": ranked, "scans": "simulated", "samples": 43, "definition": "executed"}
    return answer.model_copy(update=fields | changes)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.155, None, "+0.155"),
        (0.155, 0.0042, "+0.155 ± 0.004"),
        (-0.01, 0.0004, "-0.010 ± <0.001"),
        (0.0, 0.0, "0 ± 0"),
    ],
)
def test_a_value_is_written_with_its_error(value: float, error: float | None, text: str) -> None:
    assert with_error(value, error) == text


def test_ties_with_the_first_are_the_service_s_and_the_others_those_that_errors_leave_open() -> None:
    looks = ((0.30, 0.01), (0.29, 0.01), (0.28, 0.01), (0.265, 0.01), (0.2, 0.001), (0.19, 0.001))
    assert ranks(simulated(*looks, ties=(True, False, True))) == ["=1", "=2", "=1", "=2", "5", "6"]
    assert ranks(simulated((0.3, 0.0), (0.3 - 5e-7, 0.0), (0.2, 0.0), (0.2, 0.0))) == ["1", "2", "=3", "=3"]


def test_the_sentence_over_simulated_scans_names_the_errors_that_decide() -> None:
    assert recommendation(simulated((0.155, 0.004), (0.1, 0.004)), 0.005) == (
        "look from Q0 first: its net value +0.155 ± 0.004 is more than min_gain 0.005 by two standard errors"
    )
    grasp = GraspNow(action="grasp", grasp="G4", expected_score=0.93)
    assert recommendation(simulated((0.012, 0.006), (0.0, 0.006), recommendation=grasp), 0.005) == (
        "grasp G4 now, expected score 0.930: no look's net value is more than min_gain 0.005 by two standard errors "
        "(Q0: +0.012 ± 0.006)"
    )


@given(st.floats(-0.2, 0.5), st.floats(1e-4, 0.1), st.sampled_from([0.0, 0.005, 0.05]))
def test_no_sentence_over_simulated_scans_contradicts_its_figures(value: float, error: float, limit: float) -> None:
    looks = value - 2.0 * error > limit
    advice = Look(action="look", sensor="Q0", net_value=value)
    grasp = GraspNow(action="grasp", grasp="G4", expected_score=0.93)
    text = recommendation(simulated((value, error), recommendation=advice if looks else grasp), limit)
    figures = re.search(r"([+-]?[0-9.]+) ± ([0-9.]+)", text)
    if figures is not None and abs(value - 2.0 * error - limit) > 1e-9:
        assert (float(figures[1]) - 2.0 * float(figures[2]) > limit) is looks, text


def test_a_pair_is_recommended_as_one() -> None:
    pair = Look(action="look", sensor="Q1", net_value=0.34, then="Q0")
    text = "look from Q1, then from Q0: together their net value +0.340 is more than min_gain 0.005"
    assert recommendation(ranking(-0.03, -0.03).model_copy(update={"recommendation": pair}), 0.005) == (
        f"{text}, and no single look's is"
    )
    assert recommendation(simulated((-0.03, 0.001), (-0.03, 0.001), recommendation=pair), 0.005) == (
        f"{text} by two standard errors, and no single look's is"
    )


def test_the_most_that_looks_can_gain_is_stated_if_it_is_known() -> None:
    assert perfect_information(ranking(0.1)) is None
    assert perfect_information(simulated((0.1, 0.0), value_of_perfect_information=0.3667)) == (
        "at most +0.367 can be gained by looking: the gain if the pose were known"
    )
    nothing = perfect_information(simulated((0.0, 0.0), value_of_perfect_information=0.0))
    assert nothing is not None
    assert nothing.startswith("nothing can be gained by looking")


def test_scans_and_the_error_of_counted_scores_are_described() -> None:
    assert scans(ranking(0.1)) == "1 exact scan of each pose"
    assert scans(simulated((0.1, 0.0))) == "43 simulated scans of each pose"
    assert scans(simulated((0.1, 0.0), samples=1)) == "1 simulated scan of each pose"
    of_a_sample = ranking(0.1).model_copy(update={"method": "sampled"})
    assert scans(of_a_sample) == "exact scans of a sample of the poses"
    assert score_error(ranking(0.1)) is None
    assert score_error(simulated((0.1, 0.0), (0.1, 0.0), (0.1, 0.0))) == (
        "the counts behind the grasp scores add a standard error of up to 0.020"
    )


def test_absence_is_stated_where_it_is_considered() -> None:
    assert absence(None) is None
    assert absence(0.0) == "object at none of the poses: probability 0"
    assert absence(0.83) == "object at none of the poses: probability 0.830"


def test_a_noun_gets_its_article() -> None:
    assert [with_article(noun) for noun in ("mug", "elbow", "Iron", "")] == ["A mug", "An elbow", "An Iron", "A "]
