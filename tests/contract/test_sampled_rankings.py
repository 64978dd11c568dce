"""Rankings over samples of the poses: values near the exact ones, with standard errors; too large ones are refused."""

from collections.abc import Iterator

import numpy as np
import pytest

from tests.support.serving import Json, Service, data_scenario, json_of, serving
from voa_service.rpc.entry import Rpc
from voa_service.settings import Limits

POSES, PLACES = 300, 5
LIMITS = Limits(predicted_scans=POSES * PLACES)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("sampled"), limits=LIMITS) as running:
        yield running


def many_poses() -> Json:
    """Many poses whose scans differ the more, the further down the list the place is."""
    along = np.linspace(0.0, 6.0, POSES)
    names = [f"P{number}" for number in range(POSES)]
    turns = np.arange(1, 5) * along[:, None]
    scans = {f"Q{place}": 0.5 + 0.05 * place * np.sin(turns + place) for place in range(1, PLACES + 1)}
    return data_scenario(
        name="many",
        update={"rule": "gaussian", "sigma_m": 0.1, "no_return_m": 1.0},
        poses=[{"name": name} for name in names],
        scores={"probabilities": [(0.5 + 0.5 * np.sin((1 + x) * along + x)).tolist() for x in range(2)]},
        sensors=[{"name": name, "x": 0.1 * place, "y": 0.0, "yaw_rad": 0.0} for place, name in enumerate(scans)],
        predictions={place: dict(zip(names, ranges.tolist(), strict=True)) for place, ranges in scans.items()},
    )


@pytest.fixture(scope="module")
def scenario(service: Service) -> str:
    return service.create(many_poses())


def ranking(service: Service, scenario: str, **fields: object) -> Json:
    answer: Json = service.post("/v1/rankings", {"scenario": scenario, "belief": None, **fields})
    return answer


@pytest.mark.parametrize("definition", ["posterior", "executed"])
def test_the_values_over_samples_are_those_over_all_poses(service: Service, scenario: str, definition: str) -> None:
    exact = ranking(service, scenario, definition=definition)
    sampled = ranking(service, scenario, definition=definition, method="sampled")
    assert (exact["method"], sampled["method"]) == ("exact", "sampled")
    assert (sampled["scans"], sampled["samples"], sampled["lookahead"]) == ("exact", None, 1)
    values = {row["sensor"]: row["voa"] for row in exact["ranking"]}
    net_values = [row["net_value"] for row in sampled["ranking"]]
    assert net_values == sorted(net_values, reverse=True)
    for row in sampled["ranking"]:
        assert row["standard_error"] is not None
        assert abs(row["voa"] - values[row["sensor"]]) <= 4.0 * row["standard_error"] + 1e-9
    first = sampled["ranking"][0]
    assert first["sensor"] == exact["ranking"][0]["sensor"]
    assert first["voa"] == pytest.approx(exact["ranking"][0]["voa"], abs=1e-9), "the last sample has all poses"
    assert first["ties_with_first"]
    assert sampled["expected_score_before"] == exact["expected_score_before"]
    assert sampled["recommendation"]["sensor"] == exact["recommendation"]["sensor"]


def test_equal_requests_have_equal_answers_on_any_service(
    service: Service, scenario: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    body = {"scenario": scenario, "belief": None, "method": "sampled"}
    answer = service.http.post("/v1/rankings", json=body).content
    assert Rpc(service.inside).answer("ranking.compute", json_of(body)).body == answer
    with serving(tmp_path_factory.mktemp("other"), workers=1) as other:
        assert other.create(many_poses()) == scenario
        assert other.http.post("/v1/rankings", json=body).content == answer


def test_pending_looks_are_taken_into_account(service: Service, scenario: str) -> None:
    exact, sampled = (
        ranking(service, scenario, method=method, pending=["Q5"], sensors=["Q4"]) for method in ("exact", "sampled")
    )
    assert sampled["ranking"][0]["voa"] == pytest.approx(exact["ranking"][0]["voa"], abs=1e-9)


def test_the_predictions_of_a_sampled_ranking_are_not_kept(service: Service, scenario: str) -> None:
    ranking(service, scenario)
    kept = service.inside.sessions.models._cache.held
    ranking(service, scenario, method="sampled", min_gain=0.01)
    assert service.inside.sessions.models._cache.held == kept


@pytest.mark.parametrize("fields", [{"scans": "simulated"}, {"outcomes": True}])
def test_samples_of_what_is_not_sampled_are_refused(service: Service, scenario: str, fields: Json) -> None:
    request = {"scenario": scenario, "belief": None, "method": "sampled", **fields}
    answer = service.http.post("/v1/rankings", json=request)
    assert answer.status_code == 422
    assert "method" in answer.json()["detail"]


@pytest.mark.parametrize("fields", [{}, {"method": "sampled"}, {"method": "exact"}])
def test_a_ranking_that_predicts_too_many_scans_is_refused(service: Service, scenario: str, fields: Json) -> None:
    places = [{"x": 0.1, "y": 0.1 * number, "yaw_rad": 0.0} for number in range(PLACES + 1)]
    request = {"scenario": scenario, "belief": None, "sensors": places, **fields}
    answer = service.http.post("/v1/rankings", json=request)
    assert (answer.status_code, answer.json()["type"]) == (413, "urn:voa:problem:too-large")
    assert f"at most {PLACES} places at a time" in answer.json()["detail"]
    assert "voa rank --local" in answer.json()["detail"]


def test_the_document_states_the_limit(service: Service) -> None:
    schemas = service.http.get("/openapi.json").json()["components"]["schemas"]
    for name in ("VoaRequest", "RankingRequest"):
        assert schemas[name]["x-predicted-scans"] == {"type": "integer", "maximum": POSES * PLACES}
