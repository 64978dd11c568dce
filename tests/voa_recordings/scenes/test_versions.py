"""The messages of a version: scene, frames and numbers of what the history says."""

import math
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.views import stored_scenario
from voa_msgs.sessions import HistoryEntry
from voa_recordings.files.foxglove_types import FRAMES, SCENE
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.scenes.versions import Version, messages_of, taken_scan

STORE = RosTypes().store
SCENARIO = stored_scenario()
UPDATE = {
    "accepted": True, "reason": None, "log_evidence": -1.0, "fit_rmsd_mm": 1.5, "fit_hit_rmsd_mm": 1.5,
    "best_fit_pose": "B", "beams_compared": 360,
}  # fmt: skip
SCAN: dict[str, Any] = {"scan": {"ranges": [0.2] * 360}}


def entry(**changes: Any) -> HistoryEntry:
    """A version that a scan from E made, with the belief 0.25 and 0.75."""
    content: dict[str, Any] = {
        "version": 1, "kind": "scan", "at": datetime(2026, 1, 1, tzinfo=UTC), "request": SCAN | {"sensor": "E"},
        "update": UPDATE, "absent": 0.05, "belief": [0.25, 0.75], "best_grasp": "G2", "expected_score": 0.7,
        "entropy_nats": 0.5,
    }  # fmt: skip
    return HistoryEntry.model_validate(content | changes)


def made(own: HistoryEntry) -> dict[str, Any]:
    """Decoded messages by the last part of their topic."""
    version = Version("s1", SCENARIO, own, taken_scan(SCENARIO, own))
    return {
        message.what: STORE.deserialize_cdr(message.data, message.type_name)
        for message in messages_of(STORE, version, {}, 7)
    }


def test_a_scan_gives_every_message() -> None:
    messages = made(entry())
    numbers = {what: message.data for what, message in messages.items() if what not in ("scene", "frames")}
    assert list(numbers.pop("probabilities")) == [0.25, 0.75]
    assert numbers == {
        "entropy_nats": 0.5, "expected_score": 0.7, "best_grasp": "G2", "fit_rmsd_mm": 1.5, "absent": 0.05,
    }  # fmt: skip
    entities = {entity.id: entity for entity in messages["scene"].entities}
    assert {pair.key for pair in entities["belief"].metadata} == {"A", "B"}
    assert entities["scan"].cubes
    assert entities["robot"].texts[0].text == "lidar"


def test_frames_are_the_likeliest_pose_and_the_lidar_at_its_height() -> None:
    frames = {frame.child_frame_id: frame for frame in made(entry())["frames"].transforms}
    assert set(frames) == {"voa/s1/object", "voa/s1/lidar"}
    assert frames["voa/s1/object"].rotation.z == pytest.approx(math.sqrt(0.5)), "B is turned by 90 degrees"
    lidar = frames["voa/s1/lidar"]
    assert (lidar.translation.x, lidar.translation.z) == (0.3, 0.02)
    assert abs(lidar.rotation.z) == pytest.approx(1.0), "E looks to the west"


def test_a_prior_has_no_scan_and_no_fit() -> None:
    messages = made(entry(kind="prior", request={}, update=None, absent=None, best_grasp=None, expected_score=0.0))
    assert "fit_rmsd_mm" not in messages
    assert "absent" not in messages
    assert messages["best_grasp"].data == ""
    assert messages["expected_score"].data == 0.0
    assert [frame.child_frame_id for frame in messages["frames"].transforms] == ["voa/s1/object"]
    scene = {entity.id: entity for entity in messages["scene"].entities}
    assert (scene["scan"].cubes, scene["robot"].cylinders) == ([], [])


def test_types_are_those_that_viewers_know() -> None:
    version = Version("s1", SCENARIO, entry())
    types = {message.what: message.type_name for message in messages_of(STORE, version, {}, 7)}
    assert (types["scene"], types["frames"]) == (SCENE, FRAMES)
    assert (SCENE, FRAMES) == ("foxglove_msgs/msg/SceneUpdate", "foxglove_msgs/msg/FrameTransforms")


def test_without_a_belief_nothing_is_made() -> None:
    assert made(entry(belief=None)) == {}


def test_a_scan_from_a_stated_pose_lies_there() -> None:
    pose = {"x": 0.1, "y": 0.2, "yaw_rad": 0.3, "height_m": 0.05, "std": {"xy_m": 0.01}}
    own = entry(request=SCAN | {"sensor_pose": pose})
    taken = taken_scan(SCENARIO, own)
    assert taken is not None
    assert (taken.place.x, taken.place.height_m, len(taken.scan.ranges)) == (0.1, 0.05, 360)
    lidar = made(own)["frames"].transforms[1]
    assert lidar.translation.z == 0.05


@pytest.mark.parametrize(
    "request_", [SCAN | {"sensor": "gone"}, SCAN | {"sensor": "E", "lens": 1}, {"unheard": "of"}, None]
)
def test_a_scan_that_cannot_be_placed_is_left_out(request_: Any) -> None:
    own = entry(request=request_)
    assert taken_scan(SCENARIO, own) is None
    assert "scene" in made(own)
