"""Advice, updates and reasons in plain sentences."""

from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.serving import data_scenario
from voa_console.sentences import REASONS
from voa_console.session.words import Advice, advice, after_success, cause_of, changes, listed, place_of, step_of
from voa_msgs.rankings import RankedSensor, Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry, Reason

AT = datetime(2026, 11, 29, tzinfo=UTC)
SCENARIO = Scenario.model_validate(data_scenario() | {"id": "c", "created_at": AT})
Json = dict[str, Any]


def row(sensor: str, voa: float, *, ties: bool = False, **more: Any) -> Json:
    return {
        "sensor": sensor,
        "voa": voa,
        "standard_error": None,
        "cost": 0.0,
        "net_value": voa,
        "expected_score_after": 0.4 + voa,
        "ties_with_first": ties,
    } | more


def ranking(recommendation: Json, *rows: Json) -> Ranking:
    return Ranking.model_validate(
        {
            "version": 1,
            "definition": "posterior",
            "value_of_perfect_information": 0.3,
            "method": "exact",
            "precision": "float64",
            "expected_score_before": 0.4,
            "best_grasp_before": "G1",
            "ranking": list(rows),
            "recommendation": recommendation,
        }
    )


def test_a_look_is_advised_with_its_value_its_error_and_its_equals() -> None:
    made = ranking(
        {"action": "look", "sensor": "Q1", "net_value": 0.15},
        row("Q1", 0.15, ties=True, standard_error=0.004),
        row("Q2", 0.149, ties=True, standard_error=0.004),
    )
    written = advice(made, SCENARIO)
    assert written.headline == "Look from Q1 next."
    assert "from 0.40 to 0.55: its Value of Assistance (VOA) is +0.150 ± 0.004." in written.details[0]
    assert "About equal: Q2." in written.details
    assert any(
        sentence == "If the pose were known exactly, the probability would rise by +0.300."
        for sentence in written.details
    )


def test_a_pair_of_looks_is_advised_together() -> None:
    made = ranking({"action": "look", "sensor": "Q1", "net_value": 0.1, "then": "Q2"}, row("Q1", 0.0, ties=True))
    assert advice(made, SCENARIO).headline == "Look from Q1, then from Q2."


def test_a_grasp_is_advised_with_the_reason_why_no_look_is() -> None:
    made = ranking({"action": "grasp", "grasp": "G1", "expected_score": 0.9}, row("Q1", 0.001, ties=True))
    written = advice(made, SCENARIO)
    assert written.headline == "Grasp G1 now: its expected score is 0.90."
    expected = "No look is worth taking: the best is expected to add +0.001, and at least 0.005 is wanted."
    assert expected in written.details
    none = ranking({"action": "grasp", "grasp": None, "expected_score": 0.0}, row("Q1", 0.0, ties=True))
    assert advice(none, SCENARIO).headline == "No grasp can succeed, and no look would change that."


def outcomes(*grasps: tuple[str, float]) -> RankedSensor:
    rows = [
        {"pose": f"P{index}", "probability": held, "best_grasp": name, "expected_score": 0.5}
        for index, (name, held) in enumerate(grasps)
    ]
    return RankedSensor.model_validate(row("Q1", 0.1, outcomes=rows))


def test_what_a_look_would_change_is_the_best_grasp_with_its_probability() -> None:
    assert changes(outcomes(("G1", 0.3), ("G2", 0.6), ("G1", 0.1))) == (
        "After it, the best grasp will be G2 with probability 0.60 or G1 with probability 0.40."
    )
    assert changes(outcomes(("G1", 1.0)), "G1") == "After it, G1 is still the best grasp whatever the scan shows."
    assert changes(outcomes(("G2", 1.0)), "G1") == "After it, G2 is the best grasp whatever the scan shows."
    assert changes(None) == ""


def entry(kind: str, request: Json, update: Json | None = None) -> HistoryEntry:
    report = None
    if update is not None:
        report = {
            "accepted": True,
            "reason": None,
            "log_evidence": None,
            "fit_rmsd_mm": None,
            "fit_hit_rmsd_mm": None,
            "best_fit_pose": None,
            "beams_compared": 4,
        } | update
    body = {"version": 1, "kind": kind, "at": AT, "request": request, "update": report}
    return HistoryEntry.model_validate(body)


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (entry("prior", {}), "The session was opened; its belief is the prior."),
        (entry("belief", {"belief": None}), "The belief was reset to the prior."),
        (entry("belief", {"belief": [1.0]}), "The belief was replaced by a stated one."),
        (
            entry("scan", {"sensor": "Q1"}, {"best_fit_pose": "P1", "fit_rmsd_mm": 1.84}),
            "Scan from Q1. Best fit: P1, 1.8 mm over 4 beams.",
        ),
        (
            entry("scan", {"sensor": "Q1"}, {"reason": "nearest"}),
            "Scan from Q1. No pose explains the scan, so the nearest poses share the belief.",
        ),
        (
            entry("outcome", {"grasp": "G1", "success": False, "object_moved": 0.5}, {"accepted": False}),
            "Grasp G1 failed. The object was moved with probability 0.50. Not accepted.",
        ),
    ],
)
def test_each_version_says_what_made_it(made: HistoryEntry, sentence: str) -> None:
    assert cause_of(made) == sentence


def test_every_reason_of_the_service_has_words() -> None:
    assert set(REASONS) == set(Reason.__args__)  # type: ignore[attr-defined] # the values of a Literal


def test_places_and_names_are_written_out() -> None:
    assert (
        place_of({"sensor_pose": {"x": 0.3, "y": -0.2, "yaw_rad": 3.141592653589793}})
        == "x 0.30 m, y -0.20 m, yaw 180°"
    )
    assert listed(["a", "b"]) == "a and b"
    assert listed(["a", "b", "c"], 2) == "a, b and 1 more"


def test_after_a_success_the_advice_holds_only_if_the_object_was_put_back() -> None:
    written = Advice("Grasp G1 now: its expected score is 0.90.", ("No look is worth taking.",))
    done = after_success(written, entry("outcome", {"grasp": "G1", "success": True}))
    assert done.headline == "Done: grasp G1 succeeded."
    assert done.details[0] == "If the object was put back: grasp G1 now: its expected score is 0.90."
    for other in (None, entry("outcome", {"grasp": "G1", "success": False}), entry("scan", {"sensor": "Q1"})):
        assert after_success(written, other) == written


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (entry("prior", {}), "Session opened"),
        (entry("belief", {"belief": None}), "Belief reset"),
        (entry("belief", {"belief": [1.0]}), "Belief replaced"),
        (entry("scan", {"sensor": "Q1"}), "Scan from Q1"),
        (entry("outcome", {"grasp": "G1", "success": True}), "Grasp G1 succeeded"),
        (entry("outcome", {"grasp": "G1", "success": False}), "Grasp G1 failed"),
    ],
)
def test_each_version_is_a_step_in_a_few_words(made: HistoryEntry, words: str) -> None:
    assert step_of(made) == words
