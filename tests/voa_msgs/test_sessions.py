"""Sessions and observations on the wire: one place for each scan, and absent fields that stay absent."""

from typing import Any

import pytest
from pydantic import ValidationError

from voa_msgs.sessions import MOST_ROBOTS, OutcomeRequest, Scan, ScanRequest, SessionRequest, UpdateReport

HERE = {"x": 0.5, "y": 0.0, "yaw_rad": 0.0}
SCAN = {"ranges": [0.5, None]}


@pytest.mark.parametrize("place", [{"sensor": "Q1"}, {"sensor_pose": HERE}, {"sensor": "Q1", "sensor_pose": None}])
def test_a_scan_has_a_place(place: dict[str, Any]) -> None:
    assert ScanRequest.model_validate(place | {"scan": SCAN}).scan == Scan(ranges=[0.5, None])


@pytest.mark.parametrize("places", [{}, {"sensor": None}, {"sensor": "Q1", "sensor_pose": HERE}])
def test_a_scan_with_no_place_or_two_is_refused(places: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match="exactly one of 'sensor' and 'sensor_pose' is expected"):
        ScanRequest.model_validate(places | {"scan": SCAN})


def test_a_scan_takes_its_grid_and_limits_from_the_lidar_unless_stated() -> None:
    scan = Scan.model_validate(SCAN)
    assert scan.no_return == []
    assert {scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.stamp} == {None}


@pytest.mark.parametrize(
    "wrong",
    [{"ranges": []}, {"ranges": [-0.1]}, {"no_return": [-1]}, {"no_return": [0.0]}, {"range_max": -1.0}, {"beams": 2}],
)
def test_a_scan_with_another_value_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Scan.model_validate(SCAN | wrong)


def test_a_session_without_robots_is_written_without_the_field() -> None:
    assert SessionRequest(scenario="S").model_dump() == {"scenario": "S", "prior": None}
    assert SessionRequest(scenario="S", robots=["r"]).model_dump()["robots"] == ["r"]


def test_a_session_claims_a_bounded_number_of_robots() -> None:
    names = [str(number) for number in range(MOST_ROBOTS + 1)]
    assert SessionRequest(scenario="S", robots=names[:-1]).robots == names[:-1]
    with pytest.raises(ValidationError):
        SessionRequest(scenario="S", robots=names)


@pytest.mark.parametrize("prior", [[0.5, 0.5], {"form": "pose_model", "categories": [{"pose": "A", "probability": 1}]}])
def test_a_prior_is_numbers_or_a_model(prior: Any) -> None:
    assert SessionRequest.model_validate({"scenario": "S", "prior": prior}).prior is not None


@pytest.mark.parametrize("wrong", [{"success": 1}, {"grasp": ""}, {"grasp": None}, {"object_moved_m": 1.0}])
def test_an_outcome_with_another_value_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        OutcomeRequest.model_validate({"grasp": "G1", "success": True} | wrong)


def test_a_report_has_one_of_the_documented_reasons() -> None:
    numbers = dict.fromkeys(("log_evidence", "fit_rmsd_mm", "fit_hit_rmsd_mm", "best_fit_pose"))
    report = {"accepted": False, "beams_compared": 0} | numbers
    for reason in ("no_beams", "nothing_seen", "bad_fit", "no_match", "nearest", None):
        assert UpdateReport.model_validate(report | {"reason": reason}).reason == reason
    with pytest.raises(ValidationError):
        UpdateReport.model_validate(report | {"reason": "other"})
