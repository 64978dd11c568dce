"""Course of a tour: which look comes next by a ranking, and what is requested of the service for it."""

import json

import pytest

from tests.support.serving import data_scenario, mesh_scenario
from tests.voa_client.roles import ranked, updated
from voa_client import CandidateSensor, Location, Look, PoseUncertainty, Ranking, UpdatedSession
from voa_client._responses import Response
from voa_client._tour import Itinerary, Reach, announcement, reach_by_poses
from voa_msgs.scenarios import Scenario

STORED = {"id": "c", "created_at": "2026-01-01T00:00:00Z"}
STD = PoseUncertainty(xy_m=0.01, yaw_rad=0.02)
EVERYWHERE = Reach(None)
PAIR = Look(action="look", sensor="A", net_value=0.2, then="B")


def ranking(reply: Response) -> Ranking:
    return Ranking.model_validate_json(reply.body)


def after(*, accepted: bool = True) -> UpdatedSession:
    return UpdatedSession.model_validate_json(updated(accepted=accepted).body)


def stored(**changes: object) -> Scenario:
    """A scenario as the service returns it, of a box with sensor configurations E and N."""
    return Scenario.model_validate_json(json.dumps(mesh_scenario("box", **STORED, **changes)))


def begun(most_looks: int = 10, *, accepted: bool = True) -> Itinerary:
    """An itinerary whose only look is the first of a pair."""
    itinerary = Itinerary(EVERYWHERE, most_looks)
    itinerary.take(PAIR, after(accepted=accepted))
    return itinerary


def test_the_recommended_look_comes_next_until_it_is_a_grasp_or_the_looks_are_used_up() -> None:
    itinerary = Itinerary(EVERYWHERE, most_looks=1)
    look = itinerary.next(ranking(ranked("A")))
    assert look is not None
    assert look.sensor == "A"
    assert itinerary.next(ranking(ranked(None, A=0.1))) is None
    itinerary.take(look, after())
    assert itinerary.next(ranking(ranked("A"))) is None


@pytest.mark.parametrize(
    ("then", "accepted", "expected"),
    [
        (ranked(None, B=0.001, A=0.0), True, "B"),
        (ranked(None, C=0.002, B=0.001), True, "B"),
        (ranked("C", then="D", B=0.001), True, "B"),
        (ranked("C", B=0.001), True, "C"),
        (ranked(None, B=0.0), True, None),
        (ranked(None, B=-0.03), True, None),
        (ranked(None, C=0.001), True, None),
        (ranked("C", then="D", B=-0.03), True, "C"),
        (ranked("A", then="B", B=-0.03), False, "A"),
        (ranked(None, B=0.001), False, None),
    ],
    ids=[
        "no look is recommended",
        "nor is another place taken",
        "another pair",
        "a single look",
        "nothing is left to learn",
        "not worth its cost",
        "not ranked",
        "another pair instead",
        "the first was not accepted",
        "grasp after a refused look",
    ],
)
def test_the_second_look_of_a_pair_is_taken_as_long_as_it_is_worth_its_cost(
    then: Response, accepted: bool, expected: str | None
) -> None:
    look = begun(accepted=accepted).next(ranking(then))
    assert (None if look is None else look.sensor) == expected


def test_the_plan_of_a_pair_ends_with_its_second_look() -> None:
    itinerary = begun()
    second = itinerary.next(ranking(ranked(None, B=0.001)))
    assert second is not None
    itinerary.take(second, after())
    assert itinerary.next(ranking(ranked(None, B=0.001))) is None
    assert [look.sensor for look in itinerary.looks] == ["A", "B"]


def test_a_pair_is_not_begun_where_only_one_look_is_left() -> None:
    assert Itinerary(EVERYWHERE, most_looks=2).next(ranking(ranked("A", then="B"))) == PAIR.model_copy(
        update={"net_value": 0.1}
    )
    assert Itinerary(EVERYWHERE, most_looks=1).next(ranking(ranked("A", then="B"))) is None
    assert begun(most_looks=2).next(ranking(ranked("C", then="D", B=0.1))) is not None


def test_nothing_is_requested_that_older_services_do_not_know_unless_the_caller_states_it() -> None:
    plain = Itinerary(EVERYWHERE, 10, stands_at="A").request()
    assert plain.model_dump(exclude_unset=True) == {"sensors": None, "grasps": None}
    costly = Reach(("A", "B"), STD, cost_per_m=0.1)
    assert "from" not in costly.ranking_request().model_dump(exclude_unset=True), "the place of departure is unknown"
    request = costly.ranking_request("A", ["G"]).model_dump(exclude_unset=True)
    assert request == {
        "sensors": ["A", "B"],
        "grasps": ["G"],
        "sensor_std": {"xy_m": 0.01, "yaw_rad": 0.02},
        "from": "A",
        "cost_per_m": 0.1,
    }


def test_a_drive_starts_from_the_last_look() -> None:
    reach = Reach(("A", CandidateSensor(x=1.0, y=2.0, yaw_rad=0.0)), cost_per_m=0.1)
    itinerary = Itinerary(reach, 10)
    itinerary.take(Look(action="look", sensor="A", net_value=0.1), after())
    assert itinerary.request().from_ == "A"
    itinerary.take(Look(action="look", sensor="1", net_value=0.1), after())
    assert itinerary.request().from_ == Location(x=1.0, y=2.0)


def test_a_stated_uncertainty_needs_poses_and_is_stated_with_every_look() -> None:
    reach = reach_by_poses(Reach(("N", CandidateSensor(name="far", x=3.0, y=3.0, yaw_rad=0.0)), STD), stored())
    assert reach.candidates is not None
    assert reach.candidates[0] == CandidateSensor(
        name="N", x=0.0, y=0.3, yaw_rad=-1.5707963267948966, cost=0.01, height_m=0.02
    )
    for name, x in (("N", 0.0), ("far", 3.0)):
        pose = reach.place(name).sensor_pose
        assert pose is not None
        assert (pose.x, pose.std) == (x, STD)
    assert len(reach_by_poses(Reach(None, STD), stored()).candidates or ()) == 2
    assert announcement(reach.place("N"), "scout").model_dump(exclude_unset=True)["robot"] == "scout"


def test_predictions_as_data_are_of_named_places_only() -> None:
    data = Scenario.model_validate_json(json.dumps(data_scenario(**STORED)))
    reach = Reach(("Q1",), STD)
    assert reach_by_poses(reach, data) == reach
    assert reach.place("Q1").sensor == "Q1"
