"""Lidars from messages: own fields win over the preset's, and a lidar without a preset needs all of its fields."""

import pytest

from tests.support.serving import LIDAR
from voa_assets import lidar_presets
from voa_core.errors import InvalidInput, UnknownName
from voa_core.lidars import BeamGrid
from voa_msgs.lidars import Lidar, LidarPreset
from voa_service.mapping.lidars import filled_lidar, lidar_model

PRESETS = {name: LidarPreset.model_validate(preset) for name, preset in lidar_presets().items()}


def test_a_preset_fills_in_what_the_message_omits() -> None:
    filled = filled_lidar(Lidar(preset="lds-01", range_max=1.25), PRESETS)
    preset = PRESETS["lds-01"]
    assert (filled.preset, filled.range_max, filled.height_m) == ("lds-01", 1.25, None)
    assert (filled.beams, filled.range_min, filled.zero) == (preset.beams, preset.range_min, preset.zero)
    assert (filled.noise_m, filled.noise_ratio, filled.dropout) == (preset.noise_m, preset.noise_ratio, preset.dropout)


def test_a_lidar_without_a_preset_gets_the_usual_noise() -> None:
    filled = filled_lidar(Lidar.model_validate(LIDAR | {"dropout": 0.25}), {})
    assert (filled.noise_m, filled.noise_ratio, filled.dropout) == (0.01, 0.02, 0.25)


def test_a_lidar_without_a_preset_that_lacks_fields_is_refused_with_their_names() -> None:
    with pytest.raises(InvalidInput, match=r"a preset \(.*lds-01.*\) or all of its fields, got no range_max, zero"):
        filled_lidar(Lidar(beams=4, angle_min=0.0, angle_increment=0.1, range_min=0.1), PRESETS)


def test_an_unknown_preset_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName) as refused:
        filled_lidar(Lidar(preset="lds-99"), PRESETS)
    assert refused.value.known == sorted(PRESETS)


def test_the_model_has_every_number_of_the_message() -> None:
    model = lidar_model(filled_lidar(Lidar.model_validate(LIDAR | {"height_m": 0.2}), {}))
    assert model.grid == BeamGrid(4, 0.0, 0.1)
    assert (model.range_min, model.range_max, model.height_m, model.zero) == (0.1, 2.0, 0.2, "missing")


def test_range_limits_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(InvalidInput, match="range_max"):
        lidar_model(filled_lidar(Lidar.model_validate(LIDAR | {"range_max": 0.05}), {}))
