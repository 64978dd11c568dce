"""Rankings over simulated scans: those of the mathematics to the last bit, with the session's looks inside."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest

from tests.support.places import seen_from, spread_body, spread_scenario, turned_body
from tests.support.replaying import replayed
from tests.support.serving import LIDAR, Json, Service, box_obj, client, data_scenario
from voa_core.assistance import Valuation
from voa_core.checks import Floats
from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.looks import Driving, Looks
from voa_core.places import Place, Viewpoint, index_of_place
from voa_core.ranking import rank_looks
from voa_core.recommendation import Recommendation, recommend
from voa_core.scan_model import ScanModel
from voa_core.scenario import Scenario
from voa_core.simulated_weights import simulated_looks
from voa_core.simulation import Sampling
from voa_msgs.sessions import ScanRequest
from voa_service.bootstrap import services
from voa_service.mapping.observations import scan_evidence
from voa_service.settings import Settings

SAMPLES = 52
"""Scans of each of five poses, which make at least 256 of a place."""
STD: Json = {"xy_m": 0.01, "yaw_rad": 0.02}
WIDE: Json = {"xy_m": 0.03, "yaw_rad": 0.02}
NEAR_EAST: Json = {"x": 0.31, "y": 0.0, "yaw_rad": math.pi}
CANDIDATES: list[Any] = [NEAR_EAST, "E", "N", {"name": "far", "x": 0.8, "y": 0.1, "yaw_rad": 3.0, "cost": 0.02}]


@pytest.fixture(scope="module")
def turned(service: Service) -> str:
    return service.create(turned_body(service.upload(box_obj())))


@contextmanager
def beside(service: Service) -> Iterator[Service]:
    """Run a second service on the same database, with empty caches."""
    settings = Settings(database_url=f"sqlite:///{service.database}", workers=2, cache_mebibytes=64)
    with services(settings) as inside, client(inside) as http:
        yield Service(http, inside, service.database)


def scenario_of(service: Service, id_: str) -> Scenario:
    model = service.inside.sessions.models.get(id_)
    assert model is not None
    return model.scenario


def sensor(scenario: Scenario, index: int, item: Any) -> SensorConfiguration:
    if isinstance(item, str):
        return scenario.sensor(item)
    name = item.get("name", str(index))
    return SensorConfiguration(name, item["x"], item["y"], item["yaw_rad"], item.get("height_m"), item.get("cost", 0.0))


class Mathematics:
    """The ranking of a session by the mathematics alone, from its history."""

    def __init__(self, service: Service, session: str | None, scenario: str) -> None:
        self.scenario = scenario_of(service, scenario)
        self.scans: dict[int, ScanRequest] = {}
        self.estimate = Estimate.of(self.scenario.prior)
        if session is not None:
            entries = service.inside.sessions.store.history(session, -1, 999)
            *_, self.estimate = replayed(self.scenario, entries)
            self.scans = {
                entry.state.version: ScanRequest.model_validate_json(entry.request)
                for entry in entries
                if entry.kind == "scan"
            }

    def viewpoints(self, model: ScanModel, of: SensorConfiguration) -> list[Viewpoint]:
        """Viewpoints of a look: a robot that is unsure of its pose states that pose, wherever it was sent."""
        listed = self.scenario.lists(of)
        kinds = [True, False] if listed and model.std is not None else [listed]
        return [Viewpoint.of(of, self.scenario.lidar, listed=kind) for kind in kinds]

    def place_of(self, model: ScanModel, of: SensorConfiguration) -> Place | None:
        for viewpoint in self.viewpoints(model, of):
            index = index_of_place(self.estimate.places, viewpoint)
            if index is not None:
                return self.estimate.places[index]
        return None

    def share(self, model: ScanModel, one: SensorConfiguration, other: SensorConfiguration) -> bool:
        pairs = product(self.viewpoints(model, one), self.viewpoints(model, other))
        return any(viewpoint.shares_place(first) for viewpoint, first in pairs)

    def log_sums(self, model: ScanModel, of: SensorConfiguration) -> Floats | None:
        place = self.place_of(model, of)
        if place is None:
            return None
        displacements = model.displacements(of, place.copies)
        assert displacements is not None
        copies = displacements.shape[1]
        sums: Floats = np.zeros((len(self.scenario.poses), 1))
        for version in place.looks:
            sums = sums + scan_evidence(self.scenario, self.scans[version], copies).log_copies
        return sums

    def advice(
        self,
        sensors: Sequence[Any],
        *,
        samples: int = SAMPLES,
        std: Json | None = None,
        pending: Sequence[Any] = (),
        driving: Driving | None = None,
        definition: Any = "executed",
        lookahead: int = 2,
        min_gain: float = 0.005,
        sensor_belief: list[float] | None = None,
        belief: list[float] | None = None,
    ) -> Recommendation:
        scenario = self.scenario
        model = ScanModel.of(scenario, None if std is None else SensorUncertainty(std["xy_m"], std["yaw_rad"]))
        candidates = [sensor(scenario, index, item) for index, item in enumerate(sensors)]
        sampling = Sampling(scenario.seed, samples)

        def looks(own: Sampling) -> Looks:
            of = simulated_looks(model, own, lists=scenario.lists, log_sums_of=lambda each: self.log_sums(model, each))
            waiting = tuple(sensor(scenario, index, item) for index, item in enumerate(pending))
            return Looks(of, waiting, partial(self.share, model))

        valuation = Valuation(
            self.estimate.belief if belief is None else Belief.of(belief),
            scenario.table,
            scenario.policy,
            definition,
            None if sensor_belief is None else Belief.of(sensor_belief),
        )
        ranking = rank_looks(candidates, looks(sampling), valuation, driving=driving)
        return recommend(
            ranking,
            looks(sampling),
            valuation,
            fresh=looks(sampling.fresh()),
            min_gain=min_gain,
            lookahead=lookahead,
            driving=driving,
        )


def assert_equal(answer: Json, advice: Recommendation) -> None:
    """The answer has the numbers of the mathematics, to the last bit."""
    ranking = advice.ranking
    assert [
        (row["sensor"], row["voa"], row["standard_error"], row["score_standard_error"], row["cost"], row["net_value"],
         row["expected_score_after"], row["ties_with_first"])
        for row in answer["ranking"]
    ] == [
        (look.sensor.name, look.assistance.voa, look.assistance.standard_error, look.assistance.score_standard_error,
         look.cost, look.net_value, look.assistance.expected_score_after, ranking.ties_with_first(look))
        for look in ranking.looks
    ]  # fmt: skip
    assert answer["value_of_perfect_information"] == ranking.value_of_perfect_information
    assert answer["lookahead"] == advice.lookahead
    assert answer["expected_score_before"] == ranking.before.expected_score
    recommended = answer["recommendation"]
    if advice.look is None:
        assert recommended["action"] == "grasp"
    else:
        then = None if advice.then is None else advice.then.sensor.name
        assert (recommended["sensor"], recommended["net_value"], recommended.get("then")) == (
            advice.look.sensor.name,
            advice.net_value,
            then,
        )


def look(service: Service, session: str, *places: str | Json, pose: str = "B", off_m: float = 0.004) -> None:
    for place in places:
        service.post(f"/v1/sessions/{session}/scans", seen_from(service, place, pose, off_m=off_m))


def rank(service: Service, session: str, **request: Any) -> Json:
    answer: Json = service.post(f"/v1/sessions/{session}/voa", request)
    return answer


def rows(ranking: Json) -> dict[str, Json]:
    return {row["sensor"]: row for row in ranking["ranking"]}


# ------------------------------------------------------------------------------------------ as the mathematics say


@pytest.mark.parametrize(
    "request_",
    [
        {},
        {"definition": "posterior"},
        {"samples": 5},
        {"sensor_std": STD},
        {"sensor_std": WIDE},
        {"lookahead": 1},
        {"min_gain": 0.9},
        {"sensor_belief": [0.1, 0.2, 0.4, 0.2, 0.1]},
        {"pending": ["N"]},
        {"pending": [NEAR_EAST, "E", "E"]},
        {"from": {"x": 0.5, "y": -0.5}, "cost_per_m": 0.05},
        {"from": "far", "cost_per_m": 0.05, "pending": ["N"], "sensor_std": STD},
    ],
    ids=str,
)
@pytest.mark.parametrize("looks", [[], ["E", "N", "E", NEAR_EAST | {"std": STD}]], ids=["none", "several"])
def test_a_ranking_is_that_of_the_mathematics(service: Service, turned: str, looks: list[Any], request_: Json) -> None:
    session = service.open(turned)
    look(service, session, *looks)
    options = dict(request_)
    start, cost = options.pop("from", None), options.pop("cost_per_m", 0.0)
    at = {"x": 0.8, "y": 0.1} if start == "far" else start
    std = options.pop("sensor_std", STD if any(isinstance(place, dict) for place in looks) else None)
    advice = Mathematics(service, session, turned).advice(
        CANDIDATES, std=std, driving=None if at is None else Driving(at["x"], at["y"], cost), **options
    )
    answer = rank(service, session, sensors=CANDIDATES, **request_)
    assert (answer["scans"], answer["samples"]) == ("simulated", request_.get("samples", SAMPLES))
    assert answer["definition"] == request_.get("definition", "executed")
    assert_equal(answer, advice)


def test_a_belief_in_the_request_knows_no_places(service: Service, turned: str) -> None:
    session = service.open(turned)
    look(service, session, "E", "E")
    belief = service.get(f"/v1/sessions/{session}")["belief"]
    once = service.post("/v1/rankings", {"scenario": turned, "belief": belief})
    assert_equal(once, Mathematics(service, None, turned).advice(["E", "N"], belief=belief))
    assert {row["looks_taken"] for row in once["ranking"]} == {0}
    assert once["version"] is None


def test_only_the_looks_of_its_own_place_are_inside_the_value_of_a_look(service: Service, turned: str) -> None:
    session = service.open(turned)
    look(service, session, "E", off_m=0.0)
    own = rows(rank(service, session))
    belief = service.get(f"/v1/sessions/{session}")["belief"]
    fresh = rows(service.post("/v1/rankings", {"scenario": turned, "belief": belief}))
    assert {name: row["looks_taken"] for name, row in own.items()} == {"E": 1, "N": 0}
    assert list(own) == list(fresh) == ["E", "N"]
    assert own["N"]["voa"] == pytest.approx(fresh["N"]["voa"], abs=1e-12)
    assert abs(own["E"]["voa"] - fresh["E"]["voa"]) > 1e-3


def test_looks_after_the_belief_was_replaced_are_those_of_the_new_belief(service: Service, turned: str) -> None:
    session = service.open(turned)
    look(service, session, "E", "E")
    rank(service, session)
    service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).raise_for_status()
    assert {row["looks_taken"] for row in rank(service, session)["ranking"]} == {0}
    look(service, session, "E", pose="A")
    assert_equal(rank(service, session), Mathematics(service, session, turned).advice(["E", "N"]))


# ----------------------------------------------------------------------------------------------------- defaults


def test_defaults_depend_on_scenario_request_and_session(service: Service, turned: str) -> None:
    exact_id = service.create(turned_body(service.upload(box_obj()), name="sharp", spread=None))
    session = service.open(exact_id)

    def kind(**request: Any) -> tuple[str, str, int | None]:
        answer = rank(service, session, **request)
        return answer["scans"], answer["definition"], answer["samples"]

    assert kind() == ("exact", "posterior", None)
    assert kind(sensor_std=STD) == ("simulated", "executed", SAMPLES)
    assert kind(scans="simulated", samples=3, definition="posterior") == ("simulated", "posterior", 3)
    look(service, session, NEAR_EAST | {"std": STD})
    assert kind() == ("simulated", "executed", SAMPLES)
    assert rank(service, session) == rank(service, session, sensor_std=STD)
    assert kind(sensor_std={"xy_m": 0.0, "yaw_rad": 0.0}) == ("exact", "posterior", None)
    look(service, session, "E")
    assert kind() == ("simulated", "executed", SAMPLES), "a listed sensor states no std"
    service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).raise_for_status()
    assert kind() == ("simulated", "executed", SAMPLES), "another belief is not another robot"
    look(service, session, NEAR_EAST)
    assert kind() == ("exact", "posterior", None)
    own = service.open(turned)
    assert rank(service, own)["scans"] == "simulated"
    exact = rank(service, own, scans="exact")
    assert (exact["scans"], exact["samples"], exact["definition"]) == ("exact", None, "posterior")
    assert {row["standard_error"] for row in exact["ranking"]} == {None}
    assert all(row["standard_error"] > 0.0 for row in rank(service, own)["ranking"])


@pytest.mark.parametrize(("scores", "is_null"), [({"attempts": 10, "successes": [[9, 1], [2, 8]]}, False),
                                                 ({"probabilities": [[0.9, 0.1], [0.2, 0.8]]}, True)])  # fmt: skip
def test_the_error_of_counted_scores_is_stated(service: Service, scores: Json, is_null: bool) -> None:
    id_ = spread_scenario(service, name="scores", scores=scores)
    for scans in ("exact", "simulated"):
        answer = service.post("/v1/rankings", {"scenario": id_, "belief": None, "scans": scans})
        assert {row["score_standard_error"] is None for row in answer["ranking"]} == {is_null}


def test_range_noise_alone_is_simulated_without_a_mesh(service: Service, data_id: str) -> None:
    answer = service.post("/v1/rankings", {"scenario": data_id, "belief": None, "scans": "simulated"})
    assert (answer["samples"], answer["definition"]) == (math.ceil(256 / 3), "executed")


def test_more_scans_than_memory_allows_are_refused(service: Service) -> None:
    names = [f"P{number}" for number in range(600)]
    row = {name: [0.5, 0.5, None, 1.0] for name in names}
    body = data_scenario(
        name="many",
        poses=[{"name": name} for name in names],
        scores={"probabilities": [[0.5] * 600, [0.4] * 600]},
        predictions={"Q1": row, "Q2": row},
    )
    request = {"scenario": service.create(body), "belief": None, "scans": "simulated", "samples": 4096}
    answer = service.http.post("/v1/rankings", json=request)
    assert (answer.status_code, answer.json()["type"]) == (413, "urn:voa:problem:too-large")
    assert "fewer `samples`" in answer.json()["detail"]


# ------------------------------------------------------------------------------------------- one answer, everywhere


@pytest.mark.parametrize("request_", [{}, {"sensor_std": WIDE, "pending": ["N"], "outcomes": True}])
def test_a_request_has_one_answer_in_every_process(service: Service, turned: str, request_: Json) -> None:
    session = service.open(turned)
    look(service, session, "E", "N", "E")
    path = f"/v1/sessions/{session}/voa"
    first = service.http.post(path, json=request_)
    assert service.http.post(path, json=request_).content == first.content
    for _ in range(2):
        with beside(service) as other:
            assert other.http.post(path, json=request_).content == first.content


def test_the_outcomes_of_simulated_scans_are_one_for_each_pose(service: Service) -> None:
    id_ = spread_scenario(service)
    session = service.open(id_, prior=[0.25, 0.75])
    for row in rank(service, session, outcomes=True, definition="posterior")["ranking"]:
        assert [(each["pose"], each["probability"]) for each in row["outcomes"]] == [("A", 0.25), ("B", 0.75)]
        mean = sum(each["probability"] * each["expected_score"] for each in row["outcomes"])
        assert mean == pytest.approx(row["expected_score_after"], abs=1e-9)
    impossible = service.open(id_, prior=[0.0, 1.0])
    for row in rank(service, impossible, outcomes=True)["ranking"]:
        assert [each["pose"] for each in row["outcomes"]] == ["B"]


def test_perfect_information_is_worth_the_most(service: Service) -> None:
    answer = rank(service, service.open(spread_scenario(service), prior=[0.4, 0.6]))
    # G2 succeeds with 0.4 x 0.2 + 0.6 x 0.8 = 0.56; G1 at A and G2 at B with 0.4 x 0.9 + 0.6 x 0.8 = 0.84.
    assert answer["value_of_perfect_information"] == pytest.approx(0.28)
    assert all(row["voa"] <= 0.28 + 1e-9 for row in answer["ranking"])


# --------------------------------------------------------------------------------------------- two looks, and drives

BITS = [(0, 0), (0, 1), (1, 0), (1, 1)]
FIRST = {f"{a}{b}": [0.5 + a] for a, b in BITS}
SECOND = {f"{a}{b}": [0.5 + b] for a, b in BITS}


def exclusive_or(**changes: Any) -> Json:
    """Two features of four poses, each shown by a place of its own; the grasp depends on their exclusive or."""
    body: Json = {
        "name": "exclusive or",
        "poses": [{"name": f"{a}{b}"} for a, b in BITS],
        "grasps": [{"name": "equal"}, {"name": "different"}],
        "scores": {"probabilities": [[0.9, 0.0, 0.0, 0.9], [0.0, 0.9, 0.9, 0.0]]},
        "sensors": [
            {"name": "first", "x": 0.0, "y": 0.0, "yaw_rad": 0.0, "cost": 0.03},
            {"name": "second", "x": 1.0, "y": 0.0, "yaw_rad": 0.0, "cost": 0.02},
        ],
        "lidar": LIDAR | {"beams": 1},
        "update": {"rule": "beam"},
        "predictions": {"first": FIRST, "second": SECOND},
    }
    return body | changes


def once(service: Service, body: Json, **request: Any) -> Json:
    answer: Json = service.post("/v1/rankings", {"scenario": service.create(body), "belief": None} | request)
    return answer


@pytest.mark.parametrize("scans", ["exact", "simulated"])
def test_two_looks_that_are_worth_nothing_alone_are_recommended_together(service: Service, scans: str) -> None:
    answer = once(service, exclusive_or(), scans=scans, definition="executed")
    assert answer["lookahead"] == 2
    assert all(abs(row["voa"]) < 0.05 for row in answer["ranking"])
    recommended = answer["recommendation"]
    assert (recommended["action"], recommended["sensor"], recommended["then"]) == ("look", "second", "first")
    assert recommended["net_value"] == pytest.approx(0.45 - 0.05, abs=0.02)
    alone = once(service, exclusive_or(), scans=scans, lookahead=1)
    assert (alone["lookahead"], alone["recommendation"]["action"]) == (1, "grasp")


@pytest.mark.parametrize("scans", ["exact", "simulated"])
def test_after_the_first_look_of_a_pair_the_second_is_worth_it_alone(service: Service, scans: str) -> None:
    id_ = service.create(exclusive_or())
    session = service.open(id_)
    service.post(f"/v1/sessions/{session}/looks", {"sensor": "second"})
    waiting = rank(service, session, scans=scans)["recommendation"]
    assert (waiting["sensor"], waiting.get("then")) == ("first", None)
    service.post(f"/v1/sessions/{session}/scans", {"sensor": "second", "scan": {"ranges": [0.5]}})
    after = rank(service, session, scans=scans)["recommendation"]
    assert (after["sensor"], after.get("then")) == ("first", None)
    assert after["net_value"] == pytest.approx(0.42, abs=0.02)
    service.post(f"/v1/sessions/{session}/scans", {"sensor": "first", "scan": {"ranges": [1.5]}})
    done = rank(service, session, scans=scans)["recommendation"]
    assert (done["action"], done["grasp"]) == ("grasp", "different")


def test_a_drive_is_paid_to_the_first_place_and_from_there_to_the_second(service: Service) -> None:
    drive: Json = {"from": {"x": -1.0, "y": 0.0}, "cost_per_m": 0.1}
    answer = once(service, exclusive_or(), **drive)
    assert {name: row["cost"] for name, row in rows(answer).items()} == pytest.approx({"first": 0.13, "second": 0.22})
    assert (answer["recommendation"]["sensor"], answer["recommendation"]["then"]) == ("first", "second")
    assert answer["recommendation"]["net_value"] == pytest.approx(0.45 - 0.05 - 0.1 - 0.1, abs=0.02)
    assert once(service, exclusive_or(), **(drive | {"cost_per_m": 0.3}))["recommendation"]["action"] == "grasp"
    here = once(service, exclusive_or(), **(drive | {"from": "first"}))
    assert rows(here)["first"]["cost"] == 0.03


@pytest.mark.parametrize(
    ("request_", "kind", "says"),
    [
        ({"cost_per_m": 0.1}, "invalid-request", "from"),
        ({"from": "third", "cost_per_m": 0.1}, "unknown-name", "'first', 'second'"),
        ({"pending": ["third"]}, "unknown-name", "'first', 'second'"),
        ({"sensors": ["first"], "pending": ["second", "third"]}, "unknown-name", "'third'"),
        ({"pending": [{"x": 0.0, "y": 0.0, "yaw_rad": 0.0}]}, "no-mesh", ""),
        ({"sensor_std": {"xy_m": -1.0, "yaw_rad": 0.0}}, "invalid-request", "sensor_std"),
        ({"samples": 0}, "invalid-request", "samples"),
        ({"lookahead": 3}, "invalid-request", "lookahead"),
        ({"scans": "perfect"}, "invalid-request", "'exact' or 'simulated'"),
    ],
)
@pytest.mark.parametrize("in_session", [True, False])
def test_a_ranking_that_does_not_fit_is_refused(
    service: Service, request_: Json, kind: str, says: str, in_session: bool
) -> None:
    id_ = service.create(exclusive_or())
    path = f"/v1/sessions/{service.open(id_)}/voa" if in_session else "/v1/rankings"
    answer = service.http.post(path, json=request_ if in_session else request_ | {"scenario": id_, "belief": None})
    assert (answer.status_code, answer.json()["type"]) == (422, f"urn:voa:problem:{kind}")
    assert says in answer.json()["detail"]


@pytest.mark.parametrize(("places", "lookahead"), [(1, 1), (2, 2), (64, 2), (65, 1)])
def test_pairs_are_planned_among_2_to_64_places(service: Service, places: int, lookahead: int) -> None:
    id_ = service.create(spread_body(service.upload(box_obj()), name="exact", spread=None))
    turn = 2.0 * math.pi / places
    sensors = [
        {"x": 0.3 * math.cos(i * turn), "y": 0.3 * math.sin(i * turn), "yaw_rad": i * turn - math.pi, "cost": 0.9}
        for i in range(places)
    ]
    answer = service.post("/v1/rankings", {"scenario": id_, "belief": None, "sensors": sensors})
    assert answer["lookahead"] == lookahead
