"""Scenarios: stored under the digest of their content with its defaults; and predictions within bounds."""

import hashlib
import json
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.serving import PREDICTIONS, Service, box_obj, data_scenario, mesh_scenario
from voa_core.errors import NoMesh, UnknownName
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_service.failures import InvalidRequest, NotFound, TooLarge, UnknownReference
from voa_service.settings import Limits
from voa_service.usecases.scenarios import Scenarios


@pytest.fixture
def scenarios(service: Service) -> Scenarios:
    return service.inside.scenarios


def request(**changes: Any) -> ScenarioRequest:
    return ScenarioRequest.model_validate(data_scenario(**changes))


def test_a_scenario_is_new_once_and_keeps_the_time_of_its_first_storage(scenarios: Scenarios) -> None:
    early = Scenarios(
        scenarios.store, scenarios.models, scenarios.presets, scenarios.limits, lambda: datetime(2026, 1, 2, tzinfo=UTC)
    )
    first, new = early.create(request(name="once"))
    again, repeated = scenarios.create(request(name="once"))
    assert (new, repeated) == (True, False)
    assert again == first == scenarios.get(first.id)


def test_the_id_depends_on_the_content_with_its_defaults_written_out(scenarios: Scenarios) -> None:
    plain = scenarios.create(request())[0].id
    explicit = data_scenario(update={"rule": "exponential", "no_return_m": 1.0, "on_no_match": "reject"})
    assert scenarios.create(ScenarioRequest.model_validate(explicit))[0].id == plain
    others = [request(name="other"), request(min_gain=0.01), request(prior=[0.5, 0.25, 0.25])]
    assert len({plain, *(scenarios.create(other)[0].id for other in others)}) == 4


def test_a_new_field_with_its_default_is_no_part_of_the_id(
    scenarios: Scenarios,
) -> None:
    own = scenarios.create(request())[0]
    content = own.request().model_dump(mode="json")
    assert (content.pop("min_gain"), content["update"].pop("on_nothing_seen")) == (0.005, "reject")
    assert (content.pop("spread"), content.pop("absent")) == (None, None)
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    assert hashlib.sha256(text.encode()).hexdigest() == own.id
    evidence = {"rule": "exponential", "no_return_m": 1.0, "on_nothing_seen": "evidence"}
    assert scenarios.create(request(update=evidence))[0].id != own.id
    assert scenarios.create(request(absent=0.1))[0].id != own.id


def test_a_scenario_from_before_spread_and_absence_keeps_its_id(scenarios: Scenarios) -> None:
    plain = scenarios.create(request())[0].id
    assert scenarios.create(request(spread=None, absent=None))[0].id == plain


def test_the_spread_is_part_of_the_id_and_comes_back(scenarios: Scenarios, service: Service) -> None:
    body = mesh_scenario(service.upload(box_obj()))
    plain, spread, wider = (
        scenarios.create(ScenarioRequest.model_validate(body | more))[0]
        for more in ({}, {"spread": {"xy_m": 0.005, "yaw_rad": 0.05}}, {"spread": {"xy_m": 0.006, "yaw_rad": 0.05}})
    )
    assert len({plain.id, spread.id, wider.id}) == 3
    assert plain.spread is None
    assert scenarios.get(spread.id).spread == spread.spread
    assert spread.spread is not None
    assert spread.spread.model_dump() == {"xy_m": 0.005, "yaw_rad": 0.05}


def test_a_list_shows_the_size_and_the_rule_of_each_scenario(scenarios: Scenarios) -> None:
    own = scenarios.create(request(name="listed"))[0]
    (summary,) = [item for item in scenarios.list(1000, None).items if item.id == own.id]
    assert (summary.name, summary.object, summary.rule) == ("listed", None, "exponential")
    assert (summary.poses, summary.grasps, summary.sensors, summary.created_at) == (3, 2, 2, own.created_at)
    with pytest.raises(InvalidRequest, match="expected the `next` of a page"):
        scenarios.list(1, "abc")


def test_predictions_given_as_data_come_back(scenarios: Scenarios) -> None:
    own = scenarios.create(request())[0].id
    predictions = scenarios.predict(own, PredictionsRequest(sensors=["Q2"]))
    assert (predictions.sensors, predictions.poses) == (["Q2"], ["P1", "P2", "P3"])
    assert predictions.ranges == [list(PREDICTIONS["Q2"].values())]
    assert scenarios.predict(own, None).sensors == ["Q1", "Q2"]


def test_predictions_that_cannot_be_made_are_refused(scenarios: Scenarios) -> None:
    own = scenarios.create(request())[0].id
    with pytest.raises(UnknownName):
        scenarios.predict(own, PredictionsRequest(sensors=["Q9"]))
    with pytest.raises(NoMesh):
        scenarios.predict(
            own, PredictionsRequest.model_validate({"sensors": [{"x": 0.5, "y": 0.0, "yaw_rad": 0.0, "height_m": 0.1}]})
        )


def test_more_predictions_than_a_response_may_hold_are_refused_with_the_most(scenarios: Scenarios) -> None:
    few = Scenarios(scenarios.store, scenarios.models, scenarios.presets, Limits(numbers=12), scenarios.now)
    own = scenarios.create(request())[0].id
    assert few.predict(own, PredictionsRequest(sensors=["Q1"])).sensors == ["Q1"]
    with pytest.raises(TooLarge, match=r"24 ranges, and may hold at most 12: request at most 1 sensors"):
        few.predict(own, None)


@pytest.mark.parametrize("read", ["get", "warnings", "predict"])
def test_a_scenario_that_does_not_exist_is_refused(scenarios: Scenarios, read: str) -> None:
    arguments: dict[str, tuple[Any, ...]] = {"predict": (None,)}
    with pytest.raises(NotFound, match="there is no scenario 'nothing'"):
        getattr(scenarios, read)("nothing", *arguments.get(read, ()))


def test_a_scenario_of_an_unknown_object_is_refused_and_not_stored(scenarios: Scenarios, service: Service) -> None:
    before = service.stored()
    with pytest.raises(UnknownReference, match="there is no object 'nothing'"):
        scenarios.create(ScenarioRequest.model_validate(mesh_scenario("nothing")))
    assert service.stored() == before


def test_the_presets_are_those_that_a_scenario_can_name(scenarios: Scenarios) -> None:
    assert {preset.name for preset in scenarios.lidars().items} == set(scenarios.presets)
    assert len(scenarios.presets) > 5
