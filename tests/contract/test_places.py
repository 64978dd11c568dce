"""Sessions under a spread: looks of one place count together, whoever writes them and whichever process applies them.

Each story is compared with a replay of its history by the mathematics alone, to the last bit.
"""

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from threading import Barrier
from typing import Any

import numpy as np
import pytest

from tests.support.places import seen_from, spread_body, spread_scenario
from tests.support.replaying import replayed
from tests.support.serving import PREDICTIONS, Json, Service, as_scan, box_obj, client, data_scenario, scan_of
from voa_core.checks import Floats
from voa_core.scenario import Scenario
from voa_core.updating import update
from voa_msgs.sessions import ScanRequest
from voa_service.bootstrap import services
from voa_service.mapping.looks import record_of
from voa_service.mapping.observations import scan_evidence, scan_observation
from voa_service.settings import Settings

NEAR: Json = {"x": 0.3, "y": 0.0, "yaw_rad": math.pi}
UNSURE: Json = NEAR | {"std": {"xy_m": 0.03, "yaw_rad": 0.0}}
WRITERS = 6


@pytest.fixture(scope="module")
def spread(service: Service) -> str:
    return spread_scenario(service)


@contextmanager
def beside(service: Service) -> Iterator[Service]:
    """Run a second service on the same database, with empty caches, as after a restart."""
    settings = Settings(database_url=f"sqlite:///{service.database}", workers=2, cache_mebibytes=64)
    with services(settings) as inside, client(inside) as http:
        yield Service(http, inside, service.database)


def scenario_of(service: Service, id_: str) -> Scenario:
    model = service.inside.sessions.models.get(id_)
    assert model is not None
    return model.scenario


def look(service: Service, session: str, request: Json) -> Json:
    answer: Json = service.post(f"/v1/sessions/{session}/scans", request)
    return answer


def assert_replays(service: Service, session: str) -> None:
    """Every version of the history is, to the last bit, what the mathematics make of the requests."""
    entries = service.inside.sessions.store.history(session, -1, 999)
    scenario = scenario_of(service, entries[0].state.scenario)
    for entry, estimate in zip(entries, replayed(scenario, entries), strict=True):
        assert entry.state.belief.p.tobytes() == estimate.belief.p.tobytes(), entry.state.version
        assert entry.state.belief.log_p.tobytes() == estimate.belief.log_p.tobytes(), entry.state.version
        record = record_of(entry.state.looks)
        assert record.log_odds_absent == estimate.log_odds_absent
        assert [(place.viewpoint, place.looks, place.copies) for place in record.places] == [
            (place.viewpoint, len(place.looks), place.copies) for place in estimate.places
        ]
        assert record.attempts == estimate.attempts


def by_place(scenario: Scenario, places: list[list[Json]], copies: int = 64) -> Floats:
    """Posterior of a uniform prior: for each place the mean over the copies of the product of its looks' weights."""
    belief: Floats = np.full(len(scenario.poses), 1.0 / len(scenario.poses))
    for requests in places:
        scans = [ScanRequest.model_validate(request) for request in requests]
        logs = np.sum([scan_evidence(scenario, scan, copies).log_copies for scan in scans], axis=0)
        belief = belief * np.exp(logs - np.max(logs)).mean(axis=1)
    shares: Floats = belief / belief.sum()
    return shares


# ------------------------------------------------------------------------------------------------ several looks


def test_looks_of_one_place_are_weighed_together(service: Service, spread: str) -> None:
    session = service.open(spread)
    requests = [seen_from(service, "E", "A", off_m=off) for off in (0.02, 0.025, 0.015)]
    scenario = scenario_of(service, spread)
    for number in range(3):
        answer = look(service, session, requests[number])
        together = by_place(scenario, [requests[: number + 1]])
        assert answer["belief"] == pytest.approx(together.tolist(), abs=1e-12)
        assert answer["places"] == [{"sensor": "E", "sensor_pose": None, "looks": number + 1}]
    apart = by_place(scenario, [[request] for request in requests])
    assert np.abs(apart - np.array(answer["belief"])).max() > 1e-3, "one place counts less than three"
    assert_replays(service, session)


