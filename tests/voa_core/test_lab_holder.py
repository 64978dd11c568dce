"""The lab's HOLDER data: predictions, VOA, executed values and beliefs of the authors' own program, reproduced."""

import csv
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from voa_core.assistance import executed_value
from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, predictor_of_mesh
from voa_core.ranking import rank
from voa_core.rules.registry import rule_of
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy, update

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

    def scenario(self, rule: str) -> Scenario:
        data = {
            sensor.name: np.array([self.column("predicted", sensor.name, pose) for pose in self.poses.names])
            for sensor in self.sensors
        }
        return Scenario(
            PoseSet.named(self.poses.names),
            self.table,
            self.sensors,
            ObservationPredictor(PoseSet.named(self.poses.names), self.lidar, data),
            rule_of(rule, self.lidar, no_return_m=1.0),
            UpdatePolicy("nearest"),
            Belief.uniform(len(self.poses)),
        )

    def belief_after(self, scenario: Scenario, sensor: SensorConfiguration, pose: str) -> Belief:
        """After the measured scan, as the replay sends it: range_min 0, unmeasured beams declared."""
        measured = self.column("measured", sensor.name, pose)
        silent = tuple(int(beam) for beam in np.flatnonzero(np.isinf(measured)))
        scan = Scan(measured, self.lidar.grid, silent, range_min=0.0)
        told = update(scenario.prior, scenario.evidence(scan, sensor), scenario.policy)
        assert told.accepted
        return told.belief


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


def test_before_any_look_the_best_grasp_is_the_authors(lab: Lab) -> None:
    scenario = lab.scenario("exponential")
    before = rank(
        scenario.sensors,
        lambda s: scenario.weigher(s, np.float64, keep=True),
        scenario.prior,
        scenario.table,
        scenario.policy,
    ).before
    assert before.index is not None
    assert lab.table.names[before.index] == lab.expected["before"]["best_grasp"]
    assert before.expected_score == pytest.approx(lab.expected["before"]["expected_score"], abs=1e-6)


@pytest.mark.parametrize("rule", RULES_REPORTED)
def test_voa_is_the_authors(lab: Lab, rule: str) -> None:
    scenario = lab.scenario(rule)
    looks = rank(
        scenario.sensors,
        lambda s: scenario.weigher(s, np.float64, keep=True),
        scenario.prior,
        scenario.table,
        scenario.policy,
    ).looks
    found = {look.sensor.name: look.assistance.voa for look in looks}
    expected = {name: answers["voa"] for name, answers in lab.expected["rules"][rule].items()}
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("rule", RULES_REPORTED)
def test_executed_values_and_beliefs_are_the_authors(lab: Lab, rule: str) -> None:
    scenario = lab.scenario(rule)
    for sensor in lab.sensors:
        expected = lab.expected["rules"][rule][sensor.name]
        after = [lab.belief_after(scenario, sensor, pose) for pose in lab.poses.names]
        for pose, belief in zip(lab.poses.names, after, strict=True):
            theirs = expected["belief_after_measured_scan"][pose]
            found = dict(zip(lab.poses.names, belief.p.tolist(), strict=True))
            assert found == pytest.approx(theirs, abs=1e-6), (rule, sensor.name, pose)
        assert executed_value(scenario.prior, after, scenario.table) == pytest.approx(expected["aecd"], abs=1e-6)


def test_margin_alone_refuses_21_of_the_24_scans(lab: Lab) -> None:
    scenario = lab.scenario("margin")
    refused = 0
    for sensor in lab.sensors:
        for pose in lab.poses.names:
            scan = Scan(lab.column("measured", sensor.name, pose), lab.lidar.grid, range_min=0.0)
            told = update(scenario.prior, scenario.evidence(scan, sensor), UpdatePolicy("reject"))
            refused += told.reason == "no_match"
    assert refused == 21


def _read_obj(path: Path) -> Object:
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        kind, *fields = line.split() or [""]
        if kind == "v":
            vertices.append([float(value) for value in fields[:3]])
        elif kind == "f":
            faces.append([int(field.split("/")[0]) - 1 for field in fields])
    return Object.from_arrays(vertices, faces)
