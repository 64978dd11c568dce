"""Beliefs, rankings and grasps of the service, compared with a brute-force twin."""

import math
from typing import Any

import pytest

from tests.contract.values import BELIEF, GOOD, as_twin, measured, scans
from tests.support import twin
from tests.support.serving import POSES, PREDICTIONS, SCORES, Json, Service, data_scenario, scan_of

RULES: list[tuple[str, Json]] = [
    ("margin", {"margin_m": 0.25}),
    ("exponential", {}),
    ("gaussian", {"sigma_m": 0.3}),
    ("inverse_rmsd", {"floor_m": 0.001}),
]


@pytest.mark.parametrize(("rule", "parameters"), RULES)
def test_stateless_calls_session_calls_and_the_twin_agree(service: Service, rule: str, parameters: Json) -> None:
    update = {"rule": rule, "no_return_m": 1.0, "on_no_match": "nearest"} | parameters
    scenario = service.create(data_scenario(update=update))
    session = service.open(scenario, prior=BELIEF)
    twin_parameters = parameters | {"no_return_m": 1.0}

    def logs(beams: list[float], sensor: str) -> tuple[list[float], list[float]]:
        predicted = [as_twin(PREDICTIONS[sensor][pose]) for pose in POSES]
        return (
            [twin.log_weight(rule, twin_parameters, beams, other) for other in predicted],
            [twin.distance(beams, other, 1.0) for other in predicted],
        )

    voa = {}
    for sensor in ("Q1", "Q2"):
        each = [logs(as_twin(PREDICTIONS[sensor][pose]), sensor) for pose in POSES]
        voa[sensor] = twin.value_of_assistance(
            SCORES, BELIEF, [one[0] for one in each], [one[1] for one in each], on_no_match="nearest"
        )
    ranked = service.get(f"/v1/sessions/{session}/voa")
    once = service.post("/v1/rankings", {"scenario": scenario, "belief": BELIEF})
    assert ranked | {"version": None} == once
    assert {look["sensor"]: look["voa"] for look in ranked["ranking"]} == pytest.approx(voa, abs=1e-12)
    assert [look["sensor"] for look in ranked["ranking"]] == [
        ("Q1", "Q2")[i] for i in twin.ranking([voa["Q1"], voa["Q2"]], [0.0, 0.0])
    ]

    stateless = service.post("/v1/updates", {"scenario": scenario, "belief": BELIEF} | scan_of(GOOD))
    applied = service.post(scans(session), scan_of(GOOD))
    shared = set(stateless) - {"version"}
    assert {name: applied[name] for name in shared} == {name: stateless[name] for name in shared}
    expected = twin.update(BELIEF, *logs(measured(GOOD), "Q1"), 3, on_no_match="nearest")
    assert applied["belief"] == pytest.approx(expected.belief, abs=1e-12)
    assert applied["update"]["log_evidence"] == pytest.approx(expected.log_evidence, abs=1e-12)
    grasp, score = twin.best_grasp(SCORES, expected.belief)
    assert applied["best_grasp"] == (None if grasp is None else f"G{grasp + 1}")
    assert applied["expected_score"] == pytest.approx(score, abs=1e-12)
    entropy = -math.fsum(share * math.log(share) for share in expected.belief if share)
    assert applied["entropy_nats"] == pytest.approx(entropy, abs=1e-12)
    grasps = service.get(f"/v1/sessions/{session}/grasps")
    assert grasps["version"] == 1
    assert {row["name"]: row["expected_score"] for row in grasps["grasps"]} == pytest.approx(
        {f"G{x + 1}": twin.expected_score(row, expected.belief) for x, row in enumerate(SCORES)}
    )


