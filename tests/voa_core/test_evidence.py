import math

import numpy as np
import pytest

from tests.support import twin
from tests.voa_core.worlds import (
    HERE,
    RULE_NAMES,
    as_lists,
    box,
    data_predictor,
    lidar_of,
    parameters_of,
    standing,
)
from voa_core.errors import BeamGridMismatch
from voa_core.evidence import Evidence, evidence_of_scan, restricted
from voa_core.lidars import BeamGrid, SensorConfiguration, SensorUncertainty
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scans import Scan, classify
from voa_core.workspace import Workspace

INF, NAN = math.inf, math.nan
LIDAR = lidar_of(4, range_max=2.0)
DATA = data_predictor(np.array([[0.5, 0.6, INF, INF], [0.5, INF, INF, 0.9]]), LIDAR)
EXPONENTIAL = rule_of("exponential", LIDAR, no_return_m=1.0)

CUBE = box(0.2, 0.2, 0.2)
AT = SensorConfiguration("a", -0.3, 0.08, 0.03)
"""A sensor in front of the cube, off its middle and askew, so that no beam grazes."""


def evidence_of(ranges: list[float]) -> Evidence:
    return evidence_of_scan(Scan(np.array(ranges), LIDAR.grid), HERE, DATA, EXPONENTIAL, listed=True)


def test_distances_weights_and_fits_by_hand() -> None:
    evidence = evidence_of([0.5, 0.7, INF, INF])
    # P0: 0.1 on beam 1. P1: 0.7 against 1.0 on beam 1, 1.0 against 0.9 on beam 3.
    distances = [0.1, math.hypot(0.3, 0.1)]
    np.testing.assert_allclose(evidence.distances, distances)
    np.testing.assert_allclose(evidence.log_weights, [-d for d in distances])
    assert evidence.beams_compared == 4
    assert evidence.best_fit == 0
    assert evidence.fit_rmsd_mm == pytest.approx(1e3 * 0.1 / 2.0)
    # Both return on beams 0 and 1 for P0, on beam 0 alone, where nothing is off, for P1.
    np.testing.assert_allclose(evidence.hit_rmsds, [0.1 / math.sqrt(2.0), 0.0])
    assert evidence.fit_hit_rmsd_mm == pytest.approx(1e3 * 0.1 / math.sqrt(2.0))


def test_missing_beams_take_part_in_nothing() -> None:
    evidence = evidence_of([0.4, NAN, INF, NAN])
    assert evidence.beams_compared == 2
    np.testing.assert_allclose(evidence.distances, [0.1, 0.1])
    np.testing.assert_allclose(evidence.hit_rmsds, [0.1, 0.1])


def test_a_return_where_no_pose_predicts_one_counts_against_all_alike() -> None:
    evidence = evidence_of([0.5, 0.6, 0.4, INF])
    np.testing.assert_allclose(evidence.distances, [0.6, math.sqrt(0.36 + 0.16 + 0.01)])
    assert evidence.beams_compared == 4


def test_a_scan_of_missing_beams_says_nothing() -> None:
    evidence = evidence_of([NAN] * 4)
    assert (evidence.beams_compared, evidence.fit_rmsd_mm, evidence.fit_hit_rmsd_mm) == (0, None, None)
    assert evidence.log_weights.tolist() == [0.0, 0.0]


def test_without_a_beam_on_which_both_return_there_is_no_fit_of_hits() -> None:
    evidence = evidence_of([INF] * 4)
    assert evidence.fit_hit_rmsd_mm is None
    assert evidence.fit_rmsd_mm == pytest.approx(1e3 * math.hypot(0.5, 0.1) / 2.0)


def test_the_fit_of_hits_is_that_of_the_pose_that_fits_best() -> None:
    evidence = evidence_of([NAN, 0.65, NAN, NAN])
    assert math.isnan(evidence.hit_rmsds[1])
    assert evidence.fit_hit_rmsd_mm == pytest.approx(50.0)
    assert evidence_of([NAN, 0.9, NAN, NAN]).best_fit == 1
    assert evidence_of([NAN, 0.9, NAN, NAN]).fit_hit_rmsd_mm is None


def test_equal_fits_go_to_the_pose_listed_first() -> None:
    assert evidence_of([0.5, NAN, INF, NAN]).best_fit == 0


