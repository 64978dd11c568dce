"""Policies: which look they choose, and that a seed decides."""

from functools import partial

import numpy as np
import pytest

from voa_fleet.episodes.policies import POLICIES, Choice, Policy, Situation, policy_named
from voa_fleet.errors import UnknownName
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import GraspNow, Look, Ranking


def ranking(advice: Look | GraspNow) -> Ranking:
    return Ranking(
        version=0,
        definition="posterior",
        method="exact",
        precision="float64",
        expected_score_before=0.25,
        best_grasp_before="TOP",
        ranking=[],
        recommendation=advice,
    )


def unasked() -> Ranking:
    raise AssertionError("this policy asks nobody")


def tour(policy: Policy, mug: FleetObject, looks: int) -> list[str | None]:
    """The looks that a policy takes, the robot standing where it looked last."""
    places = {sensor.name: sensor for sensor in mug.scenario.sensors}
    robot = SensorPose(x=1.0, y=0.0, yaw_rad=0.0)
    visited: list[str] = []
    chosen: list[str | None] = []
    for _ in range(looks):
        choice = policy.choose(Situation(tuple(mug.scenario.sensors), tuple(visited), robot, unasked))
        chosen.append(choice.sensor)
        if choice.sensor is not None:
            visited.append(choice.sensor)
            robot = places[choice.sensor]
    return chosen


def test_voa_does_as_the_service_says(mug: FleetObject) -> None:
    policy, robot = policy_named("voa", 0), SensorPose(x=1.0, y=0.0, yaw_rad=0.0)
    look = Look(action="look", sensor="NNW", net_value=0.1)
    grasp = GraspNow(action="grasp", grasp="TD0", expected_score=0.9)
    said: Look | GraspNow
    for said, wanted in ((look, "NNW"), (grasp, None)):
        situation = Situation(tuple(mug.scenario.sensors), ("NNW",), robot, partial(ranking, said))
        assert policy.choose(situation) == Choice(wanted, ranking(said))


def test_nearest_goes_around(mug: FleetObject) -> None:
    # From the east; then always the next place, until there is none left.
    around = ["ENE", "ESE", "SSE", "SSW", "WSW", "WNW", "NNW", "NNE", None]
    assert tour(policy_named("nearest", 0), mug, 9) == around


def test_random_visits_each_place_once_and_the_seed_decides(mug: FleetObject) -> None:
    first = tour(policy_named("random", 5), mug, 9)
    assert sorted(name for name in first if name is not None) == sorted(s.name for s in mug.scenario.sensors)
    assert first[-1] is None
    assert tour(policy_named("random", 5), mug, 9) == first
    assert any(tour(policy_named("random", seed), mug, 9) != first for seed in range(3))


def test_random_favours_no_place(mug: FleetObject) -> None:
    firsts = [tour(policy_named("random", seed), mug, 1)[0] for seed in range(400)]
    counts = np.array([firsts.count(sensor.name) for sensor in mug.scenario.sensors])
    assert counts.sum() == 400
    assert counts.min() > 25  # 50 each on average, standard deviation 6.6


def test_none_grasps_at_once(mug: FleetObject) -> None:
    assert tour(policy_named("none", 0), mug, 1) == [None]


def test_an_unknown_policy_lists_those_that_exist() -> None:
    assert [policy_named(name, 0).name for name in POLICIES] == list(POLICIES)
    with pytest.raises(UnknownName, match="no policy 'best'; there are: voa, random, nearest, none"):
        policy_named("best", 0)
