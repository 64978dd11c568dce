"""Calibrations of simulated recordings: errors within what is stated, the sign, and what a stop leaves open."""

import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.scale import scaled
from tests.support.standing_robots import bench_of, prism
from tests.voa_setup.calibration.calibrations import (
    bracket,
    calibrated,
    in_deviations,
    random_pose,
    random_stops,
    recorded_stops,
)
from voa_ros.motions import Motion
from voa_setup.calibration.known_object import InvalidCalibration
from voa_setup.calibration.planar import planar
from voa_setup.calibration.unknowns import Estimated

TRIALS = scaled(3, 30)
MOUNT, ORIGIN = Motion(-0.032, 0.01, 0.1), Motion(0.6, -0.3, 2.0)


@pytest.mark.parametrize("estimated", ["origin", "mount"])
def test_errors_are_within_three_stated_deviations(tmp_path: Path, estimated: Estimated) -> None:
    random = np.random.default_rng(11)
    bench = bracket()
    for _ in range(TRIALS):
        mount, origin = random_pose(random, 0.1), random_pose(random, 2.0)
        stops = recorded_stops(tmp_path, bench, random_stops(bench, mount, origin, 1, random), random)
        wrong = np.array([0.05, -0.03, 0.15])
        stated_origin = planar(origin) + (wrong if estimated == "origin" else 0.0)
        stated_mount = planar(mount) + (wrong if estimated == "mount" else 0.0)
        result = calibrated(stops, estimated, stated_origin, stated_mount)
        truth = origin if estimated == "origin" else mount
        assert (in_deviations(result, truth) <= 3.0).all()
        assert not result.best.undetermined
        assert result.best.std[2] < math.radians(3.0)


def test_an_upside_down_lidar_is_recognised(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    bench = bracket()
    for _ in range(scaled(2, 30)):
        standing = random_stops(bench, MOUNT, ORIGIN, 2, random)
        stops = recorded_stops(tmp_path, bench, standing, random, hangs=True)
        result = calibrated(stops, "mount", planar(ORIGIN), planar(MOUNT), within_m=0.25)
        assert result.best.upside_down
        assert result.sign_known
        assert (in_deviations(result, MOUNT) <= 3.0).all()


def test_more_stops_narrow_the_result(tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    bench = bracket()
    stops = recorded_stops(tmp_path, bench, random_stops(bench, MOUNT, ORIGIN, 4, random), random)
    one = calibrated(stops[:1], "origin", planar(ORIGIN), planar(MOUNT))
    four = calibrated(stops, "origin", planar(ORIGIN), planar(MOUNT))
    assert four.stops == 4
    assert (four.best.std < 0.7 * one.best.std).all()
    assert (in_deviations(four, ORIGIN) <= 3.0).all()


def round_prism(radius_m: float = 0.04) -> list[tuple[float, float]]:
    angles = np.linspace(0.0, 2.0 * math.pi, 90, endpoint=False)
    return [(radius_m * math.cos(angle), radius_m * math.sin(angle)) for angle in angles]


def test_the_side_from_which_a_can_is_seen_is_not_determined(tmp_path: Path) -> None:
    random = np.random.default_rng(6)
    bench = bench_of(prism(round_prism()))
    stops = recorded_stops(tmp_path, bench, random_stops(bench, MOUNT, ORIGIN, 1, random), random)
    result = calibrated(stops, "origin", planar(ORIGIN), planar(MOUNT))
    assert [each.coordinate for each in result.best.undetermined] == ["bearing"]
    assert not result.sign_known


def test_of_the_sides_of_a_box_the_stated_one_is_taken_and_the_others_are_listed(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    bench = bench_of(prism([(-0.06, -0.03), (0.06, -0.03), (0.06, 0.03), (-0.06, 0.03)]))
    stops = recorded_stops(tmp_path, bench, random_stops(bench, MOUNT, ORIGIN, 1, random), random)
    result = calibrated(stops, "origin", planar(ORIGIN), planar(MOUNT))
    assert (in_deviations(result, ORIGIN) <= 3.0).all()
    [opposite] = [each for each in result.others if each.upside_down == result.best.upside_down]
    assert math.cos(opposite.pose[2] - ORIGIN.yaw_rad) == pytest.approx(-1.0, abs=0.01)


def test_a_mount_far_from_what_is_stated_is_refused(tmp_path: Path) -> None:
    random = np.random.default_rng(8)
    bench = bracket()
    stops = recorded_stops(tmp_path, bench, random_stops(bench, MOUNT, ORIGIN, 2, random), random)
    with pytest.raises(InvalidCalibration, match="m from the stated mount"):
        calibrated(stops, "mount", planar(ORIGIN), planar(MOUNT) + np.array([0.3, 0.0, 0.0]), within_m=0.05)


def test_the_same_seed_gives_the_same_result(tmp_path: Path) -> None:
    random = np.random.default_rng(9)
    bench = bracket()
    stops = recorded_stops(tmp_path, bench, random_stops(bench, MOUNT, ORIGIN, 1, random), random)
    results = [calibrated(stops, "origin", planar(ORIGIN), planar(MOUNT)) for _ in range(2)]
    assert results[0].best.pose.tolist() == results[1].best.pose.tolist()
