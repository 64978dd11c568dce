import math
from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import box, data_predictor, lidar_of
from voa_core import evidence, prediction
from voa_core.displaced_scans import DisplacedScans, predict_copies, remembered_copies
from voa_core.displacements import (
    Displacements,
    Spread,
    covariances,
    displacement_count,
    lower_roots,
    scaled,
    standard_normal_points,
)
from voa_core.errors import InvalidInput, NoMesh
from voa_core.geometry import quaternion_of_matrix, turn
from voa_core.lidars import BeamGrid, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scans import Scan

POSES = PoseSet.from_arrays(
    ["A", "B", "C"],
    [[0.0, 0.0, 0.0], [0.2, -0.1, 0.0], [0.1, 0.3, 0.05]],
    [[math.cos(yaw), 0.0, 0.0, math.sin(yaw)] for yaw in (0.2, -0.3, 0.5)],
)
AT = SensorConfiguration("a", -0.5, 0.08, 0.3)
CUBE = box(0.2, 0.13, 0.2)
LIDAR = lidar_of(90)


def moved(poses: PoseSet, x: float, y: float, yaw: float) -> PoseSet:
    """Turn every pose about its own position, and move it."""
    assert poses.positions is not None
    assert poses.rotations is not None
    quaternions = [quaternion_of_matrix(turn(yaw) @ rotation) for rotation in poses.rotations]
    return PoseSet.from_arrays(poses.names, poses.positions + np.array([x, y, 0.0]), quaternions)


def test_a_spread_alone_is_the_covariance_of_every_pose() -> None:
    covariance = covariances(POSES, AT, Spread(0.01, 0.05), None)
    np.testing.assert_allclose(covariance, np.repeat(np.diag([1e-4, 1e-4, 0.0025])[None], 3, axis=0), rtol=1e-15)
    assert not covariances(PoseSet.named(["A", "B"]), AT, None, SensorUncertainty(0.0, 0.0)).any()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_error_of_the_sensor_is_a_displacement_of_the_object(axis: int) -> None:
    # A small error of the sensor changes a scan as the displacement does that the covariance has for it: the column
    # of A_a is the eigenvector of the covariance that this error alone causes.
    small = 1e-5
    error = np.zeros(3)
    error[axis] = small
    stands = SensorConfiguration("a", AT.x + error[0], AT.y + error[1], AT.yaw_rad + error[2])
    std = SensorUncertainty(0.0, small) if axis == 2 else SensorUncertainty(small, 0.0)
    covariance = covariances(POSES, AT, None, std)
    predictor = predictor_of_mesh(CUBE, POSES, LIDAR)
    expected, still = predictor.predict(stands).dense(), predictor.predict(AT).dense()
    for pose in range(3):
        column = covariance[pose][:, 2] / -small if axis == 2 else -error
        displacement = np.repeat(column[None, None], 3, axis=0)
        actual = predictor.predict_displaced(AT, displacement).dense()[pose]
        both = np.isfinite(actual) & np.isfinite(expected[pose])
        assert np.abs(still[pose][both] - expected[pose][both]).max() > 0.5 * small
        np.testing.assert_allclose(actual[both], expected[pose][both], rtol=0, atol=100 * small**2)


def test_errors_of_object_and_sensor_add_up() -> None:
    assert POSES.positions is not None
    rng = np.random.default_rng(2)
    spread, std = Spread(0.002, 0.01), SensorUncertainty(0.003, 0.004)
    drawn = rng.standard_normal((200_000, 6))
    own = drawn[:, :3] * [spread.xy_m, spread.xy_m, spread.yaw_rad]
    ex, ey, turned = (drawn[:, 3:] * [std.xy_m, std.xy_m, std.yaw_rad]).T
    for pose, (x, y, _) in enumerate(POSES.positions):
        # The object as the erring sensor sees it, put back into the world by the stated sensor pose.
        away_x, away_y = x - AT.x - ex, y - AT.y - ey
        seen_x = AT.x + np.cos(turned) * away_x + np.sin(turned) * away_y
        seen_y = AT.y - np.sin(turned) * away_x + np.cos(turned) * away_y
        sample = own + np.column_stack([seen_x - x, seen_y - y, -turned])
        expected = covariances(POSES, AT, spread, std)[pose]
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(np.cov(sample.T) / scale, expected / scale, rtol=0, atol=0.02)


