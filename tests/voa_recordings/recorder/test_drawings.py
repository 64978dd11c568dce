"""Drawing of versions: complete while the service is quick, and never in the way of a recording."""

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from voa_assets import path as asset_path
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_msgs.rankings import Ranking, VoaRequest
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_msgs.sessions import BeliefRequest, HistoryEntry, Scan, ScanRequest, SessionRequest
from voa_recordings.files.foxglove_types import SCENE
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.recorder import drawings
from voa_recordings.recorder.drawings import Drawings, Ranked
from voa_recordings.recorder.inbox import Inbox, VersionOfSession

STORE = RosTypes().store
AFTERWARDS_NS = 2_000_000_000 * 1_000_000_000


@pytest.fixture
def client(process: str) -> Iterator[Client]:
    with Client(process, timeout_s=30.0) as own:
        yield own


def moved(client: Client, scenario: Scenario) -> tuple[str, list[HistoryEntry]]:
    """A session with a look from the scenario's first place, whose belief was replaced then."""
    session = client.create_session(SessionRequest(scenario=scenario.id)).id
    ranges = client.predict(scenario.id).ranges[0][0]
    empty = [index for index, value in enumerate(ranges) if value is None]
    scan = Scan(ranges=ranges, no_return=empty)
    client.apply_scan(session, ScanRequest(sensor=scenario.sensors[0].name, scan=scan))
    client.put_belief(session, BeliefRequest(belief=None))
    return session, list(client.history(session, beliefs=True))


def drawn(
    client: Client,
    scenario: Scenario,
    session: str,
    history: list[HistoryEntry],
    ranked: Ranked = "sparingly",
    now_ns: Callable[[], int] = lambda: AFTERWARDS_NS,
) -> tuple[list[VersionOfSession], Drawings]:
    inbox = Inbox()
    own = Drawings(client, inbox, STORE, now_ns, ranked)
    own.start()
    for entry in history:
        own.want(session, scenario, entry, newest=entry is history[-1])
    items: list[VersionOfSession] = []

    def complete() -> bool:
        while (item := inbox.get(0.0)) is not None:
            assert isinstance(item, VersionOfSession)
            items.append(item)
        versions = sum(item.what == "probabilities" for item in items)
        return versions + sum(entry.belief is None for entry in history) == len(history)

    wait_for(complete, "every version is drawn")
    own.end()
    return items, own


def entities(items: list[VersionOfSession]) -> list[dict[str, Any]]:
    """The groups of each scene."""
    scenes: list[Any] = [STORE.deserialize_cdr(item.data, SCENE) for item in items if item.what == "scene"]
    return [{entity.id: entity for entity in scene.entities} for scene in scenes]


def heights(scene: dict[str, Any]) -> set[float]:
    return {tower.size.z for tower in scene["looks"].cylinders}


def test_each_version_has_ghosts_towers_and_the_newest_scan(client: Client) -> None:
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session, history = moved(client, scenario)
    items, own = drawn(client, scenario, session, history)
    assert (own.failed, own.unranked) == ({}, Counter())
    scenes = entities(items)
    assert [len(scene["belief"].models) for scene in scenes] == [1, 1, 1]
    assert all(len(heights(scene)) > 1 for scene in scenes), "places differ in value"
    assert heights(scenes[0]) != heights(scenes[1]), "each version has values of its own"
    assert [len(scene["scan"].cubes) > 0 for scene in scenes] == [False, True, True]
    outlines = [{pair.key for pair in scene["scan"].metadata if "predicted" in pair.key} for scene in scenes]
    assert [bool(pieces) for pieces in outlines] == [False, True, True]
    grasps = [{pair.value for pair in scene["grasp"].metadata} for scene in scenes]
    assert grasps == [{f"best grasp {entry.best_grasp}"} for entry in history]


def test_places_are_not_ranked_if_nobody_wants_it(client: Client) -> None:
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session, history = moved(client, scenario)
    items, own = drawn(client, scenario, session, history, "never")
    assert [len(heights(scene)) for scene in entities(items)] == [1, 1, 1], "flat discs"
    assert own.unranked == Counter()


