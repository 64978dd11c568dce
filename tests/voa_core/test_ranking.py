import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.filtering import Belief
from voa_core.grasps import Choice, GraspTable
from voa_core.lidars import SensorConfiguration
from voa_core.prediction import Prediction
from voa_core.ranking import Ranking, rank
from voa_core.rules.registry import rule_of
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

LIDAR = lidar_of(1, range_max=2.0)
TABLE = GraspTable.of_probabilities(["left", "right"], [[1.0, 0.0], [0.0, 1.0]], 2)
BELIEF = Belief.of([0.75, 0.25])
"""Grasping at once succeeds with 0.75; a look that distinguishes the poses is worth 0.25."""


def weigher_of(sensor: SensorConfiguration) -> Weigher:
    """A sensor at x > 0 distinguishes the poses, others do not."""
    ranges = np.array([[0.5], [1.0 if sensor.x > 0.0 else 0.5]])
    return Weigher.of(rule_of("margin", LIDAR), Prediction.of_dense(LIDAR.grid, ranges), np.float64, keep=True)


def ranked(*sensors: tuple[str, float, float]) -> Ranking:
    stands = [SensorConfiguration(name, x, 0.0, 0.0, cost=cost) for name, x, cost in sensors]
    return rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy())


def names(ranking: Ranking) -> list[str]:
    return [look.sensor.name for look in ranking.looks]


def test_looks_come_best_first_with_what_they_are_worth() -> None:
    ranking = ranked(("blind", -1.0, 0.0), ("seeing", 1.0, 0.0))
    assert names(ranking) == ["seeing", "blind"]
    assert [look.assistance.voa for look in ranking.looks] == pytest.approx([0.25, 0.0])
    assert ranking.before == Choice(0, 0.75)
    assert ranking.worth_looking()


def test_costs_are_taken_off() -> None:
    ranking = ranked(("far", 1.0, 0.2), ("near", 1.0, 0.1), ("blind", -1.0, 0.0), ("dear", 1.0, 0.4))
    assert names(ranking) == ["near", "far", "blind", "dear"]
    assert [look.net_value for look in ranking.looks] == pytest.approx([0.15, 0.05, 0.0, -0.15])


def test_ties_stay_as_listed_and_a_rounding_does_not_break_them() -> None:
    assert names(ranked(("b", 1.0, 0.1), ("a", 1.0, 0.1), ("c", 1.0, 0.1 - 2e-13))) == ["b", "a", "c"]
    assert names(ranked(("b", 1.0, 0.1), ("a", 1.0, 0.1), ("c", 1.0, 0.1 - 2e-12))) == ["c", "b", "a"]


def test_many_looks_that_tie_stay_as_listed() -> None:
    ranking = ranked(*((str(number), 1.0, 0.1 * (number % 3)) for number in range(300)))
    assert names(ranking) == [str(number) for rest in range(3) for number in range(rest, 300, 3)]


@pytest.mark.parametrize(("cost", "worth"), [(0.2449, True), (0.2451, False), (0.25, False), (0.5, False)])
def test_a_look_is_worth_it_if_it_gains_more_than_half_a_percent(cost: float, worth: bool) -> None:
    assert ranked(("a", 1.0, cost)).worth_looking() is worth


@pytest.mark.parametrize(("min_gain", "worth"), [(0.0, True), (0.0499, True), (0.0501, False)])
def test_how_much_a_look_must_gain_can_be_said(min_gain: float, worth: bool) -> None:
    assert ranked(("a", 1.0, 0.2)).worth_looking(min_gain) is worth


def test_looks_tie_with_the_first_within_a_millionth() -> None:
    ranking = ranked(("a", 1.0, 0.1), ("b", 1.0, 0.1 + 9e-7), ("c", 1.0, 0.1 + 1.1e-6), ("d", -1.0, 0.0))
    assert [ranking.ties_with_first(look) for look in ranking.looks] == [True, True, False, False]


def test_threads_give_the_same_ranking() -> None:
    stands = [SensorConfiguration(str(i), math.sin(i), 0.0, 0.0, cost=0.01 * (i % 3)) for i in range(12)]
    alone = rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy())
    with ThreadPoolExecutor(2) as pool:
        threaded = rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy(), ordered_map=pool.map)
    assert names(threaded) == names(alone)


def test_the_definition_and_the_sensor_agents_belief_reach_every_look() -> None:
    stands = [SensorConfiguration("a", 1.0, 0.0, 0.0)]
    sure = Belief.of([0.0, 1.0])
    posterior = rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy(), sensor_belief=sure)
    executed = rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy(), sensor_belief=sure, definition="executed")
    assert posterior.looks[0].net_value == pytest.approx(1.0 - 0.75)
    assert executed.looks[0].net_value == pytest.approx(1.0 - 0.0)


@pytest.mark.parametrize("calls", range(6))
def test_a_ranking_ends_at_whichever_check_finds_that_it_is_not_wanted(calls: int) -> None:
    left = calls

    def check() -> None:
        nonlocal left
        if left == 0:
            raise InterruptedError
        left -= 1

    stands = [SensorConfiguration(name, 1.0, 0.0, 0.0) for name in "abc"]
    with pytest.raises(InterruptedError):  # before each sensor and each block of its weights
        rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy(), check=check)


def test_a_ranking_that_is_wanted_is_that_without_a_check() -> None:
    stands = [SensorConfiguration(name, 1.0, 0.0, 0.0) for name in "abc"]
    checked = rank(stands, weigher_of, BELIEF, TABLE, UpdatePolicy(), check=lambda: None)
    assert [look.net_value for look in checked.looks] == [0.25] * 3