def test_executed_value_and_a_sensor_belief_agree_with_the_twin(service: Service, data_id: str) -> None:
    other = [0.6, 0.3, 0.1]
    body = {"scenario": data_id, "belief": BELIEF, "definition": "executed", "sensor_belief": other, "sensors": ["Q1"]}
    predicted = [as_twin(PREDICTIONS["Q1"][pose]) for pose in POSES]
    parameters = {"no_return_m": 1.0}
    expected = twin.value_of_assistance(
        SCORES,
        BELIEF,
        [[twin.log_weight("exponential", parameters, scan, pose) for pose in predicted] for scan in predicted],
        [[twin.distance(scan, pose, 1.0) for pose in predicted] for scan in predicted],
        definition="executed",
        sensor_belief=other,
    )
    answer = service.post("/v1/rankings", body)
    assert answer["ranking"][0]["voa"] == pytest.approx(expected, abs=1e-12)
    assert answer["definition"] == "executed"
    assert service.post("/v1/rankings", body | {"sensor_belief": BELIEF})["ranking"] != answer["ranking"]


def test_outcomes_are_listed_only_when_requested(service: Service, data_id: str) -> None:
    session = service.open(data_id, prior=BELIEF)
    without, with_outcomes = (service.get(f"/v1/sessions/{session}/voa{query}") for query in ("", "?outcomes=true"))
    assert all("outcomes" not in look for look in without["ranking"])
    for look in with_outcomes["ranking"]:
        assert [outcome["pose"] for outcome in look["outcomes"]] == list(POSES)
        assert [outcome["probability"] for outcome in look["outcomes"]] == pytest.approx(BELIEF)
        after = math.fsum(outcome["probability"] * outcome["expected_score"] for outcome in look["outcomes"])
        assert after == pytest.approx(look["expected_score_after"])
        assert look["voa"] == pytest.approx(after - with_outcomes["expected_score_before"])


def test_costs_count_and_the_recommendation_follows_them(service: Service) -> None:
    def ranked(*costs: float) -> Any:
        sensors = [
            {"name": f"Q{i + 1}", "x": 0.0, "y": 0.0, "yaw_rad": 0.0, "cost": cost} for i, cost in enumerate(costs)
        ]
        return service.get(f"/v1/sessions/{service.open(service.create(data_scenario(sensors=sensors)))}/voa")

    free = ranked(0.0, 0.0)
    best = free["ranking"][0]
    assert best["voa"] > 0.01
    assert free["recommendation"] == {"action": "look", "sensor": best["sensor"], "net_value": best["net_value"]}
    dear = ranked(1.0, 1.0)
    assert dear["ranking"][0]["net_value"] == pytest.approx(best["voa"] - 1.0)
    assert dear["recommendation"] == {
        "action": "grasp",
        "grasp": dear["best_grasp_before"],
        "expected_score": dear["expected_score_before"],
    }
    first = int(best["sensor"][1]) - 1
    costs = [0.0, 0.0]
    costs[first] = 0.5
    assert ranked(*costs)["ranking"][0]["sensor"] != best["sensor"]


def test_a_subset_of_grasps_is_all_that_counts(service: Service, data_id: str) -> None:
    session = service.open(data_id, prior=BELIEF)
    alone = service.post(f"/v1/sessions/{session}/voa", {"grasps": ["G1"]})
    assert alone["best_grasp_before"] == "G1"
    assert alone["expected_score_before"] == pytest.approx(twin.expected_score(SCORES[0], BELIEF))
    listed = service.get(f"/v1/sessions/{session}/grasps?grasps=G2")
    assert [row["name"] for row in listed["grasps"]] == ["G2"]


def test_a_grasp_that_cannot_succeed_is_none(service: Service) -> None:
    session = service.open(service.create(data_scenario(scores={"probabilities": [[0.0] * 3] * 2})))
    assert service.get(f"/v1/sessions/{session}")["best_grasp"] is None
    ranking = service.get(f"/v1/sessions/{session}/voa")
    assert ranking["best_grasp_before"] is None
    assert ranking["recommendation"] == {"action": "grasp", "grasp": None, "expected_score": 0.0}
