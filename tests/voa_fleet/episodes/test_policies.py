"""Policies: which look they choose, and that a seed decides."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from voa_fleet.episodes.forecasts import Forecast
from voa_fleet.episodes.policies import (
    POLICIES,
    Choice,
    HighestVoa,
    Situation,
    description_of,
    policy_named,
)
from voa_fleet.errors import InvalidPolicy, UnknownName
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import GraspNow, Look, RankedSensor, Ranking


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


def no_request(*_: object) -> Any:
    raise AssertionError("this policy needs no request")


def situation(
    mug: FleetObject,
    visited: tuple[str, ...],
    robot: SensorPose,
    rank: Callable[[], Ranking] = no_request,
    forecast: Callable[[], Forecast] = no_request,
    draw: Callable[[int], int] = no_request,
) -> Situation:
    belief = tuple([1.0 / len(mug.poses)] * len(mug.poses))
    return Situation(tuple(mug.scenario.sensors), visited, robot, belief, rank, forecast, draw)


def tour(name: str, mug: FleetObject, looks: int, seed: int = 0) -> list[str | None]:
    """The looks that a policy takes, the robot standing where it looked last."""
    policy, rng = policy_named(name), np.random.default_rng(seed)
    places = {sensor.name: sensor for sensor in mug.scenario.sensors}
    robot = SensorPose(x=1.0, y=0.0, yaw_rad=0.0)
    visited: list[str] = []
    chosen: list[str | None] = []
    for _ in range(looks):
        choice = policy.choose(situation(mug, tuple(visited), robot, draw=lambda count: int(rng.integers(count))))
        chosen.append(choice.sensor)
        if choice.sensor is not None:
            visited.append(choice.sensor)
            robot = places[choice.sensor]
    return chosen


def test_voa_does_as_the_service_says(mug: FleetObject) -> None:
    policy, robot = policy_named("voa"), SensorPose(x=1.0, y=0.0, yaw_rad=0.0)
    look = Look(action="look", sensor="NNW", net_value=0.1)
    grasp = GraspNow(action="grasp", grasp="TD0", expected_score=0.9)
    said: Look | GraspNow
    for said, wanted in ((look, "NNW"), (grasp, None)):
        now = situation(mug, ("NNW",), robot, rank=partial(ranking, said))
        assert policy.choose(now) == Choice(wanted, ranking(said))


def test_nearest_goes_around(mug: FleetObject) -> None:
    # From the east; then always the next place, until there is none left.
    around = ["ENE", "ESE", "SSE", "SSW", "WSW", "WNW", "NNW", "NNE", None]
    assert tour("nearest", mug, 9, 0) == around


def test_random_visits_each_place_once_and_the_seed_decides(mug: FleetObject) -> None:
    first = tour("random", mug, 9, 5)
    assert sorted(name for name in first if name is not None) == sorted(s.name for s in mug.scenario.sensors)
    assert first[-1] is None
    assert tour("random", mug, 9, 5) == first
    assert any(tour("random", mug, 9, seed) != first for seed in range(3))


def test_random_favours_no_place(mug: FleetObject) -> None:
    firsts = [tour("random", mug, 1, seed)[0] for seed in range(400)]
    counts = np.array([firsts.count(sensor.name) for sensor in mug.scenario.sensors])
    assert counts.sum() == 400
    assert counts.min() > 25  # 50 each on average, standard deviation 6.6


def test_none_grasps_at_once(mug: FleetObject) -> None:
    assert tour("none", mug, 1, 0) == [None]


def test_entropy_and_beams_look_where_the_forecast_says_each_place_once(mug: FleetObject) -> None:
    places, poses = len(mug.scenario.sensors), len(mug.poses)
    likelihoods, visible = np.full((places, poses, poses), 1.0 / poses), np.ones((places, poses))
    likelihoods[4], visible[6] = np.eye(poses), 5.0
    forecast, requests = Forecast(visible, likelihoods), []

    def request() -> Forecast:
        requests.append(1)
        return forecast

    robot = SensorPose(x=1.0, y=0.0, yaw_rad=0.0)
    for name, first in (("entropy", "WSW"), ("beams", "SSE")):
        policy = policy_named(name)
        assert policy.choose(situation(mug, (), robot, forecast=request)) == Choice(first)
        second = policy.choose(situation(mug, (first,), robot, forecast=request))
        assert second == Choice(mug.scenario.sensors[0].name)  # all others are equal
    assert len(requests) == 2


def test_an_unknown_policy_lists_those_that_exist() -> None:
    assert [policy_named(name).name for name in POLICIES] == list(POLICIES)
    with pytest.raises(UnknownName, match="no policy 'best'; there are: voa, entropy, beams, nearest, random, none"):
        policy_named("best")


def installed(folder: Path, name: str, value: str, source: str) -> None:
    """Lay down a package as an installer does: a module, and metadata with the entry point."""
    (folder / f"{value.partition(':')[0]}.py").write_text(source, encoding="utf-8")
    metadata = folder / f"{name}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    (metadata / "entry_points.txt").write_text(f"[voa.policies]\n{name} = {value}\n", encoding="utf-8")


def test_a_policy_of_an_installed_package_is_listed_and_described(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = (
        "from voa_fleet.episodes.policies import Choice\n"
        "class Mine:\n"
        "    'The second place.'\n"
        "    name = 'mine'\n"
        "    def choose(self, situation, /):\n"
        "        return Choice(situation.sensors[1].name)\n"
    )
    installed(tmp_path, "mine", "policy_of_mine:Mine", source)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert description_of("mine") == "The second place"
    assert description_of("none") == POLICIES["none"]
    assert policy_named("mine").name == "mine"


def test_a_package_that_offers_no_policy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed(tmp_path, "broken", "policy_that_breaks:make", "def make(): return 7\n")
    installed(tmp_path, "absent", "policy_without:make", "")
    installed(tmp_path, "voa", "policy_of_voa:make", "def make(): return 7\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(InvalidPolicy, match=r"'broken': expected that policy_that_breaks:make makes .* got int"):
        policy_named("broken")
    with pytest.raises(InvalidPolicy, match=r"'absent' \(policy_without:make\) cannot be loaded"):
        policy_named("absent")
    assert isinstance(policy_named("voa"), HighestVoa)  # a built-in policy is never replaced


def valued(advice: Look | GraspNow, **net_values: float) -> Ranking:
    """A ranking with the net values of some places."""
    looks = [
        RankedSensor(
            sensor=name,
            voa=value,
            standard_error=None,
            cost=0.0,
            net_value=value,
            expected_score_after=0.5,
            ties_with_first=False,
        )
        for name, value in net_values.items()
    ]
    return ranking(advice).model_copy(update={"ranking": looks})


PAIR = Look(action="look", sensor="NNW", net_value=0.3, then="SSE")
GRASP = GraspNow(action="grasp", grasp="TD0", expected_score=0.9)


def after(mug: FleetObject, answer: Ranking, *visited: str, looks_left: int | None = None) -> Situation:
    """A situation after some looks, in which the service ranks so."""
    now = situation(mug, visited, SensorPose(x=1.0, y=0.0, yaw_rad=0.0), rank=lambda: answer)
    return replace(now, looks_left=looks_left)


def test_voa_takes_both_looks_of_a_pair(mug: FleetObject) -> None:
    policy = HighestVoa()
    assert policy.choose(after(mug, valued(PAIR))).sensor == "NNW"
    assert policy.choose(after(mug, valued(GRASP, SSE=0.002), "NNW")).sensor == "SSE"
    assert policy.choose(after(mug, valued(GRASP, SSE=0.002), "NNW", "SSE")).sensor is None


def test_voa_forgets_a_pair_whose_second_look_is_worth_nothing_any_more(mug: FleetObject) -> None:
    policy = HighestVoa()
    policy.choose(after(mug, valued(PAIR)))
    assert policy.choose(after(mug, valued(GRASP, SSE=-0.02), "NNW")).sensor is None
    policy.choose(after(mug, valued(PAIR)))
    assert policy.choose(after(mug, valued(GRASP, SSE=0.002))).sensor is None, "another episode has begun"


def test_voa_begins_no_pair_with_the_last_look(mug: FleetObject) -> None:
    assert HighestVoa().choose(after(mug, valued(PAIR), looks_left=2)).sensor == "NNW"
    assert HighestVoa().choose(after(mug, valued(PAIR), looks_left=1)).sensor is None
    single = Look(action="look", sensor="NNW", net_value=0.3)
    assert HighestVoa().choose(after(mug, valued(single), looks_left=1)).sensor == "NNW"
