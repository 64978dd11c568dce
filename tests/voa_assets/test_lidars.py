"""The lidar presets: complete, loadable, and `lds-01` as the contract fixes it."""

import math
from typing import Any

import pytest

from tests.voa_assets.mugs import lidar_of
from voa_assets import lidar_presets, path

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


def preset_of(name: str) -> dict[str, Any]:
    return lidar_presets()[name]


def test_presets_are_listed_by_the_names_of_their_files() -> None:
    assert list(lidar_presets()) == NAMES
    assert {"lds-01", "lds-02"} < set(NAMES)


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
