import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import box, lidar_of, standing
from voa_core.displacements import Spread
from voa_core.errors import NoMesh, UnknownName
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, predictor_of_mesh
from voa_core.ranking import rank
from voa_core.rules.registry import rule_of
from voa_core.scans import scan_of
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace

LIDAR = lidar_of(4, range_max=2.0)
Q1, Q2 = SensorConfiguration("Q1", -0.3, 0.1, 0.0), SensorConfiguration("Q2", -0.5, 0.1, 0.0)
MESH = predictor_of_mesh(box(0.2, 0.2, 0.2), standing((0.0, 0.0, 0.0), (0.3, 0.0, 0.0)), LIDAR)
DATA = ObservationPredictor(
    PoseSet.named(["P0", "P1"]),
    LIDAR,
    {"Q1": np.array([[0.3, math.inf, 1.2, math.inf], [0.6, math.inf, 1.2, math.inf]]), "Q2": np.full((2, 4), math.inf)},
)


BELIEF = Belief.of([0.4, 0.6])


def scenario_of(predictor: ObservationPredictor, workspace: Workspace | None = None) -> Scenario:
    return Scenario(
        predictor.poses,
        GraspTable.of_probabilities(["G"], [[0.5, 0.5]], 2),
        (Q1, Q2),
        predictor,
        rule_of("exponential", LIDAR),
        UpdatePolicy(),
        Belief.uniform(2),
        workspace,
    )


def test_sensors_are_looked_up_by_name() -> None:
    scenario = scenario_of(MESH)
    assert scenario.sensor("Q2") is Q2
    assert scenario.lidar is LIDAR


@pytest.mark.parametrize("names", [["Q3"], ["Q1", "Q3"]])
def test_a_sensor_that_does_not_exist_is_refused_with_those_that_do(names: list[str]) -> None:
    with pytest.raises(UnknownName, match="there is no sensor 'Q3'; there are: 'Q1', 'Q2'"):
        scenario_of(MESH).rank(sensors=names)


def test_a_scenario_ranks_its_own_sensors_or_some_of_them() -> None:
    table = GraspTable.of_probabilities(["G", "H"], [[0.9, 0.2], [0.1, 0.8]], 2)
    scenario = replace(scenario_of(DATA), table=table)
    expected = rank((Q1, Q2), lambda s: scenario.weigher(s, np.float64, keep=True), BELIEF, table, scenario.policy)
    ranking = scenario.rank(BELIEF)
    assert [look.sensor.name for look in ranking.looks] == [look.sensor.name for look in expected.looks] == ["Q1", "Q2"]
    assert [look.net_value for look in ranking.looks] == [look.net_value for look in expected.looks]
    assert [look.sensor for look in scenario.rank(sensors=["Q2"]).looks] == [Q2]
    uniform = scenario.rank(definition="executed", sensor_belief=Belief.uniform(2))
    assert uniform.looks[0].net_value == scenario.rank(Belief.uniform(2), definition="executed").looks[0].net_value


def test_data_hold_where_the_scenarios_own_sensors_stand_and_nowhere_else() -> None:
    scenario = scenario_of(DATA)
    scan = scan_of(LIDAR, [0.3, math.inf, 1.2, math.inf])
    assert scenario.evidence(scan, Q1).distances[0] == 0.0
    moved = SensorConfiguration("Q1", -0.31, 0.1, 0.0)
    assert scenario.lists(Q1)
    assert not scenario.lists(moved)
    with pytest.raises(NoMesh):
        scenario.evidence(scan, moved)
    with pytest.raises(NoMesh):
        scenario.weigher(moved, np.float64, keep=False)


@pytest.mark.parametrize("moved", [{"name": "Q3"}, {"x": -0.31}, {"y": 0.11}, {"yaw_rad": 0.01}, {"height_m": 0.05}])
def test_a_sensor_that_differs_in_where_it_stands_is_not_listed(moved: dict[str, Any]) -> None:
    scenario = scenario_of(DATA)
    elsewhere = replace(Q1, **moved)
    assert not scenario.lists(elsewhere)
    with pytest.raises(NoMesh):
        scenario.weigher(elsewhere, np.float64, keep=False)


def test_a_sensor_that_costs_something_else_is_listed() -> None:
    assert scenario_of(DATA).lists(replace(Q1, cost=0.5))


def test_evidence_takes_an_uncertain_sensor_pose() -> None:
    scan = scan_of(LIDAR, [0.32, math.inf, math.inf, math.inf])
    exact = scenario_of(MESH).evidence(scan, Q1)
    vague = scenario_of(MESH).evidence(scan, Q1, SensorUncertainty(0.02, 0.0))
    assert exact.distances[0] == pytest.approx(0.02)
    assert (exact.copies, vague.copies) == (1, 64)
    assert vague.distances[0] < 0.002  # one of the copies lies about where the object is


def test_a_spread_and_the_copies_of_a_place_decide_how_many_copies_are_compared() -> None:
    scan = scan_of(LIDAR, [0.32, math.inf, math.inf, math.inf])
    spread = replace(scenario_of(MESH), spread=Spread(0.005, 0.05), seed="s")
    assert spread.evidence(scan, Q1).copies == 64
    assert spread.evidence(scan, Q1, SensorUncertainty(0.03, 0.0)).copies == 256
    assert spread.evidence(scan, Q1, copies=128).copies == 128
    assert scenario_of(MESH).evidence(scan, Q1, copies=128).copies == 1
    few, many = spread.evidence(scan, Q1), spread.evidence(scan, Q1, copies=256)
    np.testing.assert_array_equal(many.log_copies[:, :64], few.log_copies)
    other = replace(spread, seed="t").evidence(scan, Q1)
    assert not np.allclose(other.log_copies, few.log_copies, rtol=1e-3)
    with pytest.raises(NoMesh):
        replace(scenario_of(DATA), spread=Spread(0.005, 0.05)).evidence(scan, Q1)


def test_evidence_says_from_where_the_scan_was_taken() -> None:
    scan = scan_of(LIDAR, [0.32, math.inf, math.inf, math.inf])
    listed = scenario_of(MESH).evidence(scan, Q1).viewpoint
    assert listed is not None
    assert (listed.listed, listed.height_m) == ("Q1", LIDAR.height_m)
    own = scenario_of(MESH).evidence(scan, replace(Q1, x=-0.31, height_m=0.05)).viewpoint
    assert own is not None
    assert (own.listed, own.x, own.height_m) == (None, -0.31, 0.05)


def test_an_estimate_starts_with_the_prior() -> None:
    start = replace(scenario_of(MESH), absent=0.3).start
    assert start.belief.p.tolist() == [0.5, 0.5]
    assert start.absent == pytest.approx(0.3)
    assert scenario_of(MESH).start.absent is None


def test_what_is_compared_in_a_ranking_lies_in_the_workspace() -> None:
    near = scenario_of(DATA, Workspace((-0.1, -0.1), (0.1, 0.4)))
    everywhere = scenario_of(DATA)
    np.testing.assert_array_equal(everywhere.weigher(Q1, np.float64, keep=False).ranges, [[0.3, 1.2], [0.6, 1.2]])
    np.testing.assert_array_equal(
        near.weigher(Q1, np.float64, keep=False).ranges, [[0.3, math.inf], [math.inf, math.inf]]
    )


def test_weighers_have_the_requested_precision() -> None:
    kept = scenario_of(MESH).weigher(Q1, np.float32, keep=True)
    assert kept.panels is not None
    assert kept.dtype == np.float32
    assert scenario_of(MESH).weigher(Q1, np.float64, keep=False).panels is None
