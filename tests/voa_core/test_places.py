import math
from dataclasses import replace

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.lidars import SensorConfiguration
from voa_core.places import Place, Viewpoint, index_of_place, log_increment

HERE = Viewpoint(None, 0.5, -0.2, 3.13, 0.1)
LISTED = Viewpoint("Q1", 0.5, -0.2, 3.13, 0.1)


@pytest.mark.parametrize(
    ("other", "shared"),
    [
        (HERE, True),
        (replace(HERE, x=0.52), True),
        (replace(HERE, x=0.515, y=-0.185), False),
        (replace(HERE, y=-0.2201), False),
        (replace(HERE, yaw_rad=3.13 + math.radians(2.0)), True),
        (replace(HERE, yaw_rad=3.13 + math.radians(1.9) - 2.0 * math.pi), True),
        (replace(HERE, yaw_rad=3.13 - math.radians(2.1)), False),
        (replace(HERE, height_m=0.11), True),
        (replace(HERE, height_m=0.111), False),
        (LISTED, False),
    ],
)
def test_sensor_poses_share_a_place_within_2_cm_2_degrees_and_1_cm_of_height(other: Viewpoint, shared: bool) -> None:
    assert other.shares_place(HERE) is shared
    assert HERE.shares_place(other) is shared


def test_listed_sensors_share_a_place_by_name_alone() -> None:
    assert LISTED.shares_place(replace(LISTED, x=9.0))
    assert not LISTED.shares_place(replace(LISTED, listed="Q2"))


def test_a_viewpoint_has_the_lidars_height_where_the_sensor_has_none() -> None:
    sensor = SensorConfiguration("Q1", 0.5, -0.2, 3.13)
    assert Viewpoint.of(sensor, lidar_of(height=0.1), listed=True) == LISTED
    assert Viewpoint.of(replace(sensor, height_m=0.1), lidar_of(height=0.3), listed=False) == HERE
    assert Viewpoint.of(sensor, lidar_of(height=None), listed=False).height_m is None


def test_unknown_heights_are_alike() -> None:
    assert replace(HERE, height_m=None).shares_place(replace(HERE, height_m=None))


def test_a_look_belongs_to_the_oldest_place_whose_first_look_is_near() -> None:
    places = [
        Place(viewpoint, (0,), np.zeros((2, 1)))
        for viewpoint in (None, LISTED, replace(HERE, x=0.53), HERE, replace(HERE, x=0.515))
    ]
    assert index_of_place(places, replace(HERE, x=0.514)) == 2
    assert index_of_place(places, HERE) == 3
    assert index_of_place(places, LISTED) == 1
    assert index_of_place(places, replace(HERE, x=0.6)) is None
    assert index_of_place(places, None) is None


def test_the_weight_of_a_place_is_the_mean_over_copies_of_the_product_of_its_looks() -> None:
    first, second = np.array([[0.5, 0.1], [0.2, 0.0]]), np.array([[0.4, 0.2], [0.3, 0.6]])
    with np.errstate(divide="ignore"):
        logs = np.log(first), np.log(second)
    place = Place(HERE, (), np.zeros((2, 1))).with_look(3, logs[0])
    both = place.with_look(5, logs[1])
    assert both.looks == (3, 5)
    np.testing.assert_allclose(np.exp(both.log_weights), (first * second).mean(axis=1))
    expected = (first * second).mean(axis=1) / first.mean(axis=1)
    np.testing.assert_allclose(np.exp(log_increment(place, both, logs[1])), expected)
    np.testing.assert_allclose(np.exp(log_increment(None, place, logs[0])), first.mean(axis=1))


def test_a_pose_that_the_place_has_ruled_out_stays_so() -> None:
    place = Place(HERE, (), np.zeros((2, 1))).with_look(1, np.array([[-np.inf, -np.inf], [0.0, -np.inf]]))
    after = place.with_look(2, np.zeros((2, 2)))
    assert log_increment(place, after, np.zeros((2, 2))).tolist() == [-np.inf, 0.0]


def test_a_look_whose_copies_are_all_alike_joins_any_place() -> None:
    place = Place(HERE, (), np.zeros((1, 1))).with_look(1, np.log([[0.5]]))
    assert place.copies == 1
    vague = place.with_look(2, np.log([[0.2, 0.4]]))
    assert vague.copies == 2
    np.testing.assert_allclose(np.exp(vague.with_look(3, np.log([[0.5]])).log_weights), [0.5 * 0.3 * 0.5])


def test_a_look_with_other_copies_than_its_place_is_refused() -> None:
    place = Place(HERE, (1,), np.zeros((1, 2)))
    with pytest.raises(ValueError, match="the look has 4 copies of each pose and its place 2"):
        place.with_look(2, np.zeros((1, 4)))


def test_a_place_says_what_memory_it_holds() -> None:
    assert Place(None, (), np.zeros((3, 4))).nbytes == 3 * 4 * 8
