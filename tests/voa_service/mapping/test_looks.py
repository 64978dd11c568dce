"""The record of a session's looks: its text in the store, and the places that it counts."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voa_core.estimates import Attempts
from voa_core.filtering import Belief
from voa_core.lidars import SensorUncertainty
from voa_core.places import Place, Viewpoint
from voa_service.mapping.looks import LookRecord, PlaceRecord, place_messages, record_of

LISTED = Viewpoint("Q1", 0.1, 0.2, 0.3, 0.05)
FREE = Viewpoint(None, 1 / 3, -0.2, math.pi, None)

NUMBERS = st.floats(allow_nan=False, width=64)
VIEWPOINTS = st.builds(Viewpoint, st.none() | st.text(max_size=8), NUMBERS, NUMBERS, NUMBERS, st.none() | NUMBERS)
RECORDS = st.builds(
    LookRecord,
    st.lists(st.builds(PlaceRecord, VIEWPOINTS, st.integers(1, 99), st.integers(1, 256)), max_size=3).map(tuple),
    st.lists(st.builds(Attempts, st.integers(0, 9), st.integers(0, 9), st.integers(0, 9)), max_size=3).map(tuple),
    st.none() | NUMBERS,
    st.none() | st.builds(SensorUncertainty, st.floats(0, 9), st.floats(0, 9)),
    st.integers(0, 10**6),
)


@given(RECORDS)
def test_a_record_is_read_from_its_text_to_the_last_bit(record: LookRecord) -> None:
    text = record.text()
    assert record_of(text) == record
    assert record_of(text).text() == text
    assert (text is None) is (record == LookRecord())


@pytest.mark.parametrize("odds", [math.inf, -math.inf, -0.0, 5e-324])
def test_certain_absence_and_certain_presence_survive(odds: float) -> None:
    read = record_of(LookRecord(log_odds_absent=odds).text()).log_odds_absent
    assert read is not None
    assert read.hex() == odds.hex()


def test_a_session_from_before_looks_were_recorded_has_none() -> None:
    assert record_of(None) == LookRecord()


def test_the_text_of_a_record_stays_readable() -> None:
    """Databases contain it: another layout needs a migration."""
    place = PlaceRecord(LISTED, 2, 64)
    record = LookRecord((place,), (Attempts(1, 2, 3),), -1.5, SensorUncertainty(0.01, 0.02), 7)
    assert json.loads(record.text() or "") == {
        "places": [["Q1", 0.1, 0.2, 0.3, 0.05, 2, 64]],
        "attempts": [[1, 2, 3]],
        "log_odds_absent": -1.5,
        "std": [0.01, 0.02],
        "since": 7,
    }


def test_looks_are_counted_at_the_viewpoint_of_the_first() -> None:
    near = Viewpoint(None, FREE.x + 0.01, FREE.y, -math.pi, None)
    record = LookRecord().with_look(None, Place(LISTED, (1,), np.zeros((3, 1))), None)
    record = record.with_look(record.index_of(FREE), Place(FREE, (2,), np.zeros((3, 64))), 0.5)
    assert record.index_of(near) == 1
    record = record.with_look(1, Place(near, (2, 3), np.zeros((3, 256))), 0.25)
    assert record.places == (PlaceRecord(LISTED, 1, 1), PlaceRecord(FREE, 2, 256))
    assert (record.log_odds_absent, record.index_of(Viewpoint("Q2", 0.1, 0.2, 0.3, 0.05))) == (0.25, None)


def test_a_look_from_an_unknown_viewpoint_has_no_place() -> None:
    assert LookRecord().with_look(None, Place(None, (1,), np.zeros((3, 1))), 0.5) == LookRecord(log_odds_absent=0.5)


def test_a_restarted_record_keeps_the_last_std_alone() -> None:
    std = SensorUncertainty(0.01, 0.02)
    record = LookRecord((PlaceRecord(LISTED, 1, 64),), (Attempts(0, 1, 0),), 4.0, std, 1)
    assert record.restarted(5, None) == LookRecord(std=std, since=5)


def test_an_estimate_has_the_attempts_and_the_odds_of_its_record() -> None:
    attempts, place = (Attempts(0, 1, 2),), Place(LISTED, (1,), np.zeros((2, 1)))
    estimate = LookRecord((PlaceRecord(LISTED, 1, 1),), attempts, 0.5).estimate(Belief.uniform(2), place)
    assert (estimate.places, estimate.attempts, estimate.log_odds_absent) == ((place,), attempts, 0.5)
    assert LookRecord().estimate(Belief.uniform(2)).places == ()


def test_a_place_is_shown_by_its_name_or_by_its_first_pose() -> None:
    named, free = place_messages([PlaceRecord(LISTED, 2, 64), PlaceRecord(FREE, 1, 1)])
    assert (named.sensor, named.sensor_pose, named.looks) == ("Q1", None, 2)
    assert free.sensor is None
    assert free.sensor_pose is not None
    assert free.sensor_pose.model_dump() == {"x": 1 / 3, "y": -0.2, "yaw_rad": math.pi, "height_m": None}