def test_each_place_has_displacements_of_its_own(service: Service, spread: str) -> None:
    session = service.open(spread)
    east, north = (seen_from(service, sensor, "B", off_m=0.03) for sensor in ("E", "N"))
    for request in (east, north, east):
        answer = look(service, session, request)
    expected = by_place(scenario_of(service, spread), [[east, east], [north]])
    assert answer["belief"] == pytest.approx(expected.tolist(), abs=1e-12)
    assert [(place["sensor"], place["looks"]) for place in answer["places"]] == [("E", 2), ("N", 1)]


def test_log_evidence_of_a_further_look_is_relative_to_the_earlier_ones(service: Service, spread: str) -> None:
    session, scenario = service.open(spread), scenario_of(service, spread)
    request = seen_from(service, "E", "A", off_m=0.02)
    copies = scan_evidence(scenario, ScanRequest.model_validate(request), 64).log_copies
    sums = [np.log(np.exp(number * copies).mean(axis=1)) for number in (0, 1, 2)]
    before = np.full(2, 0.5)
    for number in (1, 2):
        answer = look(service, session, request)
        expected = math.log(float((before * np.exp(sums[number] - sums[number - 1])).sum()))
        assert answer["update"]["log_evidence"] == pytest.approx(expected, abs=1e-9)
        before = np.array(answer["belief"])


def test_a_scan_once_is_the_first_look_of_a_place(service: Service, spread: str) -> None:
    request = seen_from(service, "E", "A", off_m=0.02)
    session = service.open(spread)
    first = look(service, session, request)
    once = service.post("/v1/updates", request | {"scenario": spread, "belief": None})
    assert (once["belief"], once["update"]) == (first["belief"], first["update"])
    again = service.post("/v1/updates", request | {"scenario": spread, "belief": first["belief"]})
    assert again["belief"] != look(service, session, request)["belief"], "a stated belief has no places"


# --------------------------------------------------------------------------------------------------- who shares


@pytest.mark.parametrize(
    ("second", "shared"),
    [
        (NEAR, True),
        (NEAR | {"x": 0.319}, True),
        (NEAR | {"x": 0.321}, False),
        (NEAR | {"yaw_rad": -math.pi}, True),
        (NEAR | {"yaw_rad": math.pi - 0.034}, True),
        (NEAR | {"yaw_rad": math.pi - 0.036}, False),
        (NEAR | {"height_m": 0.029}, True),
        (NEAR | {"height_m": 0.031}, False),
        (NEAR | {"std": {"xy_m": 0.001, "yaw_rad": 0.0}}, True),
        ("E", False),
    ],
)
def test_looks_from_nearly_one_sensor_pose_share_a_place(
    service: Service, spread: str, second: Json | str, shared: bool
) -> None:
    session = service.open(spread)
    look(service, session, seen_from(service, NEAR, "A"))
    answer = look(service, session, seen_from(service, second, "A"))
    assert [place["looks"] for place in answer["places"]] == ([2] if shared else [1, 1])
    assert answer["places"][0] == {
        "sensor": None,
        "sensor_pose": NEAR | {"height_m": 0.02},
        "looks": 1 + shared,
    }
    assert service.get(f"/v1/sessions/{session}")["places"] == answer["places"]
    assert_replays(service, session)


def test_places_are_shown_without_a_spread_too(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    for sensor in ("Q2", "Q1", "Q2"):
        answer = look(service, session, scan_of([0.5, 0.5, None, 1.0], sensor))
    assert [(place["sensor"], place["looks"]) for place in answer["places"]] == [("Q2", 2), ("Q1", 1)]
    refused = look(service, session, scan_of([None] * 4))
    assert (refused["update"]["accepted"], refused["places"]) == (False, answer["places"])
    assert service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).json()["places"] == []


