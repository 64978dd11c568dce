"""A scan that no pose explains says why: mirrored, turned, in millimetres, or simply not the object."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.mistakes.table import LIDAR, WEST, poses_at, scenario_of
from voa_core.checks import Floats
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.mistakes.mistake import Mistake
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor
from voa_core.scans import Scan
from voa_core.scenario import Scenario

PRECISE = LidarModel(**(vars(LIDAR) | {"noise_m": 0.002, "noise_ratio": 0.0}))
SCENARIO = scenario_of(lidar=PRECISE, poses=poses_at((0.04, 0.03, 0.0, 0.0), (-0.05, 0.05, 0.0, 120.0)))


def measured(pose: int = 0, sensor: SensorConfiguration = WEST, scenario: Scenario = SCENARIO) -> Floats:
    ranges: Floats = scenario.predictor.predict(sensor).dense()[pose].copy()
    return ranges


def mistakes_of(
    ranges: Floats,
    scenario: Scenario = SCENARIO,
    std: SensorUncertainty | None = None,
    sensor: SensorConfiguration = WEST,
    **changed: Any,
) -> dict[str, Mistake]:
    scan = Scan(ranges, changed.pop("grid", scenario.lidar.grid), **changed)
    evidence = scenario.evidence(scan, sensor, std)
    return {mistake.kind: mistake for mistake in mistakes_of_scan(scenario, scan, sensor, std, evidence)}


def test_a_scan_that_fits_says_nothing() -> None:
    noisy = measured() + np.random.default_rng(1).normal(0.0, 0.004, 360)
    assert mistakes_of(measured()) == {}
    assert mistakes_of(noisy) == {}


def test_a_scan_of_nothing_but_missing_beams_says_nothing() -> None:
    assert mistakes_of(np.full(360, math.nan)) == {}


def test_a_dead_lidar_is_no_wrong_yaw() -> None:
    assert mistakes_of(np.full(360, math.inf)) == {}


def test_another_object_fits_poorly() -> None:
    mistakes = mistakes_of(measured() + 0.03)
    assert set(mistakes) == {"poor-fit"}
    assert "P0" in mistakes["poor-fit"].poses
    assert "30.0 mm off" in mistakes["poor-fit"].detail
    assert mistakes_of(measured() + 0.009) == {}


def test_a_lidar_that_is_not_known_to_stand_still_may_be_off_by_as_much() -> None:
    assert mistakes_of(measured() + 0.03, std=SensorUncertainty(0.01, 0.0)) == {}


def test_a_driver_that_turns_the_other_way_round_is_named() -> None:
    mirrored = measured()[-np.arange(360)]
    assert mistakes_of(mirrored)["scan-mirrored"].poses == ("P0",)
    half = BeamGrid(181, -math.pi / 3, math.radians(1.0))
    scan = SCENARIO.predictor.predict(WEST, BeamGrid(181, math.pi / 3, -math.radians(1.0))).dense()[0]
    assert set(mistakes_of(scan, grid=half)) >= {"scan-mirrored"}


@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_a_yaw_that_is_off_by_quarters_of_a_turn_is_named(degrees: int) -> None:
    said = replace(WEST, name="said", yaw_rad=WEST.yaw_rad - math.radians(degrees))
    mistake = mistakes_of(measured(), sensor=said)["scan-turned"]
    assert f"{degrees} degrees more" in mistake.detail
    assert mistake.poses == ("P0",)


def test_ranges_in_millimetres_are_named() -> None:
    mistakes = mistakes_of(1000.0 * measured())
    assert set(mistakes) == {"length-in-millimetres"}
    # Two ranges are too few to tell, and a wall beyond the limit is none.
    few = np.full(360, math.inf)
    few[:2] = 400.0
    assert mistakes_of(few) == {}
    assert mistakes_of(np.full(360, 6.0)) == {}


def test_other_readings_need_a_mesh_and_a_height() -> None:
    data = ObservationPredictor(PoseSet.named(["P0", "P1"]), PRECISE, {"W": SCENARIO.predictor.predict(WEST).dense()})
    scenario = replace(SCENARIO, poses=data.poses, predictor=data)
    assert set(mistakes_of(np.roll(measured(), 90), scenario)) == set()
    assert set(mistakes_of(measured() + 0.03, scenario)) == {"poor-fit"}


def test_a_pose_that_is_hardly_seen_fits_whatever_is_not_seen() -> None:
    far = scenario_of(lidar=PRECISE, poses=poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, -0.05, 0.0)))
    assert mistakes_of(np.full(360, math.inf), far) == {}


def test_a_sensor_pose_in_degrees_or_in_millimetres_is_named() -> None:
    degrees = replace(WEST, name="said", yaw_rad=360.0)
    assert "360 degrees are 6.283 rad" in mistakes_of(measured(), sensor=degrees)["angle-in-degrees"].detail
    far = mistakes_of(measured(), sensor=replace(WEST, name="said", y=500.0))
    assert set(far) == {"length-in-millimetres", "place-sees-nothing"}
    # The scenario's own places are looked at with the scenario.
    assert mistakes_of(measured(), sensor=WEST) == {}


def test_walls_hide_no_wrong_yaw_where_there_is_no_workspace() -> None:
    open_table = replace(SCENARIO, workspace=None)
    said = replace(WEST, name="said", yaw_rad=WEST.yaw_rad - math.radians(90))
    walls = np.minimum(measured(), 2.0)
    assert "90 degrees more" in mistakes_of(walls, open_table, sensor=said)["scan-turned"].detail


def test_few_hits_that_fit_are_no_good_fit_and_need_another_explanation() -> None:
    few = measured()
    hit = np.flatnonzero(np.isfinite(few))
    few[hit[len(hit) // 3 + 1 :]] = math.inf
    assert mistakes_of(few) == {}


def test_noise_below_a_millimetre_is_not_held_against_a_scan() -> None:
    exact = scenario_of(lidar=LidarModel(**(vars(LIDAR) | {"noise_m": 1e-9, "noise_ratio": 0.0})))
    rounded = exact.predictor.predict(WEST).dense()[0].astype(np.float32).astype(np.float64)
    assert mistakes_of(rounded, exact) == {}


def test_a_driver_that_is_all_in_millimetres_is_named_and_a_wall_beyond_the_limit_is_not() -> None:
    assert "length-in-millimetres" in mistakes_of(1000.0 * measured(), range_min=120.0, range_max=3500.0)
    short = scenario_of(lidar=LidarModel(**(vars(PRECISE) | {"range_min": 0.0, "range_max": 1.5})))
    assert "length-in-millimetres" not in mistakes_of(np.full(360, 4.0), short)
