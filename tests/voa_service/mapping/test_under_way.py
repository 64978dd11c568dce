"""Announced looks: their text in the store, their expiry, and the scans that end them."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import PREDICTIONS, Json, as_scan
from voa_core.errors import NoMesh, UnknownName
from voa_core.filtering import Belief
from voa_core.prediction import ObservationPredictor
from voa_msgs.looks import AnnouncedLook, LookAnnouncement
from voa_msgs.sessions import ScanRequest
from voa_service.mapping.observations import ScanObservation, scan_observation
from voa_service.mapping.under_way import (
    LASTS,
    announced,
    announced_looks,
    check_announced,
    stored_places,
    stored_text,
    without_announcement,
)
from voa_store.records import SessionState

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
POSE = {"x": 0.1, "y": 0.2, "yaw_rad": 0.3, "height_m": None, "std": {"xy_m": 0.01, "yaw_rad": 0.02}}


def look(id_: str, at: datetime = NOON, **place: object) -> AnnouncedLook:
    return announced(id_, LookAnnouncement.model_validate({"robot": "tb3"} | place), at)


def scan(sensor: str, missing: bool = False) -> ScanObservation:
    body: Json = {"ranges": [None] * 4} if missing else as_scan(PREDICTIONS[sensor]["P1"])
    return scan_observation(core_scenario(), ScanRequest.model_validate({"sensor": sensor, "scan": body}))


def state(*looks: AnnouncedLook) -> SessionState:
    belief = Belief.uniform(3)
    return SessionState("S", "scenario", 0, belief, belief, None, NOON, NOON, under_way=stored_text(looks))


def ids(text: str | None, now: datetime = NOON) -> list[str]:
    return [each.id for each in announced_looks(text, now)]


def test_announced_looks_come_back_as_they_were_stored() -> None:
    looks = [look("a", sensor="Q1"), look("b", sensor_pose=POSE)]
    assert announced_looks(stored_text(looks), NOON) == looks
    assert looks[1].sensor_pose is not None
    assert looks[1].sensor_pose.model_dump() == POSE
    assert stored_text([]) is None
    assert announced_looks(None, NOON) == []


def test_an_announced_look_ends_by_itself_after_two_minutes() -> None:
    early, late = look("early", sensor="Q1"), look("late", NOON + timedelta(seconds=1), sensor="Q1")
    assert early.expires_at == NOON + LASTS == NOON + timedelta(seconds=120)
    text = stored_text([early, late])
    assert ids(text, NOON + LASTS - timedelta(microseconds=1)) == ["early", "late"]
    assert ids(text, NOON + LASTS) == ["late"]


def test_an_announced_look_ends_where_the_clock_is_set_back_and_not_where_clocks_differ_a_little() -> None:
    text = stored_text([look("a", sensor="Q1")])
    assert ids(text, NOON - timedelta(seconds=60)) == ["a"], "made by a replica whose clock is a minute ahead"
    assert ids(text, NOON - timedelta(seconds=61)) == []


def test_a_scan_ends_the_announcements_of_its_place_alone() -> None:
    before = state(look("a", sensor="Q1"), look("b", sensor="Q2"), look("c", sensor="Q1"), look("d", sensor_pose=POSE))
    for missing in (False, True):  # one that is not accepted was taken, too
        assert ids(without_announcement(before, scan("Q1", missing), NOON).under_way) == ["b", "d"]
    assert without_announcement(state(look("a", sensor="Q1")), scan("Q1"), NOON).under_way is None


def test_a_scan_removes_what_has_expired() -> None:
    before = state(look("a", sensor="Q2"), look("b", NOON + LASTS, sensor="Q2"))
    after = without_announcement(before, scan("Q1"), NOON + LASTS)
    assert ids(after.under_way, NOON + LASTS - timedelta(seconds=1)) == ["b"]


def test_a_scan_leaves_a_session_without_announcements_alone() -> None:
    before = state()
    assert without_announcement(before, scan("Q1"), NOON) is before


def test_a_look_whose_scan_cannot_be_predicted_is_refused() -> None:
    scenario = core_scenario()
    check_announced(scenario, LookAnnouncement(sensor="Q1"))
    with pytest.raises(UnknownName):
        check_announced(scenario, LookAnnouncement(sensor="Q9"))
    with pytest.raises(NoMesh, match="by name"):
        check_announced(scenario, LookAnnouncement.model_validate({"sensor_pose": POSE}))


def without_cuts(_height_m: float) -> Any:
    raise AssertionError("a look is announced without any prediction")


@pytest.mark.parametrize(
    ("of_lidar", "of_pose", "is_known"), [(None, None, False), (0.02, None, True), (None, 0.02, True)]
)
def test_a_sensor_pose_needs_the_height_of_its_scan_plane(
    of_lidar: float | None, of_pose: float | None, is_known: bool
) -> None:
    own = core_scenario()
    lidar = replace(own.lidar, height_m=of_lidar)
    scenario = replace(own, predictor=ObservationPredictor(own.poses, lidar, own.predictor.data, without_cuts))
    request = LookAnnouncement.model_validate({"sensor_pose": POSE | {"height_m": of_pose}})
    if is_known:
        check_announced(scenario, request)
    else:
        with pytest.raises(NoMesh, match="height_m"):
            check_announced(scenario, request)


def test_equal_places_are_equal_whoever_looks_and_when() -> None:
    one, other = look("a", sensor="Q1"), look("b", NOON + LASTS, sensor="Q1", robot="another")
    assert stored_places([one]) == stored_places([other]) != stored_places([look("c", sensor="Q2")])
    assert stored_places([one, other]) != stored_places([one])
    assert stored_places([]) is None
