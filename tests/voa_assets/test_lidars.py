"""The lidar presets: complete, loadable, and `lds-01` as the contract fixes it."""

import math
from typing import Any

import pytest

from tests.voa_assets.mugs import lidar_of
from voa_assets import lidar_presets, path
from voa_ros.cdr import MOST_BEAMS

NAMES = sorted(file.stem for file in path("lidars").glob("*.json"))
FIELDS = {
    "name": str,
    "title": str,
    "beams": int,
    "angle_min": float,
    "angle_increment": float,
    "range_min": float,
    "range_max": float,
    "zero": str,
    "noise_m": float,
    "noise_ratio": float,
    "dropout": float,
    "source": str,
}


PROMISED = {
    "hokuyo-urg-04lx",
    "hokuyo-ust-10lx",
    "ld19",
    "lds-01",
    "lds-02",
    "rplidar-a1",
    "rplidar-a2",
    "rplidar-c1",
    "rplidar-s2",
    "sick-picoscan150",
    "sick-tim561",
    "sick-tim571",
    "ydlidar-tg15",
    "ydlidar-x4",
}
NOISE_M = {
    "ld19": math.hypot(0.045 / 2.0, 0.010),
    "rplidar-a2": 0.005 * 1.5,
    "rplidar-c1": 0.030 / 2.0,
    "rplidar-s2": 0.030 / 2.0,
    "sick-picoscan150": math.hypot(0.030 / 2.0, 0.010),
    "sick-tim571": math.hypot(0.060 / 2.0, 0.020),
    "ydlidar-tg15": 0.060 / 2.0,
    "ydlidar-x4": 0.020 / 2.0,
}
"""Noise that follows from the errors in the presets' sources."""
NOMINAL = {
    "ld19": 4500.0 / 10.0,
    "rplidar-a2": 8000.0 / 10.0,
    "rplidar-c1": 5000.0 / 10.0,
    "rplidar-s2": 32000.0 / 10.0,
    "ydlidar-tg15": 20000.0 / 10.0,
    "ydlidar-x4": 5000.0 / 7.0,
}
"""Beams of a whole turn: measurements a second by revolutions a second."""
FROM_TO_DEG = {
    "hokuyo-urg-04lx": (-119.53, 119.88),
    "hokuyo-ust-10lx": (-135.0, 135.0),
    "sick-picoscan150": (-138.0, 138.0),
    "sick-tim561": (-135.0, 134.97),
    "sick-tim571": (-135.0, 134.97),
}


def preset_of(name: str) -> dict[str, Any]:
    return lidar_presets()[name]


def test_presets_are_listed_by_the_names_of_their_files() -> None:
    assert list(lidar_presets()) == NAMES
    assert set(NAMES) == PROMISED, "a preset that is added goes into PROMISED, too"


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_complete(name: str) -> None:
    preset = preset_of(name)
    assert preset["name"] == name
    assert {field: type(value) for field, value in preset.items()} == FIELDS
    assert "datasheet" in preset["source"]


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_a_lidar_that_turns_counter_clockwise_and_at_most_once(name: str) -> None:
    lidar = lidar_of(preset_of(name))
    assert lidar.grid.angle_increment > 0.0
    assert lidar.grid.angle_increment * lidar.grid.beams < 2.0 * math.pi + 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_a_lidar_that_a_scenario_may_have(name: str) -> None:
    preset = preset_of(name)
    assert 0.0 < preset["range_min"] < preset["range_max"]
    assert preset["beams"] <= MOST_BEAMS
    assert 0.0 <= preset["dropout"] < 0.5


@pytest.mark.parametrize("name", NAMES)
def test_what_no_document_gives_is_called_an_assumption(name: str) -> None:
    source = preset_of(name)["source"]
    assert "dropout is an assumption" in source or "dropout is measured" in source


@pytest.mark.parametrize("name", sorted(NOISE_M))
def test_the_noise_follows_from_the_errors_in_the_source(name: str) -> None:
    assert preset_of(name)["noise_m"] == pytest.approx(NOISE_M[name], abs=5e-4)


@pytest.mark.parametrize("name", sorted(NOMINAL))
def test_a_turn_has_the_nominal_beams(name: str) -> None:
    preset = preset_of(name)
    assert preset["beams"] == pytest.approx(NOMINAL[name], rel=0.01)
    assert preset["beams"] * preset["angle_increment"] == pytest.approx(2.0 * math.pi)


@pytest.mark.parametrize("name", sorted(FROM_TO_DEG))
def test_part_of_a_turn_is_from_its_first_to_its_last_angle(name: str) -> None:
    preset = preset_of(name)
    last = preset["angle_min"] + (preset["beams"] - 1) * preset["angle_increment"]
    first_and_last = [math.degrees(preset["angle_min"]), math.degrees(last)]
    assert first_and_last == pytest.approx(list(FROM_TO_DEG[name]), abs=0.01)


def test_lds_01_is_as_the_contract_says() -> None:
    preset = preset_of("lds-01")
    del preset["title"], preset["source"]
    assert preset == {
        "name": "lds-01",
        "beams": 360,
        "angle_min": 0.0,
        "angle_increment": 2.0 * math.pi / 360,
        "range_min": 0.12,
        "range_max": 3.5,
        "zero": "missing",
        "noise_m": 0.009,
        "noise_ratio": 0.03,
        "dropout": 0.1,
    }


def test_the_noise_of_lds_01_follows_from_its_datasheet() -> None:
    preset = preset_of("lds-01")
    assert preset["noise_m"] == pytest.approx(math.hypot(0.015, 0.010) / 2.0, abs=5e-4)
    assert preset["noise_ratio"] == pytest.approx(math.hypot(0.05, 0.035) / 2.0, abs=1e-3)
