import math

import numpy as np
import pytest

from tests.support import twin
from tests.voa_core.worlds import (
    HERE,
    RULE_NAMES,
    box,
    data_predictor,
    lidar_of,
    parameters_of,
    standing,
)
from voa_core import evidence as evidence_module
from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.displacements import Displacements, Spread, standard_normal_points
from voa_core.errors import BeamGridMismatch
from voa_core.evidence import Evidence, evidence_of_scan, restricted
from voa_core.kernels import Array
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.distance_comparison import DifferenceComparison
from voa_core.rules.exponential import Exponential
from voa_core.rules.gaussian import Gaussian
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


SPREAD, STD = Spread(0.01, 0.06), SensorUncertainty(0.02, 0.04)
POSES = PoseSet.from_arrays(
    ["A", "B", "C"],
    [[0.0, 0.0, 0.0], [0.03, -0.02, 0.0], [0.4, 0.4, 0.0]],
    [[math.cos(yaw), 0.0, 0.0, math.sin(yaw)] for yaw in (0.0, 0.1, 0.2)],
)


def twin_copies(lidar: LidarModel, displacements: Displacements) -> list[list[list[float]]]:
    """Scans of the displaced copies of each of POSES at AT, by casting rays on all faces."""
    assert POSES.positions is not None
    assert POSES.quaternions_wxyz is not None
    spread, std = displacements.spread or Spread(1e-9, 1e-9), displacements.std or SensorUncertainty(0.0, 0.0)
    points = standard_normal_points(displacements.copies, displacements.seed)
    copies = []
    for position, quaternion in zip(POSES.positions, POSES.quaternions_wxyz, strict=True):
        covariance = twin.covariance(
            (spread.xy_m, spread.yaw_rad), (std.xy_m, std.yaw_rad), (position[0], position[1]), (AT.x, AT.y)
        )
        placed = [twin.displaced(position, quaternion, twin.displacement(covariance, z)) for z in points]
        angles = lidar.grid.angles.tolist()
        copies.append(
            [
                twin.cast(CUBE.vertices, CUBE.faces, *each, (AT.x, AT.y, AT.yaw_rad), 0.1, angles, lidar.range_max)
                for each in placed
            ]
        )
    return copies


class OwnStatistic(Exponential):
    """A rule whose statistic is that of another one: d^2, twice as large."""

    def statistic(self, observed: Array, predicted: Array) -> Array:
        return 2.0 * super().statistic(observed, predicted)


class OwnComparison(Exponential):
    """A rule that compares scans with displaced copies as another one does."""

    def comparison(self, observed: Floats, copies: DisplacedScans) -> DifferenceComparison:
        return DifferenceComparison(Gaussian(self.no_return_m), observed, copies)


@pytest.mark.parametrize(("own", "copies"), [(OwnStatistic, 1), (OwnComparison, 8)])
def test_rules_of_distance_keep_a_comparison_of_their_own(own: type[Exponential], copies: int) -> None:
    lidar = lidar_of(24)
    predictor, rule = predictor_of_mesh(CUBE, POSES, lidar), own(lidar.range_max)
    scan = Scan(predictor.predict(AT).dense()[1] + 0.01, lidar.grid)
    displacements = Displacements(copies, SPREAD if copies > 1 else None, None, "test")

    def compare(rule: Exponential | Gaussian) -> Evidence:
        return evidence_of_scan(scan, AT, predictor, rule, displacements=displacements)

    distances = -compare(Exponential(lidar.range_max)).log_copies
    expected = -0.5 * distances**2 if copies > 1 else -math.sqrt(2.0) * distances
    np.testing.assert_allclose(compare(rule).log_copies, expected, rtol=1e-12)