def test_an_uncertain_sensor_needs_to_know_where_the_poses_are() -> None:
    with pytest.raises(NoMesh, match="an uncertain sensor pose needs their positions"):
        covariances(PoseSet.named(["A"]), AT, None, SensorUncertainty(0.01, 0.0))


@pytest.mark.parametrize(
    ("xy_m", "yaw_rad", "poses", "count"),
    [
        (0.0, 0.0, 3, 1),
        (0.005, 0.05, 3, 64),
        (0.02, math.radians(6.0), 3, 64),
        (0.0201, 0.0, 3, 256),
        (0.0, math.radians(6.1), 3, 256),
        (0.005, 0.0, 20_000, 64),
        (0.005, 0.0, 20_313, 32),
        (0.03, 0.0, 20_000, 64),
        (0.03, 0.0, 200_000, 16),
    ],
)
def test_the_number_of_copies(xy_m: float, yaw_rad: float, poses: int, count: int) -> None:
    covariance = np.repeat(np.diag([xy_m**2, xy_m**2, yaw_rad**2])[None], poses, axis=0)
    assert displacement_count(covariance) == count


def test_one_uncertain_pose_gives_every_pose_more_copies() -> None:
    covariance = np.repeat(np.diag([1e-4, 1e-4, 0.0])[None], 3, axis=0)
    covariance[1, 1, 1] = 9e-4
    assert displacement_count(covariance) == 256


def test_points_are_standard_normal_nested_and_named() -> None:
    points = standard_normal_points(1024, "scenario")
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=0.01)
    np.testing.assert_allclose(np.cov(points.T), np.eye(3), atol=0.03)
    assert np.isfinite(points).all()
    np.testing.assert_array_equal(standard_normal_points(64, "scenario"), points[:64])
    assert not np.isclose(standard_normal_points(64, "scenario", "simulation"), points[:64]).any()
    assert not np.isclose(standard_normal_points(64, "other"), points[:64]).any()
    assert standard_normal_points(1, "scenario").tolist() == [[0.0, 0.0, 0.0]]


@pytest.mark.parametrize("count", [0, 3, 65])
def test_another_number_of_points_than_a_power_of_two_is_refused(count: int) -> None:
    with pytest.raises(InvalidInput, match="count: expected a power of two"):
        standard_normal_points(count, "scenario")


@pytest.mark.parametrize(
    ("spread", "std"),
    [
        (Spread(0.01, 0.05), None),
        (Spread(0.01, 0.0), SensorUncertainty(0.02, 0.03)),
        (None, SensorUncertainty(0.0, 0.03)),
        (None, SensorUncertainty(0.02, 0.0)),
        (Spread(0.0, 0.05), None),
    ],
)
def test_roots_are_lower_triangular_even_of_singular_covariances(
    spread: Spread | None, std: SensorUncertainty | None
) -> None:
    covariance = covariances(POSES, AT, spread, std)
    roots = lower_roots(covariance)
    assert not np.triu(roots, 1).any()
    np.testing.assert_allclose(roots @ roots.transpose(0, 2, 1), covariance, rtol=0, atol=1e-18)
    points = standard_normal_points(64, "scenario")
    displacements = scaled(points, covariance)
    assert displacements.shape == (3, 64, 3)
    np.testing.assert_allclose(displacements[1], points @ roots[1].T, rtol=0, atol=1e-15)


def test_displaced_predictions_are_those_of_poses_that_lie_there(monkeypatch: pytest.MonkeyPatch) -> None:
    predictor = predictor_of_mesh(CUBE, POSES, LIDAR)
    displacements = scaled(standard_normal_points(4, "s"), covariances(POSES, AT, Spread(0.02, 0.2), None))
    whole = predictor.predict_displaced(AT, displacements)
    assert whole.ranges.shape[0] == 12
    for pose in range(3):
        for copy in range(4):
            elsewhere = moved(POSES, *displacements[pose, copy])
            expected = predictor_of_mesh(CUBE, elsewhere, LIDAR).predict(AT).dense()[pose]
            np.testing.assert_allclose(whole.dense()[4 * pose + copy], expected, rtol=0, atol=1e-9)
    part = predictor.predict_displaced(AT, displacements[1:2], first=1)
    np.testing.assert_array_equal(part.dense(), whole.dense()[4:8])
    monkeypatch.setattr(prediction, "_NUMBERS_AT_ONCE", 1)
    in_parts = predictor.predict_displaced(AT, displacements)
    np.testing.assert_array_equal(in_parts.columns, whole.columns)
    np.testing.assert_array_equal(in_parts.ranges, whole.ranges)