def test_the_best_fit_is_the_pose_of_the_largest_weight_and_not_of_the_smallest_distance() -> None:
    # P0 is 30 standard deviations off on three beams; P1 explains all but one no-return, which counts as 4 m.
    lidar = lidar_of(4, range_max=4.0)
    data = data_predictor(np.array([[0.8, 0.8, 0.8, INF], [0.5, 0.5, 0.5, 0.5]]), lidar)
    scan = Scan(np.array([0.5, 0.5, 0.5, INF]), lidar.grid)
    by_distance = evidence_of_scan(scan, HERE, data, rule_of("exponential", lidar), listed=True)
    assert by_distance.best_fit == 0
    assert by_distance.fit_hit_rmsd_mm == pytest.approx(300.0)
    by_beams = evidence_of_scan(scan, HERE, data, rule_of("beam", lidar), listed=True)
    assert (by_beams.best_fit, by_beams.fit_hit_rmsd_mm) == (1, 0.0)
    assert by_beams.fit_rmsd_mm == pytest.approx(1e3 * 3.5 / 2.0)


def test_where_no_pose_has_any_weight_the_best_fit_is_the_nearest() -> None:
    margin = rule_of("margin", LIDAR, margin_m=0.01)
    scan = Scan(np.array([0.5, INF, INF, 0.8]), LIDAR.grid)
    evidence = evidence_of_scan(scan, HERE, DATA, margin, listed=True)
    assert (evidence.log_weights == -INF).all()
    assert evidence.best_fit == 1


def test_the_scans_own_range_max_holds_for_predictions_too() -> None:
    scan = Scan(np.array([0.5, INF, INF, INF]), LIDAR.grid, range_max=0.55)
    evidence = evidence_of_scan(scan, HERE, DATA, EXPONENTIAL, listed=True)
    np.testing.assert_allclose(evidence.distances, [0.0, 0.0])


def test_the_workspace_holds_for_scans_and_predictions() -> None:
    sensor = SensorConfiguration(HERE.name, -1.0, 0.0, 0.0)
    lidar = lidar_of(1)
    data = data_predictor(np.array([[1.0], [0.5], [1.5]]), lidar)
    near_the_origin = Workspace((-0.2, -0.2), (0.2, 0.2))

    def distances(measured: float) -> list[float]:
        scan, rule = Scan(np.array([measured]), lidar.grid), rule_of("exponential", lidar)
        evidence = evidence_of_scan(scan, sensor, data, rule, workspace=near_the_origin, listed=True)
        return evidence.distances.tolist() if evidence.beams_compared else []

    assert distances(1.1) == pytest.approx([0.1, 0.9, 0.9])
    assert distances(1.4) == pytest.approx([1.0, 0.0, 0.0])
    assert distances(0.6) == []


def test_a_mesh_is_compared_at_the_scans_own_angles() -> None:
    lidar = lidar_of(360)
    predictor = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0), (0.05, 0.0, 0.0)), lidar)
    grid = BeamGrid(7, -0.2, 0.061)
    seen = predictor.predict(AT, grid).dense()[1]
    evidence = evidence_of_scan(Scan(seen, grid), AT, predictor, rule_of("gaussian", lidar))
    assert evidence.best_fit == 1
    assert evidence.distances[1] == pytest.approx(0.0, abs=1e-12)
    assert evidence.beams_compared == 7


def test_a_grid_that_agrees_with_the_lidars_is_the_lidars() -> None:
    shifted = BeamGrid(4, 2.0 * math.pi + 5e-5, math.pi / 2)
    scan = Scan(np.array([0.5, 0.6, INF, INF]), shifted)
    assert evidence_of_scan(scan, HERE, DATA, EXPONENTIAL, listed=True).distances[0] == 0.0


def test_data_cannot_serve_other_beams() -> None:
    with pytest.raises(BeamGridMismatch, match="the scan's beams differ from the lidar's"):
        evidence_of_scan(Scan(np.ones(3), BeamGrid(3, 0.0, 0.1)), HERE, DATA, EXPONENTIAL, listed=True)


