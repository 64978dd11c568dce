"""Outcomes of grasps: counted scores weigh repeated attempts, and a moved object mixes in the session's prior."""

from typing import Any

import pytest

from tests.support.places import seen_from
from tests.support.serving import SCORES, Json, Service, data_scenario

ATTEMPTS, SUCCESSES = 15, [[15, 1, 7], [0, 12, 7]]
PRIOR = [0.5, 0.3, 0.2]


@pytest.fixture(scope="module")
def counted(service: Service) -> str:
    """A scenario whose scores are counts: G1 never failed at P1."""
    return service.create(data_scenario(name="counted", scores={"attempts": ATTEMPTS, "successes": SUCCESSES}))


def report(service: Service, session: str, success: bool, grasp: str = "G1", **more: Any) -> Json:
    body = {"grasp": grasp, "success": success} | more
    answer: Json = service.post(f"/v1/sessions/{session}/grasp-outcomes", body)
    return answer


def normalised(weights: list[float]) -> list[float]:
    return [weight / sum(weights) for weight in weights]


def weight(successes: int, outcomes: list[bool]) -> float:
    """Probability of outcomes in a row, under the Beta distribution of a score, from the page."""
    won, lost = successes + 0.5, ATTEMPTS - successes + 0.5
    product = 1.0
    for success in outcomes:
        product *= (won if success else lost) / (won + lost)
        won, lost = won + success, lost + (not success)
    return product


@pytest.mark.parametrize("outcomes", [[False], [True], [False] * 3, [True, False, True]])
def test_repeated_attempts_of_counted_scores_are_one_witness_less_each_time(
    service: Service, counted: str, outcomes: list[bool]
) -> None:
    session = service.open(counted, prior=PRIOR)
    for number, success in enumerate(outcomes):
        answer = report(service, session, success)
        expected = [p * weight(count, outcomes[: number + 1]) for p, count in zip(PRIOR, SUCCESSES[0], strict=True)]
        assert answer["belief"] == pytest.approx(normalised(expected), abs=1e-12)
    assert min(answer["belief"]) > 0.0, "no count rules a pose out"


def test_attempts_of_one_grasp_say_nothing_of_those_of_another(service: Service, counted: str) -> None:
    session = service.open(counted, prior=PRIOR)
    for grasp in ("G1", "G2", "G1"):
        answer = report(service, session, False, grasp)
    expected = [
        p * weight(SUCCESSES[0][pose], [False, False]) * weight(SUCCESSES[1][pose], [False])
        for pose, p in enumerate(PRIOR)
    ]
    assert answer["belief"] == pytest.approx(normalised(expected), abs=1e-12)


def test_probabilities_weigh_each_attempt_alike(service: Service, data_id: str) -> None:
    session = service.open(data_id, prior=PRIOR)
    for number in (1, 2, 3):
        answer = report(service, session, False)
        expected = [p * (1.0 - q) ** number for p, q in zip(PRIOR, SCORES[0], strict=True)]
        assert answer["belief"] == pytest.approx(normalised(expected), abs=1e-12)


def test_a_replaced_belief_forgets_the_attempts(service: Service, counted: str) -> None:
    session = service.open(counted, prior=PRIOR)
    first = report(service, session, False)["belief"]
    report(service, session, False)
    service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).raise_for_status()
    assert report(service, session, False)["belief"] == first


@pytest.mark.parametrize("moved", [0.25, 1.0])
def test_a_moved_object_mixes_the_sessions_own_prior_into_the_belief(
    service: Service, counted: str, moved: float
) -> None:
    session, other = (service.open(counted, prior=PRIOR) for _ in range(2))
    report(service, session, False)
    plain = [report(service, other, False) for _ in range(2)][-1]
    answer = report(service, session, False, object_moved=moved)
    expected = [(1.0 - moved) * p + moved * prior for p, prior in zip(plain["belief"], PRIOR, strict=True)]
    assert answer["belief"] == pytest.approx(expected, abs=1e-12)
    assert answer["update"]["accepted"]
    after = [p * weight(count, [False]) for p, count in zip(answer["belief"], SUCCESSES[0], strict=True)]
    again = report(service, session, False)
    assert again["belief"] == pytest.approx(normalised(after), abs=1e-12), "earlier attempts no longer count"


def test_a_moved_object_ends_its_places(service: Service, mesh_id: str) -> None:
    session = service.open(mesh_id)
    scan = seen_from(service, "E", "A", off_m=0.01)
    assert service.post(f"/v1/sessions/{session}/scans", scan)["places"]
    assert report(service, session, True, object_moved=0.1)["places"] == []


def test_an_outcome_that_moved_nothing_is_the_outcome_of_before(service: Service, data_id: str) -> None:
    """An idempotency key names one call, whether it states the default of the field or not."""
    session = service.open(data_id)
    path, key = f"/v1/sessions/{session}/grasp-outcomes", {"Idempotency-Key": f"outcome {session}"}
    first = service.http.post(path, json={"grasp": "G1", "success": True}, headers=key)
    again = service.http.post(path, json={"grasp": "G1", "success": True, "object_moved": 0.0}, headers=key)
    assert (first.status_code, again.content) == (200, first.content)
    other = service.http.post(path, json={"grasp": "G1", "success": True, "object_moved": 0.1}, headers=key)
    assert other.json()["type"] == "urn:voa:problem:idempotency-key-reused"


@pytest.mark.parametrize("moved", [-0.1, 1.1, "0.5", None])
def test_a_move_that_is_no_probability_is_refused(service: Service, data_id: str, moved: Any) -> None:
    path = f"/v1/sessions/{service.open(data_id)}/grasp-outcomes"
    answer = service.http.post(path, json={"grasp": "G1", "success": True, "object_moved": moved})
    assert answer.status_code == 422
    assert "object_moved" in answer.json()["detail"]