def test_a_copy_that_is_not_displaced_is_predicted_as_the_pose_itself() -> None:
    predictor = predictor_of_mesh(CUBE, POSES, LIDAR)
    for grid in (None, BeamGrid(7, -0.2, 0.061)):
        still = predictor.predict_displaced(AT, np.zeros((3, 1, 3)), grid)
        np.testing.assert_array_equal(still.dense(), predictor.predict(AT, grid).dense())


def test_displaced_predictions_need_a_mesh() -> None:
    with pytest.raises(NoMesh):
        data_predictor(np.ones((2, 8)), lidar_of()).predict_displaced(AT, np.zeros((2, 1, 3)))


@pytest.mark.parametrize(
    ("values", "message"),
    [((-0.1, 0.0), "xy_m"), ((0.0, math.inf), "yaw_rad"), ((0.0, 0.0), "spread: expected xy_m or yaw_rad above 0")],
)
def test_a_spread_that_is_none_is_refused(values: Any, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Spread(*values)


def test_displaced_predictions_are_remembered_by_all_that_they_depend_on() -> None:
    keys: list[object] = []

    def remember(key: Hashable, make: Callable[[], Any]) -> Any:
        keys.append(key)
        return make()

    predictor = replace(predictor_of_mesh(CUBE, POSES, LIDAR), remember=remember)
    own, other = LIDAR.grid, BeamGrid(7, -0.2, 0.061)
    whole = np.zeros((3, 2, 3))

    def predict() -> DisplacedScans:
        return predict_copies(predictor, AT, whole)

    assert len(predict()) == 3
    assert keys == []
    for sensor in (AT, replace(AT, x=0.1), replace(AT, y=0.1), replace(AT, yaw_rad=0.1), replace(AT, height_m=0.05)):
        assert len(remembered_copies(predictor, sensor, own, "a", predict)) == 3
    remembered_copies(predictor, AT, other, "a", predict)
    remembered_copies(predictor, AT, own, "b", predict)
    assert len(set(keys)) == 7
    remembered_copies(predictor, replace(AT, name="other", cost=1.0), replace(own), "a", predict)
    assert len(set(keys)) == 7


@pytest.mark.parametrize("listed", [True, False])
def test_copies_at_listed_sensors_alone_are_remembered(listed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    kept: dict[Hashable, Any] = {}

    def remember(key: Hashable, make: Callable[[], Any]) -> Any:
        return kept.setdefault(key, make()) if key not in kept else kept[key]

    predictor = replace(predictor_of_mesh(CUBE, POSES, LIDAR), remember=remember)
    scan = Scan(predictor.predict(AT).dense()[0], LIDAR.grid)
    kept.clear()
    monkeypatch.setattr(evidence, "_NUMBERS_AT_ONCE", 2 * 16 * LIDAR.grid.beams)  # two poses a block
    displacements = Displacements(16, Spread(0.01, 0.05), None, "test")

    def compare(displacements: Displacements) -> Any:
        return evidence.evidence_of_scan(
            scan, AT, predictor, rule_of("beam", LIDAR), displacements=displacements, listed=listed
        ).log_copies

    first = compare(displacements)
    blocks = -(-len(POSES) // 2) if listed else 0
    assert len(kept) == blocks
    np.testing.assert_array_equal(compare(displacements), first)
    assert len(kept) == blocks
    assert np.abs(compare(replace(displacements, seed="other")) - first).max() > 0.0
    assert len(kept) == 2 * blocks


def test_displacements_have_as_many_copies_as_the_look_or_its_place_needs() -> None:
    spread, wide = Spread(0.01, 0.05), SensorUncertainty(0.03, 0.0)
    assert Displacements.of(POSES, AT, None, None, "s", 256).copies == 1
    assert Displacements.of(POSES, AT, spread, None, "s").copies == 64
    assert Displacements.of(POSES, AT, spread, None, "s", 256).copies == 256
    assert Displacements.of(POSES, AT, spread, wide, "s", 64).copies == 256
    few, many = (Displacements(count, spread, wide, "s").at(POSES, AT) for count in (4, 8))
    np.testing.assert_allclose(few, many[:, :4], rtol=0, atol=1e-15)
