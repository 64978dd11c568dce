import json
from pathlib import Path

import numpy as np
import pytest

from tests.voa_setup.calibration.calibrations import bracket, scene_of
from voa_assets import path as asset
from voa_core.lidars import LidarModel, SensorConfiguration
from voa_core.prediction import predictor_of_mesh
from voa_setup.calibration.known_object import InvalidCalibration, read_scene


def test_many_predictions_equal_those_of_the_core_one_by_one() -> None:
    scene = scene_of(bracket())
    target = scene.at("as made", None)
    lidars = np.array([[0.4, 0.1, 3.0], [-0.2, -0.4, 0.7], [0.1, 0.5, -1.0]])
    model = LidarModel(scene.grid, 0.0, 3.5, 0.05, "missing", 1e-3, 0.0, 0.0)
    predictor = predictor_of_mesh(scene.mesh, scene.poses, model)
    for ranges, (x, y, yaw) in zip(target.ranges(lidars, scene.grid, 3.5), lidars, strict=True):
        expected = predictor.predict(SensorConfiguration("lidar", x, y, yaw)).dense()[0]
        assert np.isfinite(expected).sum() > 5
        np.testing.assert_allclose(ranges, expected, atol=1e-9)


def test_a_scenario_file_is_read_with_the_preset_of_its_lidar() -> None:
    scene = read_scene(asset("mug/scenario.json"))
    assert (scene.grid.beams, scene.range_max, scene.height_m) == (360, 3.5, 0.05)
    assert scene.at("U_90", None).radius_m == pytest.approx(0.056, abs=0.002)


@pytest.mark.parametrize(
    ("pose", "height_m", "says"),
    [("U_0", 0.5, "misses the object"), ("upright", None, "no pose 'upright'; it has U_0")],
)
def test_what_cannot_be_cut_is_named(pose: str, height_m: float | None, says: str) -> None:
    with pytest.raises(InvalidCalibration, match=says):
        read_scene(asset("mug/scenario.json")).at(pose, height_m)


def test_a_scenario_without_its_mesh_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scenario.json"
    file.write_text(json.dumps(json.loads(asset("mug/scenario.json").read_text()) | {"object": "other.obj"}))
    with pytest.raises(InvalidCalibration, match="expected the name of a mesh file"):
        read_scene(file)


def test_a_mesh_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    file = tmp_path / "scenario.json"
    file.write_text(asset("mug/scenario.json").read_text())
    (tmp_path / "mug.obj").write_text("no mesh")
    with pytest.raises(InvalidCalibration, match=r"mug\.obj holds no triangles"):
        read_scene(file)