def test_more_displaced_copies_are_compared_where_one_look_of_a_place_needs_them(service: Service, spread: str) -> None:
    """A standard deviation of 3 cm takes 256 copies: the earlier look from there is compared with as many."""
    session = service.open(spread)
    sure, unsure = NEAR | {"std": {"xy_m": 0.005, "yaw_rad": 0.01}}, NEAR | {"std": {"xy_m": 0.03, "yaw_rad": 0.02}}
    requests = [seen_from(service, place, "A", off_m=0.02) for place in (sure, unsure, sure)]
    scenario = scenario_of(service, spread)
    for number, copies in ((1, 64), (2, 256), (3, 256)):
        answer = look(service, session, requests[number - 1])
        record = record_of(service.inside.sessions.state(session).looks)
        assert [place.copies for place in record.places] == [copies]
        expected = by_place(scenario, [requests[:number]], copies)
        assert answer["belief"] == pytest.approx(expected.tolist(), abs=1e-12)
    assert_replays(service, session)
    with beside(service) as other:
        look(other, session, requests[0])
    assert_replays(service, session)


def test_a_std_gives_copies_to_a_scenario_without_a_spread(service: Service, mesh_id: str) -> None:
    session, place = service.open(mesh_id), NEAR | {"std": {"xy_m": 0.005, "yaw_rad": 0.01}}
    for where in (NEAR, place, NEAR):
        look(service, session, seen_from(service, where, "A", off_m=0.02))
    (only,) = record_of(service.inside.sessions.state(session).looks).places
    assert (only.looks, only.copies) == (3, 64)
    assert_replays(service, session)


# --------------------------------------------------------------------------------------- restarts and many writers


def scan(service: Service, sensor: str | Json, pose: str = "A", off_m: float = 0.02) -> tuple[str, str, Json]:
    return "POST", "scans", seen_from(service, sensor, pose, off_m=off_m)


def outcome(grasp: str = "G1", success: bool = False, **more: float) -> tuple[str, str, Json]:
    return "POST", "grasp-outcomes", {"grasp": grasp, "success": success} | more


BELIEF = "PUT", "belief", {"belief": [0.25, 0.75]}
RESET = "PUT", "belief", {"belief": None}
STORIES: dict[str, Callable[[Service], list[tuple[str, str, Json]]]] = {
    "looks of one place": lambda own: [scan(own, "E"), scan(own, "E", off_m=0.03), scan(own, "E", "B")],
    "looks of two places": lambda own: [scan(own, "E"), scan(own, "N"), scan(own, "E", "B"), scan(own, "N")],
    "a belief between": lambda own: [scan(own, "E"), BELIEF, scan(own, "E"), RESET, scan(own, "E"), scan(own, "E")],
    "outcomes between": lambda own: [scan(own, "E"), outcome(), scan(own, "E"), outcome(), outcome("G2"), outcome()],
    "the object moved": lambda own: [
        scan(own, "E"), outcome(), outcome(object_moved=0.3), outcome(), scan(own, "E"), scan(own, "E")
    ],
    "a sensor pose of growing uncertainty": lambda own: [
        scan(own, NEAR), scan(own, UNSURE), BELIEF, scan(own, NEAR), scan(own, UNSURE), scan(own, NEAR)
    ],
}  # fmt: skip


def written(service: Service, session: str, step: tuple[str, str, Json]) -> Json:
    method, path, body = step
    answer = service.http.request(method, f"/v1/sessions/{session}/{path}", json=body)
    assert answer.is_success, answer.text
    body_: Json = answer.json()
    return body_


VARYING = ("id", "created_at", "updated_at")


@pytest.mark.parametrize("story", STORIES)
def test_a_session_goes_on_in_another_process_as_if_nothing_had_happened(
    service: Service, spread: str, story: str
) -> None:
    steps = STORIES[story](service)
    at_home, abroad = service.open(spread, prior=[0.4, 0.6]), service.open(spread, prior=[0.4, 0.6])
    for step in steps:
        expected = written(service, at_home, step)
        with beside(service) as other:
            answer = written(other, abroad, step)
        assert {k: v for k, v in answer.items() if k not in VARYING} == {
            k: v for k, v in expected.items() if k not in VARYING
        }
    for session in (at_home, abroad):
        assert_replays(service, session)