@pytest.mark.parametrize("name", RULE_NAMES)
def test_an_uncertain_sensor_pose_weighs_by_the_mean_over_its_sigma_points(name: str) -> None:
    lidar = lidar_of(24)
    poses = standing((0.0, 0.0, 0.0), (0.03, -0.02, 0.0), (0.4, 0.4, 0.0))
    predictor, rule = predictor_of_mesh(CUBE, poses, lidar), rule_of(name, lidar)
    measured = predictor.predict(SensorConfiguration("b", -0.32, 0.09, 0.05)).dense()[1]
    measured[3] = NAN
    spread = SensorUncertainty(0.02, 0.04)
    evidence = evidence_of_scan(Scan(measured, lidar.grid), AT, predictor, rule, uncertainty=spread)
    stands = [as_lists(predictor.predict(stand).dense()) for stand in spread.sigma_points(AT)]
    beams, parameters = [float(value) for value in measured], parameters_of(name, lidar)
    for pose in range(3):
        weights = [twin.log_weight(name, parameters, beams, stand[pose]) for stand in stands]
        assert evidence.log_weights[pose] == pytest.approx(twin.log_mean_weight(weights), abs=1e-11)
        nearest = min(stands, key=lambda stand: twin.distance(beams, stand[pose], rule.no_return_m))[pose]
        assert evidence.distances[pose] == pytest.approx(twin.distance(beams, nearest, rule.no_return_m), abs=1e-12)
        hit_fit = twin.fit_hit_rmsd_mm(beams, nearest, rule.no_return_m)
        expected = NAN if hit_fit is None else 1e-3 * hit_fit
        assert evidence.hit_rmsds[pose] == pytest.approx(expected, abs=1e-12, nan_ok=True)
    assert evidence.beams_compared == 23


@pytest.mark.parametrize("has_workspace", [False, True])
@pytest.mark.parametrize("std", [None, SensorUncertainty(0.03, 0.05)])
@pytest.mark.parametrize("possible", [(True, True, True), (False, True, True), (False, False, True)])
def test_which_scans_miss_the_object_agrees_with_the_twin(
    has_workspace: bool, std: SensorUncertainty | None, possible: tuple[bool, ...]
) -> None:
    lidar = lidar_of(120)
    poses = standing((0.0, 0.0, 0.0), (0.05, -0.1, 0.0), (0.3, 0.3, 0.0))
    predictor, rule = predictor_of_mesh(CUBE, poses, lidar), rule_of("beam", lidar)
    workspace = Workspace((-0.2, -0.3), (0.45, 0.45)) if has_workspace else None
    stands = std.sigma_points(AT) if std else [AT]
    copies = [
        [restricted(predictor.predict(stand), stand, None, lidar, workspace).dense()[pose].tolist() for stand in stands]
        for pose in range(3)
    ]
    belief = [1.0 / sum(possible) if each else 0.0 for each in possible]
    rng = np.random.default_rng(5)
    answers = set()
    for _ in range(20):
        # Parts of a pose's prediction, moved back by up to 0.2 m, some beams lost, some with nothing.
        measured = predictor.predict(AT).dense()[rng.integers(3)] + rng.choice([0.0, 0.05, 0.15, 0.2])
        measured[rng.random(120) < rng.choice([0.0, 0.5, 0.95])] = INF
        measured[rng.random(120) < 0.2] = NAN
        misses = evidence_of_scan(
            Scan(measured, lidar.grid), AT, predictor, rule, workspace=workspace, uncertainty=std
        ).sight.misses_object(np.array(possible))
        crossing = workspace.crossing(AT, lidar.grid.angles) if workspace else None
        beams = classify(Scan(measured, lidar.grid), lidar, crossing).tolist()
        assert misses == twin.misses_object(beams, copies, belief, has_workspace)
        answers.add(misses)
    assert answers == {True, False}


def test_a_certain_sensor_pose_may_be_stated_as_an_uncertainty_of_zero() -> None:
    lidar = lidar_of(24)
    predictor, rule = predictor_of_mesh(CUBE, standing((0.0, 0.0, 0.0)), lidar), rule_of("exponential", lidar)
    scan = Scan(np.full(24, 0.5), lidar.grid)
    stated = evidence_of_scan(scan, AT, predictor, rule, uncertainty=SensorUncertainty(0.0, 0.0))
    assert stated.distances.tolist() == evidence_of_scan(scan, AT, predictor, rule).distances.tolist()