@pytest.mark.parametrize("name", RULE_NAMES)
def test_displaced_copies_agree_with_the_twin(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lidar = lidar_of(24)
    predictor, rule = predictor_of_mesh(CUBE, POSES, lidar), rule_of(name, lidar)
    measured = predictor.predict(SensorConfiguration("b", -0.32, 0.09, 0.05)).dense()[1]
    measured[3] = NAN
    displacements = Displacements(8, SPREAD, STD, "test")
    monkeypatch.setattr(evidence_module, "_NUMBERS_AT_ONCE", 2 * 8 * 24)  # two poses, then one
    evidence = evidence_of_scan(Scan(measured, lidar.grid), AT, predictor, rule, displacements=displacements)
    beams, parameters = [float(value) for value in measured], parameters_of(name, lidar)
    assert evidence.copies == 8
    for pose, scans in enumerate(twin_copies(lidar, displacements)):
        weights = [twin.log_weight(name, parameters, beams, scan) for scan in scans]
        np.testing.assert_allclose(evidence.log_copies[pose], weights, rtol=0, atol=1e-9)
        assert evidence.log_weights[pose] == pytest.approx(twin.log_mean_weight(weights), abs=1e-9)
        nearest = min(scans, key=lambda scan: twin.distance(beams, scan, rule.no_return_m))
        assert evidence.distances[pose] == pytest.approx(twin.distance(beams, nearest, rule.no_return_m), abs=1e-9)
        hit_fit = twin.fit_hit_rmsd_mm(beams, nearest, rule.no_return_m)
        expected = NAN if hit_fit is None else 1e-3 * hit_fit
        assert evidence.hit_rmsds[pose] == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert evidence.log_absent == pytest.approx(twin.log_weight(name, parameters, beams, [INF] * 24), abs=1e-11)
    assert evidence.beams_compared == 23


@pytest.mark.parametrize("name", RULE_NAMES)
def test_a_small_spread_changes_little(name: str) -> None:
    lidar = lidar_of(90)
    predictor, rule = predictor_of_mesh(CUBE, POSES, lidar), rule_of(name, lidar)
    scan = Scan(predictor.predict(AT).dense()[1] + 0.003, lidar.grid)
    exact = evidence_of_scan(scan, AT, predictor, rule)
    for small in (1e-5, 1e-7):
        displacements = Displacements(16, Spread(small, small), None, "test")
        vague = evidence_of_scan(scan, AT, predictor, rule, displacements=displacements)
        np.testing.assert_allclose(vague.log_weights, exact.log_weights, rtol=0, atol=1e4 * small)
        np.testing.assert_allclose(vague.distances, exact.distances, rtol=0, atol=10 * small)


def test_poses_compared_in_blocks_are_as_those_compared_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    lidar = lidar_of(120)
    predictor, rule = predictor_of_mesh(CUBE, POSES, lidar), rule_of("exponential", lidar)
    measured = predictor.predict(AT).dense()[1] + 0.01
    measured[::7] = NAN
    displacements = Displacements(8, SPREAD, STD, "test")

    def compare() -> Evidence:
        return evidence_of_scan(Scan(measured, lidar.grid), AT, predictor, rule, displacements=displacements)

    whole = compare()
    monkeypatch.setattr(evidence_module, "_NUMBERS_AT_ONCE", 1)
    blocks = compare()
    np.testing.assert_allclose(blocks.log_copies, whole.log_copies, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(blocks.distances, whole.distances)
    np.testing.assert_array_equal(blocks.hit_rmsds, whole.hit_rmsds)
    np.testing.assert_array_equal(blocks.sight.fewest, whole.sight.fewest)
    for pose in range(len(POSES)):
        np.testing.assert_array_equal(blocks.sight.hits(pose), whole.sight.hits(pose))
    assert len(whole.sight.hits(1))


def test_one_copy_is_the_pose_itself_and_may_come_from_data() -> None:
    displacements = Displacements(1, None, SensorUncertainty(0.0, 0.0), "test")
    scan = Scan(np.array([0.5, 0.7, INF, INF]), LIDAR.grid)
    evidence = evidence_of_scan(scan, HERE, DATA, EXPONENTIAL, displacements=displacements, listed=True)
    np.testing.assert_array_equal(evidence.log_copies, evidence_of([0.5, 0.7, INF, INF]).log_copies)


@pytest.mark.parametrize("has_workspace", [False, True])
@pytest.mark.parametrize("std", [None, SensorUncertainty(0.03, 0.05)])
@pytest.mark.parametrize("possible", [(True, True, True), (False, True, True), (False, False, True)])
def test_which_scans_miss_the_object_agrees_with_the_twin(
    has_workspace: bool, std: SensorUncertainty | None, possible: tuple[bool, ...]
) -> None:
    lidar = lidar_of(120)
    poses = standing((0.0, 0.0, 0.0), (0.05, -0.1, 0.0), (0.3, 0.3, 0.0))
    predictor, rule = predictor_of_mesh(CUBE, poses, lidar), rule_of("beam", lidar)
    displacements = Displacements(16, None, std, "test") if std else Displacements(1, None, None, "test")
    predicted = restricted(
        predictor.predict_displaced(AT, displacements.at(poses, AT)),
        AT,
        None,
        lidar,
        Workspace((-0.2, -0.3), (0.45, 0.45)) if has_workspace else None,
    ).dense()
    workspace = Workspace((-0.2, -0.3), (0.45, 0.45)) if has_workspace else None
    copies = predicted.reshape(3, displacements.copies, 120).tolist()
    belief = [1.0 / sum(possible) if each else 0.0 for each in possible]
    rng = np.random.default_rng(5)
    answers = set()
    for _ in range(20):
        # Parts of a pose's prediction, moved back by up to 0.2 m, some beams lost, some with nothing.
        measured = predictor.predict(AT).dense()[rng.integers(3)] + rng.choice([0.0, 0.05, 0.15, 0.2])
        measured[rng.random(120) < rng.choice([0.0, 0.5, 0.95])] = INF
        measured[rng.random(120) < 0.2] = NAN
        misses = evidence_of_scan(
            Scan(measured, lidar.grid), AT, predictor, rule, workspace=workspace, displacements=displacements
        ).sight.misses_object(np.array(possible))
        crossing = workspace.crossing(AT, lidar.grid.angles) if workspace else None
        beams = classify(Scan(measured, lidar.grid), lidar, crossing).tolist()
        assert misses == twin.misses_object(beams, copies, belief, has_workspace)
        answers.add(misses)
    assert answers == {True, False}
