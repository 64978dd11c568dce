"""The recorded mug: the core computes what the twin wrote into expected.json, from files alone."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support import make_recorded_mug as maker
from tests.voa_assets.mugs import lidar_of, object_of
from voa_assets import lidar_presets, path
from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, best_grasp
from voa_core.lidars import SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.recorded import scenario_of_recorded, value_recorded_looks
from voa_core.rules.registry import rule_of
from voa_core.scenario import Scenario

FOLDER = path("experiments/mug")
EXPERIMENT: dict[str, Any] = json.loads((FOLDER / "experiment.json").read_text(encoding="utf-8"))
EXPECTED: dict[str, Any] = json.loads((FOLDER / "expected.json").read_text(encoding="utf-8"))
LIDAR = lidar_of(lidar_presets()["lds-01"])
POSES = [pose["name"] for pose in EXPERIMENT["poses"]]
SENSORS = [
    SensorConfiguration(sensor["name"], sensor["x"], sensor["y"], math.radians(sensor["yaw_deg"]))
    for sensor in EXPERIMENT["sensors"]
]
TABLE = GraspTable.of_successes(
    EXPERIMENT["grasps"],
    [[EXPERIMENT["successes"][grasp][pose] for pose in POSES] for grasp in EXPERIMENT["grasps"]],
    EXPERIMENT["attempts"],
    len(POSES),
)


def column(folder: Path, name: str) -> dict[str, Floats]:
    """The ranges of one column of scans.csv by sensor, (poses, beams); inf where there is none."""
    ranges = {sensor.name: np.full((len(POSES), LIDAR.grid.beams), np.inf) for sensor in SENSORS}
    with (folder / "scans.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row[name]:
                ranges[row["sensor"]][POSES.index(row["pose"]), int(row["angle_deg"])] = float(row[name])
    return ranges


def scenario_by(rule: str) -> Scenario:
    own = rule_of(rule, LIDAR, no_return_m=EXPERIMENT["observation"]["no_return"])
    return scenario_of_recorded(POSES, TABLE, LIDAR, own, column(FOLDER, "predicted"))


def test_the_best_grasp_before_is_the_expected_one() -> None:
    choice = best_grasp(TABLE, Belief.uniform(len(POSES)).p)
    assert choice.index is not None
    assert TABLE.names[choice.index] == EXPECTED["before"]["best_grasp"]
    assert choice.expected_score == pytest.approx(EXPECTED["before"]["expected_score"], abs=1e-6)


@pytest.mark.parametrize("rule", list(maker.RULES))
def test_the_core_agrees_with_expected_json(rule: str) -> None:
    values = value_recorded_looks(scenario_by(rule), column(FOLDER, "measured"))
    assert list(values) == [sensor.name for sensor in SENSORS]
    for sensor, value in values.items():
        expected = EXPECTED["rules"][rule][sensor]
        assert value.voa == pytest.approx(expected["voa"], abs=1e-6)
        assert value.aecd == pytest.approx(expected["aecd"], abs=1e-6)
        for pose, done in zip(POSES, value.updates, strict=True):
            shares = [expected["belief_after_measured_scan"][pose][other] for other in POSES]
            np.testing.assert_allclose(done.belief.p, shares, rtol=0.0, atol=1e-6)


def test_every_rule_and_sensor_is_expected() -> None:
    assert list(EXPECTED["rules"]) == list(maker.RULES)
    assert all(list(values) == [sensor.name for sensor in SENSORS] for values in EXPECTED["rules"].values())


def test_the_predictions_are_those_of_the_mesh() -> None:
    poses = PoseSet.from_arrays(
        POSES, *([pose[field] for pose in EXPERIMENT["poses"]] for field in ("position", "quaternion_wxyz"))
    )
    mesh = object_of(FOLDER / EXPERIMENT["object"]["mesh"])
    predictor = predictor_of_mesh(mesh, poses, lidar_of(lidar_presets()["lds-01"], 0.05))
    for sensor in SENSORS:
        np.testing.assert_allclose(
            predictor.predict(sensor).dense(), column(FOLDER, "predicted")[sensor.name], rtol=0.0, atol=1e-8
        )


def test_the_scans_have_the_faults_that_the_readme_names() -> None:
    predicted, measured = (np.concatenate(list(column(FOLDER, name).values())) for name in ("predicted", "measured"))
    both = np.isfinite(predicted) & np.isfinite(measured)
    apart = np.abs(np.where(both, measured, 0.0) - np.where(both, predicted, 0.0))[both]
    assert 0.001 < np.median(apart) < 0.003
    assert apart.max() > 0.03
    assert (np.isfinite(predicted) & np.isinf(measured)).sum() >= 5
    assert (np.isinf(predicted) & np.isfinite(measured)).sum() >= 5


def test_the_maker_makes_the_folder_that_is_shipped(tmp_path: Path) -> None:
    maker.write(maker.record(path("mug")), path("mug/mug.obj"), tmp_path)
    for name in ("experiment.json", "mug.obj"):
        assert (tmp_path / name).read_bytes() == (FOLDER / name).read_bytes()
    for name in ("measured", "predicted"):
        again, shipped = column(tmp_path, name), column(FOLDER, name)
        for sensor in SENSORS:
            np.testing.assert_allclose(again[sensor.name], shipped[sensor.name], rtol=0.0, atol=1e-8)
    assert (
        json.loads((tmp_path / "expected.json").read_text(encoding="utf-8"))["rules"].keys() == EXPECTED["rules"].keys()
    )
