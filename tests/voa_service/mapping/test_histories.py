"""Versions of a session as messages, with and without their beliefs."""

from tests.support.serving import Service, data_scenario, scan_of


def test_a_version_has_its_belief_only_where_it_is_requested(service: Service) -> None:
    session = service.open(service.create(data_scenario()))
    path = f"/v1/sessions/{session}"
    after = service.post(f"{path}/scans", scan_of([0.5, 0.5, None, 1.0]))
    prior, scan = service.get(f"{path}/history?beliefs=true")["items"]
    for name in ("belief", "best_grasp", "expected_score", "entropy_nats"):
        assert scan[name] == after[name]
    assert prior["belief"] != scan["belief"]
    plain = service.get(f"{path}/history")["items"]
    assert [set(entry) for entry in plain] == [{"version", "kind", "at", "request", "update", "absent"}] * 2


def test_a_version_at_which_no_grasp_can_succeed_names_none(service: Service) -> None:
    scenario = service.create(data_scenario(scores={"probabilities": [[0.0] * 3] * 2}))
    (prior,) = service.get(f"/v1/sessions/{service.open(scenario)}/history?beliefs=true")["items"]
    assert "best_grasp" not in prior
    assert prior["expected_score"] == 0.0
