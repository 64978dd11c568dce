"""Sensor configurations and poses from messages: listed ones by name, free ones by their numbers."""

import pytest

from tests.support.scenarios import core_scenario
from voa_core.errors import InvalidInput, UnknownName
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_msgs import geometry
from voa_msgs.geometry import CandidateSensor
from voa_msgs.sessions import ScanRequest
from voa_service.mapping.sensors import candidates, place_of, sensor_of

HERE = {"x": 1.0, "y": 2.0, "yaw_rad": 3.0, "height_m": 0.25}


def taken_at(**place: object) -> ScanRequest:
    return ScanRequest.model_validate(place | {"scan": {"ranges": [0.5]}})


def test_a_listed_configuration_keeps_every_number() -> None:
    message = geometry.SensorConfiguration.model_validate(HERE | {"name": "N", "cost": 0.5})
    assert sensor_of(message) == SensorConfiguration("N", 1.0, 2.0, 3.0, 0.25, 0.5)


def test_candidates_are_all_listed_ones_or_the_requested_ones_in_their_order() -> None:
    scenario = core_scenario()
    free = CandidateSensor.model_validate(HERE | {"cost": 0.5})
    assert candidates(scenario, None) == scenario.sensors
    assert candidates(scenario, ["Q2", free]) == (
        scenario.sensor("Q2"),
        SensorConfiguration("1", 1.0, 2.0, 3.0, 0.25, 0.5),
    )


def test_two_candidates_of_one_name_are_refused() -> None:
    with pytest.raises(InvalidInput, match="names that differ"):
        candidates(core_scenario(), ["Q1", CandidateSensor.model_validate(HERE | {"name": "Q1"})])


def test_an_unknown_candidate_is_refused_with_the_listed_ones() -> None:
    with pytest.raises(UnknownName) as refused:
        candidates(core_scenario(), ["Q9"])
    assert refused.value.known == ["Q1", "Q2"]


def test_the_place_of_a_scan_is_a_listed_configuration_or_a_pose() -> None:
    scenario = core_scenario()
    assert place_of(scenario, taken_at(sensor="Q2")) == (scenario.sensor("Q2"), None)
    assert place_of(scenario, taken_at(sensor_pose=HERE)) == (
        SensorConfiguration("sensor_pose", 1.0, 2.0, 3.0, 0.25),
        None,
    )


@pytest.mark.parametrize(
    ("std", "uncertainty"),
    [
        ({"xy_m": 0.0, "yaw_rad": 0.0}, None),
        ({"xy_m": 0.02}, SensorUncertainty(0.02, 0.0)),
        ({"yaw_rad": 0.1}, SensorUncertainty(0.0, 0.1)),
    ],
)
def test_a_pose_is_uncertain_where_a_deviation_is_above_zero(
    std: dict[str, float], uncertainty: SensorUncertainty | None
) -> None:
    assert place_of(core_scenario(), taken_at(sensor_pose=HERE | {"std": std}))[1] == uncertainty
