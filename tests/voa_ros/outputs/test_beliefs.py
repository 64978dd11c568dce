import math
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.views import stored_scenario
from voa_msgs.sessions import Session
from voa_ros.outputs.beliefs import Bounds, detection, likeliest, pose_array

AT = datetime(2026, 1, 2, 3, 4, 5, 678_901, tzinfo=UTC)
HALF = math.sqrt(0.5)


def session(belief: list[float], **more: Any) -> Session:
    fields: dict[str, Any] = {
        "id": "s",
        "scenario": "1" * 64,
        "version": 3,
        "poses": ["A", "B"],
        "belief": belief,
        "best_grasp": "G1",
        "expected_score": 0.5,
        "entropy_nats": 0.1,
        "last_fit_rmsd_mm": None,
        "created_at": AT,
        "updated_at": AT,
    }
    return Session(**fields | more)


def test_a_detection_has_the_time_of_its_version() -> None:
    stamp = detection(stored_scenario(), session([0.5, 0.5]), "world")["header"]["stamp"]
    assert stamp == {"sec": int(AT.timestamp()), "nanosec": 678_901_000}


def test_poses_of_probability_0_are_left_out() -> None:
    results = detection(stored_scenario(), session([0.0, 1.0]), "map")["results"]
    assert [each["hypothesis"] for each in results] == [{"class_id": "B", "score": 1.0}]


def test_without_a_spread_the_covariance_is_zero() -> None:
    (first, _) = detection(stored_scenario(), session([0.5, 0.5]), "world")["results"]
    assert first["pose"]["covariance"] == [0.0] * 36


def test_the_box_turns_with_the_object() -> None:
    bounds = Bounds((0.0, 0.0, 0.0), (0.2, 0.1, 0.4))
    box = detection(stored_scenario(), session([0.2, 0.8]), "world", bounds)["bbox"]  # B: 90 degrees about z
    centre = box["center"]["position"]
    assert (centre["x"], centre["y"], centre["z"]) == pytest.approx((-0.05, 0.1, 0.2))
    assert box["size"] == {"x": 0.2, "y": 0.1, "z": 0.4}
    assert box["center"]["orientation"]["z"] == pytest.approx(HALF)


def test_a_pose_array_ends_where_95_per_cent_are_reached() -> None:
    array = pose_array(stored_scenario(), session([0.06, 0.94]), "world")
    assert len(array["poses"]) == 2
    (only,) = pose_array(stored_scenario(), session([0.05, 0.95]), "world")["poses"]
    assert only["orientation"]["z"] == pytest.approx(HALF)
    assert array["header"] == {"frame_id": "world"}, "the stamp is 0: the newest transform"


def test_equals_stay_in_their_order() -> None:
    assert likeliest([0.2, 0.0, 0.3, 0.2, 0.3]) == [2, 4, 0, 3]
