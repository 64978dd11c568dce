"""Observations: a scan or an outcome is read from its message, and a scan is compared with every pose."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import PREDICTIONS, as_scan
from voa_core.displacements import Spread
from voa_core.errors import BeamGridMismatch, UnknownName
from voa_core.filtering import Belief
from voa_core.places import Viewpoint
from voa_core.rules.plugins import CheckedRule
from voa_msgs.looks import AtPlace
from voa_msgs.sessions import OutcomeRequest, ScanRequest, UpdateReport
from voa_service.mapping.observations import (
    accepted_scan,
    outcome_observation,
    received_scan,
    scan_observation,
    viewpoint_of,
)
from voa_store.records import HistoryEntry, HistoryKind, SessionState

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
UNIFORM = Belief.uniform(3)


def scan(pose: str, sensor: str = "Q1") -> ScanRequest:
    return ScanRequest.model_validate({"sensor": sensor, "scan": as_scan(PREDICTIONS[sensor][pose])})


def test_a_scan_like_a_prediction_favours_its_pose() -> None:
    observation = scan_observation(core_scenario(), scan("P2"))
    evidence = observation.evidence
    received = observation.received
    assert (received.listed, received.std, evidence.copies, evidence.best_fit) == (True, None, 1, 1)
    assert (evidence.fit_rmsd_mm, evidence.beams_compared) == (0.0, 4)
    distance = math.hypot(0.1, 0.5)  # P1 differs by 0.1 m, and by a return of 0.5 m where 1 m stands for none
    assert evidence.log_weights[1] - evidence.log_weights[0] == pytest.approx(distance)


def test_copies_that_are_all_alike_are_not_compared_again() -> None:
    observation = scan_observation(core_scenario(), scan("P2"))
    assert observation.with_copies(64) is observation


def test_a_scan_with_other_beams_is_refused() -> None:
    with pytest.raises(BeamGridMismatch, match="got 3 ranges"):
        scan_observation(core_scenario(), ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [0.5] * 3}}))


def test_only_few_ranges_at_a_listed_sensor_without_spread_are_compared_quickly() -> None:
    scenario, posed = core_scenario(), {"sensor_pose": {"x": 0.1, "y": 0.2, "yaw_rad": 0.3}}
    assert received_scan(scenario, scan("P2")).is_quick
    assert not received_scan(replace(scenario, spread=Spread(0.01, 0.0)), scan("P2")).is_quick
    assert not received_scan(scenario, ScanRequest.model_validate(posed | {"scan": as_scan([0.5] * 4)})).is_quick
    own = CheckedRule("own", scenario.rule, scenario.rule.no_return_m)
    assert not received_scan(replace(scenario, rule=own), scan("P2")).is_quick
    few = 2**18 // len(scenario.poses)
    for beams, quick in ((few, True), (few + 1, False)):
        grid = {"ranges": [0.5] * beams, "angle_min": 0.0, "angle_increment": 1e-5}
        assert received_scan(scenario, ScanRequest.model_validate({"sensor": "Q1", "scan": grid})).is_quick is quick


def test_a_scan_is_predicted_once_however_little_the_predictor_remembers() -> None:
    scenario, made = core_scenario(), []

    def remember(key: Any, make: Callable[[], Any]) -> Any:
        made.append(key)
        return make()

    forgetful = replace(scenario, predictor=replace(scenario.predictor, remember=remember))
    received = received_scan(forgetful, scan("P2")).predicted()
    assert len(made) == 1
    observation = received.observation(quickly=True)
    assert len(made) == 1
    assert (observation.evidence.log_copies == scan_observation(scenario, scan("P2")).evidence.log_copies).all()


@pytest.mark.parametrize(("poses", "quick"), [(1_000, True), (1_001, False)])
def test_a_scan_of_many_poses_is_not_compared_quickly(poses: int, quick: bool) -> None:
    names = [{"name": f"P{index}"} for index in range(poses)]
    data = {"Q1": {each["name"]: [0.5] * 4 for each in names}}
    sensors = [{"name": "Q1", "x": 0.0, "y": 0.0, "yaw_rad": 0.0}]
    scores = {"probabilities": [[0.5] * poses] * 2}
    scenario = core_scenario(poses=names, predictions=data, sensors=sensors, scores=scores)
    assert received_scan(scenario, scan("P2")).is_quick is quick


def test_a_viewpoint_has_the_name_of_a_listed_sensor_or_the_pose_of_the_request() -> None:
    scenario = core_scenario()
    assert viewpoint_of(scenario, AtPlace(sensor="Q2")) == Viewpoint("Q2", 0.0, 0.0, 0.0, None)
    pose = {"x": 0.1, "y": 0.2, "yaw_rad": 0.3, "height_m": 0.4, "std": {"xy_m": 0.01, "yaw_rad": 0.0}}
    stated = AtPlace.model_validate({"sensor_pose": pose})
    assert viewpoint_of(scenario, stated) == Viewpoint(None, 0.1, 0.2, 0.3, 0.4)
    with pytest.raises(UnknownName):
        viewpoint_of(scenario, AtPlace(sensor="Q9"))


@pytest.mark.parametrize(
    ("kind", "report", "counts"),
    [
        ("scan", {"accepted": True, "reason": None}, True),
        ("scan", {"accepted": True, "reason": "nothing_seen"}, False),
        ("scan", {"accepted": True, "reason": "nearest"}, False),
        ("outcome", {"accepted": True, "reason": None}, False),
        ("scan", None, False),
    ],
)
def test_only_scans_that_count_for_the_poses_are_looks_of_a_place(
    kind: HistoryKind, report: dict[str, Any] | None, counts: bool
) -> None:
    rest = dict.fromkeys(("log_evidence", "fit_rmsd_mm", "fit_hit_rmsd_mm", "best_fit_pose")) | {"beams_compared": 4}
    text = None if report is None else UpdateReport.model_validate(report | rest).model_dump_json()
    state = SessionState("S", "scenario", 1, UNIFORM, UNIFORM, None, NOON, NOON)
    request = scan("P2")
    entry = HistoryEntry(state, kind, json.dumps(request.model_dump(mode="json")), text)
    assert accepted_scan(entry) == (request if counts else None)


def test_an_outcome_names_its_grasp_by_index() -> None:
    request = OutcomeRequest(grasp="G2", success=False, object_moved=0.25)
    outcome = outcome_observation(core_scenario(), request)
    assert (outcome.grasp, outcome.success, outcome.object_moved) == (1, False, 0.25)


def test_an_outcome_of_an_unknown_grasp_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName) as refused:
        outcome_observation(core_scenario(), OutcomeRequest(grasp="G9", success=True))
    assert refused.value.known == ["G1", "G2"]