def test_a_scan_that_the_nearest_poses_share_restarts_the_belief_in_every_process(service: Service) -> None:
    margin = {"rule": "margin", "margin_m": 0.02, "on_no_match": "nearest"}
    spread = spread_scenario(service, name="nearest", update=margin)
    at_home, abroad = service.open(spread), service.open(spread)
    near, far = scan(service, "E", off_m=0.0), scan(service, "E", off_m=-0.08)
    reasons = []
    for step in (near, near, far, near, near):
        expected = written(service, at_home, step)
        reasons.append(expected["update"]["reason"])
        with beside(service) as other:
            assert written(other, abroad, step)["belief"] == expected["belief"]
    assert reasons == [None, None, "nearest", None, None]
    assert expected["places"] == [{"sensor": "E", "sensor_pose": None, "looks": 2}]
    assert_replays(service, abroad)


def test_writers_on_one_place_are_all_counted_whichever_process_they_use(service: Service, spread: str) -> None:
    session = service.open(spread)
    requests = [seen_from(service, "E", "A", off_m=0.01 + 0.004 * number, stamp=number) for number in range(WRITERS)]
    barrier = Barrier(WRITERS)

    def write(own: Service, request: Json) -> int:
        barrier.wait(60)
        return int(look(own, session, request)["version"])

    with ExitStack() as stack, ThreadPoolExecutor(WRITERS) as pool:
        both = [service, stack.enter_context(beside(service))]
        calls = [pool.submit(write, both[number % 2], request) for number, request in enumerate(requests)]
        versions = [call.result(60) for call in calls]
    assert sorted(versions) == list(range(1, WRITERS + 1))
    state = service.get(f"/v1/sessions/{session}")
    assert state["places"] == [{"sensor": "E", "sensor_pose": None, "looks": WRITERS}]
    expected = by_place(scenario_of(service, spread), [requests])
    assert state["belief"] == pytest.approx(expected.tolist(), abs=1e-12)
    assert_replays(service, session)


# ------------------------------------------------------------------------------------------- without a spread


def test_without_spread_and_std_each_look_multiplies_the_belief_as_ever(service: Service, data_id: str) -> None:
    session, scenario = service.open(data_id), scenario_of(service, data_id)
    belief = scenario.prior
    for pose, sensor in (("P2", "Q1"), ("P1", "Q1"), ("P2", "Q2"), ("P2", "Q1")):
        body = {"sensor": sensor, "scan": as_scan(PREDICTIONS[sensor][pose])}
        evidence = scan_observation(scenario, ScanRequest.model_validate(body)).evidence
        belief = update(belief, evidence, scenario.policy).belief
        assert look(service, session, body)["belief"] == belief.p.tolist()
    assert service.inside.sessions.state(session).belief.log_p.tobytes() == belief.log_p.tobytes()


# ------------------------------------------------------------------------------------------------- bad spreads


@pytest.mark.parametrize(
    ("spread", "says"),
    [
        ({"xy_m": 0.0, "yaw_rad": 0.0}, "spread"),
        ({"xy_m": -0.001, "yaw_rad": 0.1}, "spread.xy_m"),
        ({"xy_m": 0.001, "yaw_rad": "a"}, "spread.yaw_rad"),
        ({"xy_m": 0.001, "yaw_rad": 0.1, "z_m": 0.1}, "z_m"),
        (0.005, "spread"),
    ],
)
def test_a_spread_that_is_none_is_refused(service: Service, spread: Any, says: str) -> None:
    answer = service.http.post("/v1/scenarios", json=spread_body(service.upload(box_obj()), spread=spread))
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:invalid-request")
    assert says in answer.json()["detail"]


@pytest.mark.parametrize("spread", [{"xy_m": 0.005, "yaw_rad": 0.05}, {"xy_m": 0.005, "yaw_rad": 0.0}])
def test_a_spread_needs_a_mesh(service: Service, spread: Json) -> None:
    answer = service.http.post("/v1/scenarios", json=data_scenario(spread=spread))
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:voa:problem:no-mesh")


@pytest.mark.parametrize("spread", [{"xy_m": 0.005, "yaw_rad": 0.0}, {"xy_m": 0.0, "yaw_rad": 0.05}])
def test_a_spread_of_one_kind_is_one(service: Service, spread: Json) -> None:
    id_ = spread_scenario(service, spread=spread)
    assert service.get(f"/v1/scenarios/{id_}")["spread"] == spread
    session = service.open(id_)
    look(service, session, seen_from(service, "E", "A"))
    assert record_of(service.inside.sessions.state(session).looks).places[0].copies == 64
