"""The lab's HOLDER data: predictions, VOA, executed values and beliefs of the authors' own program, reproduced."""

import csv
import json
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.displacements import Spread
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.recorded import scenario_of_recorded, value_recorded_looks
from voa_core.rules.registry import defaults, rule_of
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy, update_estimate

REPOSITORY = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("VOA_LAB_HOLDER", REPOSITORY.parent / "shared" / "lab-holder"))
RULES_REPORTED = ["margin", "exponential", "gaussian"]

pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(), reason=f"the lab's data are not at {FOLDER}; VOA_LAB_HOLDER names another place"
)


class Lab:
    """The recorded experiment."""

    def __init__(self) -> None:
        self.experiment: dict[str, Any] = json.loads((FOLDER / "experiment.json").read_text())
        self.expected: dict[str, Any] = json.loads((FOLDER / "expected.json").read_text())
        with (FOLDER / "scans.csv").open() as file:
            self.rows = list(csv.DictReader(file))
        poses = self.experiment["poses"]
        self.poses = PoseSet.from_arrays(
            [pose["name"] for pose in poses],
            [pose["position"] for pose in poses],
            [pose["quaternion_wxyz"] for pose in poses],
        )
        self.sensors = tuple(
            SensorConfiguration(sensor["name"], sensor["x"], sensor["y"], math.radians(sensor["yaw_deg"]))
            for sensor in self.experiment["sensors"]
        )
        self.lidar = LidarModel(BeamGrid(360, 0.0, math.radians(1.0)), 0.12, 3.5, None, "missing", 0.01, 0.035, 0.05)
        grasps = self.experiment["grasps"]
        scores = [[self.experiment["scores"][g][p] for p in self.poses.names] for g in grasps]
        self.table = GraspTable.of_probabilities(grasps, scores, len(self.poses))

    def rows_of(self, sensor: str, pose: str) -> list[dict[str, str]]:
        return [row for row in self.rows if (row["sensor"], row["pose"]) == (sensor, pose)]

    def column(self, name: str, sensor: str, pose: str) -> Floats:
        """The beams of one scan, inf where there is no row."""
        ranges = np.full(360, np.inf)
        for row in self.rows_of(sensor, pose):
            ranges[int(row["angle_deg"])] = float(row[name])
        return ranges

    def ranges(self, name: str, sensor: str) -> Floats:
        """Return a column of the scans from a sensor, (poses, beams)."""
        return np.array([self.column(name, sensor, pose) for pose in self.poses.names])

    def scenario(self, rule: str) -> Scenario:
        predicted = {sensor.name: self.ranges("predicted", sensor.name) for sensor in self.sensors}
        own = rule_of(rule, self.lidar, no_return_m=1.0)
        return scenario_of_recorded(self.poses.names, self.table, self.lidar, own, predicted)

    def measured(self) -> dict[str, Floats]:
        return {sensor.name: self.ranges("measured", sensor.name) for sensor in self.sensors}


@pytest.fixture(scope="module")
def lab() -> Lab:
    return Lab()


def test_the_data_are_the_24_scans_that_the_text_describes(lab: Lab) -> None:
    assert len({(row["sensor"], row["pose"]) for row in lab.rows}) == 24
    assert len(lab.rows) == 507


def test_predictions_from_the_mesh_are_the_recorded_ones_on_every_listed_beam(lab: Lab) -> None:
    mesh = _read_obj(FOLDER / lab.experiment["object"]["mesh"])
    predictor = predictor_of_mesh(mesh, lab.poses, lab.lidar)
    compared, worst = 0, 0.0
    for sensor in lab.sensors:
        for index, pose in enumerate(lab.poses.names):
            rows = lab.rows_of(sensor.name, pose)
            (height,) = {float(row["plane_height"]) for row in rows}
            at = SensorConfiguration(sensor.name, sensor.x, sensor.y, sensor.yaw_rad, height)
            ranges = predictor.predict(at).dense()[index]
            for row in rows:
                compared += 1
                worst = max(worst, abs(float(ranges[int(row["angle_deg"])]) - float(row["predicted"])))
    assert compared == 507
    assert worst < 1e-6


def test_every_scan_is_recognised_under_a_spread_and_shows_the_object(lab: Lab) -> None:
    mesh = _read_obj(FOLDER / lab.experiment["object"]["mesh"])
    parameters = defaults("beam", lab.lidar, spread=True) | {"no_return_m": 1.0}
    scenario = Scenario(
        lab.poses,
        lab.table,
        (),
        predictor_of_mesh(mesh, lab.poses, lab.lidar),
        rule_of("beam", lab.lidar, **parameters),
        UpdatePolicy(),
        Belief.uniform(6),
        spread=Spread(0.005, math.radians(3.0)),
        seed="holder",
        absent=0.5,
    )
    for sensor in lab.sensors:
        for index, pose in enumerate(lab.poses.names):
            height = float(lab.rows_of(sensor.name, pose)[0]["plane_height"])
            scan = Scan.recorded(lab.column("measured", sensor.name, pose), lab.lidar)
            evidence = scenario.evidence(scan, replace(sensor, height_m=height))
            result = update_estimate(scenario.start, evidence, scenario.policy)
            assert result.accepted
            assert int(np.argmax(result.belief.p)) == evidence.best_fit == index
            assert result.estimate.absent is not None
            assert result.estimate.absent < 0.01


def test_before_any_look_the_best_grasp_is_the_authors(lab: Lab) -> None:
    before = lab.scenario("exponential").rank().before
    assert before.index is not None
    assert lab.table.names[before.index] == lab.expected["before"]["best_grasp"]
    assert before.expected_score == pytest.approx(lab.expected["before"]["expected_score"], abs=1e-6)


@pytest.mark.parametrize("rule", RULES_REPORTED)
def test_values_and_beliefs_are_the_authors(lab: Lab, rule: str) -> None:
    scenario = lab.scenario(rule)
    values = value_recorded_looks(scenario, lab.measured())
    assert list(values) == list(lab.expected["rules"][rule])
    for sensor, value in values.items():
        expected = lab.expected["rules"][rule][sensor]
        assert value.voa == pytest.approx(expected["voa"], abs=1e-6)
        assert value.aecd == pytest.approx(expected["aecd"], abs=1e-6)
        for pose, done in zip(lab.poses.names, value.updates, strict=True):
            assert done.accepted
            belief = dict(zip(lab.poses.names, done.belief.p.tolist(), strict=True))
            assert belief == pytest.approx(expected["belief_after_measured_scan"][pose], abs=1e-6), (rule, sensor, pose)
    ranked = {look.sensor.name: look.assistance.voa for look in scenario.rank().looks}
    assert ranked == pytest.approx({sensor: value.voa for sensor, value in values.items()}, abs=1e-12)


def test_margin_alone_refuses_21_of_the_24_scans(lab: Lab) -> None:
    scenario = replace(lab.scenario("margin"), policy=UpdatePolicy("reject"))
    values = value_recorded_looks(scenario, lab.measured())
    assert sum(done.reason == "no_match" for value in values.values() for done in value.updates) == 21


def _read_obj(path: Path) -> Object:
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        kind, *fields = line.split() or [""]
        if kind == "v":
            vertices.append([float(value) for value in fields[:3]])
        elif kind == "f":
            faces.append([int(field.split("/")[0]) - 1 for field in fields])
    return Object.from_arrays(vertices, faces)
