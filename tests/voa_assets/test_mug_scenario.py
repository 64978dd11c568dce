"""The mug's scenario says what the preliminary paper's Fig. 2 and Fig. 3 say."""

import json

import numpy as np
import pytest

from tests.voa_assets.mugs import scenario_of
from voa_assets import path
from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.ranking import Ranking, rank
from voa_core.scans import scan_of
from voa_core.scenario import Scenario
from voa_core.updating import update

FILE = path("mug/scenario.json")
POSES = ("U_0", "U_90", "D_90", "U_180", "U_45", "U_135")
GRASPS = ("TD0", "TD90", "OI90", "TDH0")
FIG_2 = [[0, 8, 0, 14], [9, 0, 14, 0], [0, 0, 13, 0], [8, 10, 0, 0], [9, 9, 0, 0], [9, 9, 0, 0]]


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return scenario_of(FILE)


@pytest.fixture(scope="module")
def ranking(scenario: Scenario) -> Ranking:
    return rank(
        scenario.sensors,
        lambda sensor: scenario.weigher(sensor, np.float64, keep=True),
        scenario.prior,
        scenario.table,
        scenario.policy,
    )


def after(scenario: Scenario, sensor: str, pose: str) -> Belief:
    """The belief after the scan that is predicted for `pose`."""
    stand = scenario.sensor(sensor)
    ranges = scenario.predictor.predict(stand).dense()[POSES.index(pose)]
    outcome = update(scenario.prior, scenario.evidence(scan_of(scenario.lidar, list(ranges)), stand), scenario.policy)
    assert outcome.accepted
    return outcome.belief


def expected(scenario: Scenario, belief: Belief) -> dict[str, float]:
    return dict(zip(GRASPS, scenario.table.expected_scores(belief.p).tolist(), strict=True))


def test_poses_grasps_and_scores_are_those_of_fig_2(scenario: Scenario) -> None:
    assert scenario.poses.names == POSES
    assert scenario.table.names == GRASPS
    np.testing.assert_allclose(scenario.table.scores.T * 15, FIG_2, rtol=0.0, atol=1e-12)


def test_every_pose_rests_on_the_table_with_its_handle_where_its_name_says(scenario: Scenario) -> None:
    body = json.loads(FILE.read_text(encoding="utf-8"))
    assert all(abs(np.linalg.norm(pose["quaternion_wxyz"]) - 1.0) < 1e-15 for pose in body["poses"])
    rotations, positions = scenario.poses.rotations, scenario.poses.positions
    assert rotations is not None
    assert positions is not None
    for name, rotation, position in zip(POSES, rotations, positions, strict=True):
        way, angle = name.split("_")
        assert rotation[2, 2] == pytest.approx(1.0 if way == "U" else -1.0, abs=1e-15)
        assert np.degrees(np.arctan2(rotation[1, 0], rotation[0, 0])) == pytest.approx(float(angle), abs=1e-12)
        lowest = 0.0 if way == "U" else rotation[2, 2] * 0.095
        assert position[2] + lowest == pytest.approx(0.0, abs=1e-15)


def test_every_sensor_stands_40_cm_away_and_faces_the_mug(scenario: Scenario) -> None:
    for sensor in scenario.sensors:
        assert np.hypot(sensor.x, sensor.y) == pytest.approx(0.40, abs=5e-4)
        ahead = np.array([np.cos(sensor.yaw_rad), np.sin(sensor.yaw_rad)])
        assert ahead @ [-sensor.x, -sensor.y] / np.hypot(sensor.x, sensor.y) > np.cos(np.radians(0.2))


def test_no_return_m_is_about_as_far_as_the_mug_can_be_seen_from_any_sensor(scenario: Scenario) -> None:
    for sensor in scenario.sensors:
        assert (
            scenario.predictor.predict(sensor).ranges[np.isfinite(scenario.predictor.predict(sensor).ranges)].max()
            < scenario.rule.no_return_m
        )


def test_before_any_look_td90_is_best_with_0_40(scenario: Scenario, ranking: Ranking) -> None:
    assert ranking.before.index == GRASPS.index("TD90")
    assert ranking.before.expected_score == pytest.approx(0.40, abs=1e-12)


def test_the_first_look_makes_oi90_best_if_the_mug_is_at_u_90(scenario: Scenario, ranking: Ranking) -> None:
    first = ranking.looks[0]
    belief = after(scenario, first.sensor.name, "U_90")
    choice = best_grasp(scenario.table, belief.p)
    assert ranking.worth_looking()
    assert choice.index == GRASPS.index("OI90")
    assert first.assistance.best_grasps[POSES.index("U_90")] == choice.index
    assert first.assistance.scores[POSES.index("U_90")] == pytest.approx(choice.expected_score, abs=1e-12)


def test_the_belief_after_that_look_is_that_of_fig_3(scenario: Scenario, ranking: Ranking) -> None:
    belief = after(scenario, ranking.looks[0].sensor.name, "U_90")
    np.testing.assert_allclose(belief.p, [0.07, 0.354, 0.358, 0.07, 0.07, 0.07], rtol=0.0, atol=0.01)
    scores = expected(scenario, belief)
    assert scores["OI90"] == pytest.approx(0.64, abs=0.01)
    assert belief.p[1] * 14 / 15 == pytest.approx(0.33, abs=0.01)
    assert belief.p[2] * 13 / 15 == pytest.approx(0.31, abs=0.01)
    assert belief.p[1] * 9 / 15 == pytest.approx(0.21, abs=0.01)


def test_u_90_and_d_90_look_alike_from_everywhere_and_that_does_not_matter(scenario: Scenario) -> None:
    for sensor in scenario.sensors:
        ranges = scenario.predictor.predict(sensor).dense()
        upright, upside_down = ranges[POSES.index("U_90")], ranges[POSES.index("D_90")]
        assert (np.isfinite(upright) == np.isfinite(upside_down)).all()
        seen = np.isfinite(upright)
        np.testing.assert_allclose(upright[seen], upside_down[seen], rtol=0.0, atol=1e-6)


def test_no_two_looks_are_worth_the_same(ranking: Ranking) -> None:
    worth = np.array([look.net_value for look in ranking.looks])
    assert (-np.diff(worth) > 1e-3).all()
    assert worth[0] - worth[1] > 0.01


def test_the_figures_of_the_readme_are_these(scenario: Scenario, ranking: Ranking) -> None:
    lines = path("mug/README.md").read_text(encoding="utf-8").splitlines()
    for look in ranking.looks:
        belief = after(scenario, look.sensor.name, "U_90")
        best, score = max(expected(scenario, belief).items(), key=lambda item: item[1])
        cells = [look.sensor.name, f"{look.assistance.voa:.3f}", *(f"{share:.2f}" for share in belief.p)]
        assert f"| {' | '.join(cells)} | {best}, {score:.2f} |" in lines


def test_all_scans_stay_within_the_workspace(scenario: Scenario) -> None:
    for sensor in scenario.sensors:
        prediction = scenario.predictor.predict(sensor)
        heading = sensor.yaw_rad + prediction.grid.angles[prediction.columns]
        hit = np.isfinite(prediction.ranges)
        ranges: Floats = np.where(hit, prediction.ranges, 0.0)
        for start, direction in ((sensor.x, np.cos(heading)), (sensor.y, np.sin(heading))):
            assert np.abs(np.where(hit, start + ranges * direction, 0.0)).max() < 0.075