@pytest.mark.parametrize(("ranked", "with_towers"), [("sparingly", 1), ("always", 3)])
def test_a_service_that_is_slow_ranks_one_version_unless_all_are_wanted(
    client: Client, ranked: Ranked, with_towers: int
) -> None:
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session, history = moved(client, scenario)
    seconds = iter(range(1_000))
    items, own = drawn(
        client, scenario, session, history, ranked, lambda: AFTERWARDS_NS + next(seconds) * 10_000_000_000
    )
    assert sum(len(heights(scene)) > 1 for scene in entities(items)) == with_towers
    assert own.unranked == ({} if with_towers == 3 else {session: 2})


def test_a_scenario_without_a_mesh_is_shown_by_its_numbers(client: Client) -> None:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    session = client.create_session(SessionRequest(scenario=scenario.id)).id
    items, own = drawn(client, scenario, session, list(client.history(session, beliefs=True)))
    assert own.failed == {}
    assert Counter(item.what for item in items)["entropy_nats"] == 1
    assert entities(items)[0]["belief"].models == []


def test_a_mesh_that_cannot_be_fetched_is_reported_and_the_rest_is_drawn(client: Client) -> None:
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session, history = moved(client, scenario)
    gone = scenario.model_copy(update={"object": "0" * 64})
    items, own = drawn(client, gone, session, history[:1], "never")
    assert own.failed[session].startswith("the mesh of its object could not be fetched: ")
    assert entities(items)[0]["looks"].cylinders


def test_a_history_without_beliefs_is_reported(client: Client) -> None:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    session = client.create_session(SessionRequest(scenario=scenario.id)).id
    items, own = drawn(client, scenario, session, list(client.history(session)))
    assert items == []
    assert "no beliefs" in own.failed[session]


def test_versions_stand_at_their_time_but_at_most_an_hour_before_the_recording(client: Client) -> None:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    session = client.create_session(SessionRequest(scenario=scenario.id)).id
    (entry,) = client.history(session, beliefs=True)
    made_ns = int(entry.at.timestamp() * 1e9)
    hour_ns = 3_600 * 1_000_000_000
    for now_ns, expected in (
        (made_ns + 1_000_000_000, made_ns),
        (made_ns + 50 * hour_ns, made_ns + 49 * hour_ns),
        (made_ns - 5_000_000_000, made_ns - 5_000_000_000),
    ):
        items, _ = drawn(client, scenario, session, [entry], "never", lambda now_ns=now_ns: now_ns)  # type: ignore[misc] # bound in each round, which mypy cannot infer
        (at_ns,) = {item.at_ns for item in items}
        assert at_ns == pytest.approx(expected, abs=1_000)


def test_a_version_that_cannot_be_drawn_does_not_end_the_drawing(client: Client) -> None:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    session = client.create_session(SessionRequest(scenario=scenario.id)).id
    (entry,) = client.history(session, beliefs=True)
    odd = entry.model_copy(update={"expected_score": "odd"})
    own = Drawings(client, Inbox(), STORE, lambda: AFTERWARDS_NS, "never")
    own.start()
    own.want("odd", scenario, odd, newest=True)
    own.want(session, scenario, entry, newest=True)
    own.end()
    assert list(own.failed) == ["odd"]
    assert own.failed["odd"].startswith("version 0 cannot be drawn")


def test_a_ranking_that_never_ends_keeps_no_version_out_of_the_recording(
    process: str, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session, history = moved(client, scenario)
    begun, released = threading.Event(), threading.Event()

    class Stuck(Client):
        def rank_looks(self, session_id: str, request: VoaRequest | None = None) -> Ranking:
            begun.set()
            released.wait()
            return super().rank_looks(session_id, request)

    monkeypatch.setattr(drawings, "_END_S", 0.1)
    inbox = Inbox()
    with Stuck(process) as stuck:
        own = Drawings(stuck, inbox, STORE, lambda: AFTERWARDS_NS)
        own.start()
        for entry in history:
            own.want(session, scenario, entry, newest=True)
        wait_for(begun.is_set, "the ranking has begun")
        own.end()
        items: list[VersionOfSession] = []
        while isinstance(item := inbox.get(0.0), VersionOfSession):
            items.append(item)
        assert [len(heights(scene)) for scene in entities(items)] == [1, 1, 1], "flat discs"
        assert own.unranked == {session: 3}
        released.set()
