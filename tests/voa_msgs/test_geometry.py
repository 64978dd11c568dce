"""Sensor poses and configurations: defaults, units within bounds, and candidates by name or by pose."""

from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from voa_msgs.geometry import Candidate, CandidateSensor, SensorConfiguration, UncertainSensorPose

HERE = {"x": 1.0, "y": -2.0, "yaw_rad": 3.0}
CANDIDATE: TypeAdapter[Any] = TypeAdapter(Candidate)


def test_a_configuration_costs_nothing_and_has_the_lidar_s_height_unless_stated() -> None:
    sensor = SensorConfiguration.model_validate(HERE | {"name": "N"})
    assert (sensor.height_m, sensor.cost, sensor.data) == (None, 0.0, None)


@pytest.mark.parametrize("wrong", [{"cost": -0.1}, {"x": 1e7}, {"yaw_rad": None}, {"height_m": "0.2"}, {"z": 1.0}])
def test_a_configuration_with_another_value_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        SensorConfiguration.model_validate(HERE | {"name": "N"} | wrong)


def test_a_candidate_is_a_name_or_a_pose() -> None:
    assert CANDIDATE.validate_python("N") == "N"
    assert CANDIDATE.validate_python(HERE) == CandidateSensor(x=1.0, y=-2.0, yaw_rad=3.0)


@pytest.mark.parametrize(("wrong", "where"), [("", ("name",)), ({"x": 1.0}, ("pose", "y")), (7, ("pose",))])
def test_a_mistake_in_a_candidate_is_located_in_the_form_that_was_sent(wrong: Any, where: tuple[str, ...]) -> None:
    with pytest.raises(ValidationError) as error:
        CANDIDATE.validate_python(wrong)
    assert error.value.errors()[0]["loc"] == where


def test_an_uncertain_pose_has_deviations_of_at_least_zero() -> None:
    pose = UncertainSensorPose.model_validate(HERE | {"std": {"xy_m": 0.02}})
    assert pose.std is not None
    assert (pose.std.xy_m, pose.std.yaw_rad) == (0.02, 0.0)
    assert UncertainSensorPose.model_validate(HERE).std is None
    with pytest.raises(ValidationError):
        UncertainSensorPose.model_validate(HERE | {"std": {"yaw_rad": -0.1}})
