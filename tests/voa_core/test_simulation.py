"""Simulated scans, and what must hold for the values of looks over them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.voa_core.simulated_worlds import FAR, LIDAR, NEAR, OBJECT, PLACES, POSES, SCORES, SPREAD, STD, PlainGaussian
from tests.voa_core.worlds import HERE, data_predictor, lidar_of
from voa_core import displacements
from voa_core.assistance import Assistance, Valuation
from voa_core.checks import Floats
from voa_core.displacements import Spread, covariances, standard_normal_points
from voa_core.evidence import restricted
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.looks import Looks
from voa_core.poses import PoseSet
from voa_core.prediction import Prediction, predictor_of_mesh
from voa_core.ranking import Ranking, rank_looks
from voa_core.rules.registry import rule_of
from voa_core.scan_model import ScanModel
from voa_core.simulated_weights import SimulatedWeights, simulated_looks
from voa_core.simulation import (
    Sampling,
    chosen_displacements,
    drawn_displacements,
    samples_per_pose,
    simulated_ranges,
)
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher
from voa_core.workspace import Workspace

SAMPLING = Sampling("seed", samples_per_pose(5))
TABLE = GraspTable.of_probabilities(["a", "b", "c"], SCORES, 5)
BELIEF = np.array([0.3, 0.25, 0.2, 0.15, 0.1])


def model_of(lidar: LidarModel = LIDAR, poses: PoseSet = POSES, **settings: object) -> ScanModel:
    model = ScanModel(
        predictor_of_mesh(OBJECT, poses, lidar), PlainGaussian(), UpdatePolicy(), "seed", None, SPREAD, STD
    )
    return replace(model, **settings)  # type: ignore[arg-type] # fields of several types


def valued(look: SimulatedWeights | Weigher, belief: Floats = BELIEF, scores: Floats = SCORES) -> Assistance:
    names = [f"G{x}" for x in range(len(scores))]
    table = GraspTable.of_probabilities(names, scores, len(belief))
    return Valuation(Belief.of(belief), table, UpdatePolicy(), "executed").value(look)


@pytest.fixture(autouse=True)
def _few_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(displacements, "displacement_count", lambda covariance: 8 if covariance.any() else 1)


# -------------------------------------------------------------------------------------------------------- draws


@pytest.mark.parametrize(("poses", "samples"), [(1, 256), (5, 52), (255, 2), (256, 1), (500, 1)])
def test_a_place_has_256_scans_and_each_pose_at_least_one(poses: int, samples: int) -> None:
    assert samples_per_pose(poses) == samples


def test_displacements_have_the_covariance_of_the_update_and_share_the_objects_part() -> None:
    many = Sampling("seed", 4096)
    near, far = (many.uniforms(POSES, place) for place in ("near", "far"))
    drawn = drawn_displacements(near, POSES, NEAR, SPREAD, STD)
    for pose, covariance in enumerate(covariances(POSES, NEAR, SPREAD, STD)):
        scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
        np.testing.assert_allclose(np.cov(drawn[pose].T) / scale, covariance / scale, atol=0.02)
        np.testing.assert_allclose(drawn[pose].mean(axis=0) / np.sqrt(np.diag(covariance)), 0.0, atol=0.02)
    one, other = (drawn_displacements(points, POSES, FAR, SPREAD, None) for points in (near, far))
    np.testing.assert_array_equal(one, other)
    one, other = (drawn_displacements(points, POSES, FAR, None, STD) for points in (near, far))
    assert np.abs(one - other).max() > 0.01
    assert np.abs(drawn[0] - drawn[3]).max() > 0.01, "poses have points of their own"
    fresh = many.fresh()
    assert fresh.samples == 4 * 4096
    assert np.abs(fresh.uniforms(POSES, "near")[:, :4096] - near).min(axis=2).max() > 0.01


def test_a_place_that_was_looked_from_gives_displacements_near_the_likely_ones() -> None:
    points = standard_normal_points(64, "s") * np.array([0.01, 0.02, 0.1])
    copies = np.repeat(points[None], 5, axis=0)
    log_sums = np.full((5, 64), -np.inf)
    log_sums[0] = 0.0
    log_sums[1, 7] = -3.0
    log_sums[2, [7, 9]] = np.log([0.2, 0.8])
    near = chosen_displacements(Sampling("s", 4096).uniforms(POSES, "here"), copies, log_sums)
    mean, share = points.mean(axis=0), 1.2 / 4
    towards = mean + math.sqrt(1 - share**2) * (points - mean)
    expected = [mean, towards[7], 0.2 * towards[7] + 0.8 * towards[9], mean]
    for pose, value in enumerate(expected):
        assert (np.abs(near[pose].mean(axis=0) - value) < 0.02 * np.array([0.01, 0.02, 0.1])).all()
    for pose, factor in ((0, 1.0), (1, share**2), (3, 1.0)):  # where no look had a weight, all copies are as likely
        np.testing.assert_allclose(
            np.cov(near[pose].T), factor * np.cov(points.T, bias=True), atol=0.03 * factor * 0.01
        )


def test_ranges_have_the_noise_of_the_lidar_and_are_classified() -> None:
    lidar = LidarModel(lidar_of(6).grid, 0.3, 2.0, 0.1, "missing", 0.01, 0.1, 0.0)
    workspace = Workspace((0.5, -5.0), (5.0, 5.0)).crossing(HERE, np.zeros(6))
    exact = np.array([[0.05, 0.45, 1.0, 1.5, 1.95, np.inf]])
    prediction = Prediction(lidar.grid, np.arange(6), exact)
    noise = np.array([[5.0, -2.0, -2.0, 1.0, 1.0, 9.0]])
    plain = simulated_ranges(prediction, noise, lidar, None)
    np.testing.assert_allclose(plain, [[np.nan, 0.36, 0.8, 1.65, np.inf, np.inf]])
    boxed = simulated_ranges(prediction, noise, lidar, workspace)
    np.testing.assert_allclose(boxed, [[np.nan, np.nan, 0.8, 1.65, np.inf, np.inf]])
    narrow = Workspace((0.5, -5.0), (1.2, 5.0)).crossing(HERE, np.zeros(6))
    np.testing.assert_allclose(simulated_ranges(prediction, noise, lidar, narrow)[0, 2:4], [0.8, np.inf])


# ------------------------------------------------------------------------------------------------------- axioms


def test_the_same_request_has_the_same_answer_to_the_last_byte() -> None:
    one, other = (SimulatedWeights.of(model_of(), NEAR, SAMPLING) for _ in range(2))
    assert one.matrix is not None
    assert other.matrix is not None
    assert one.matrix.tobytes() == other.matrix.tobytes()
    another = SimulatedWeights.of(model_of(), NEAR, Sampling("another", SAMPLING.samples))
    assert another.matrix is not None
    assert not np.allclose(one.matrix, another.matrix)


def test_permuting_poses_and_grasps_permutes_answers() -> None:
    order = np.array([3, 0, 4, 1, 2])
    here = valued(SimulatedWeights.of(model_of(), NEAR, SAMPLING))
    there = valued(
        SimulatedWeights.of(model_of(poses=POSES.subset(order)), NEAR, SAMPLING),
        BELIEF[order],
        SCORES[::-1][:, order],
    )
    assert there.voa == pytest.approx(here.voa, abs=1e-12)
    assert there.standard_error == pytest.approx(here.standard_error, abs=1e-12)
    np.testing.assert_allclose(there.scores, here.scores[order], atol=1e-12)
    assert there.best_grasps.tolist() == [2 - grasp for grasp in here.best_grasps[order]]


def ranking_of(*sensors: SensorConfiguration) -> Ranking:
    of = simulated_looks(model_of(), SAMPLING, lists=lambda _sensor: False, log_sums_of=lambda _sensor: None)
    return rank_looks(sensors, Looks(of), Valuation(Belief.of(BELIEF), TABLE, UpdatePolicy(), "executed"))


def test_permuting_sensors_permutes_answers_and_equal_places_tie() -> None:
    again = replace(NEAR, name="again")
    one, other = ranking_of(NEAR, FAR, again), ranking_of(again, FAR, NEAR)
    assert {look.sensor.name: look.net_value for look in one.looks} == {
        look.sensor.name: look.net_value for look in other.looks
    }
    values = {look.sensor.name: look.net_value for look in one.looks}
    assert values["near"] == values["again"]


def test_looks_tie_that_differ_by_no_more_than_chance() -> None:
    ranking = ranking_of(NEAR, replace(NEAR, name="dear", cost=0.01), replace(NEAR, name="worse", x=-1.5))
    ties = {look.sensor.name: ranking.ties_with_first(look) for look in ranking.looks}
    # A cost differs in every sample alike: it is no chance.
    assert ties == {"near": True, "dear": False, "worse": False}


def test_without_spread_and_noise_the_value_is_that_of_exact_scans() -> None:
    lidar = replace(LIDAR, noise_m=1e-9, noise_ratio=0.0)
    for tiny in (
        model_of(lidar, spread=None, std=None),
        model_of(lidar, spread=replace(SPREAD, xy_m=1e-9, yaw_rad=1e-9), std=replace(STD, xy_m=1e-9, yaw_rad=0.0)),
    ):
        for sensor in PLACES:
            prediction = restricted(tiny.predictor.predict(sensor), sensor, None, lidar, None)
            exact = valued(Weigher.of(tiny.rule, prediction, np.float64, keep=True))
            simulated = valued(SimulatedWeights.of(tiny, sensor, SAMPLING))
            assert simulated.voa == pytest.approx(exact.voa, abs=1e-9)
            assert simulated.best_grasps.tolist() == exact.best_grasps.tolist()


def test_an_earlier_look_leaves_less_for_the_next_one_from_there() -> None:
    model = model_of()
    log_sums = np.full((5, 8), -30.0)
    log_sums[np.arange(5), [1, 3, 0, 7, 4]] = 0.0
    first = SimulatedWeights.of(model, NEAR, SAMPLING)
    second = SimulatedWeights.of(model, NEAR, SAMPLING, log_sums=log_sums)
    # With the displacement all but known, each scan shows its pose: exactly known, the gain is that of certainty.
    certain = Valuation(Belief.of(BELIEF), TABLE, UpdatePolicy()).perfect_information(None)
    assert first.samples == second.samples
    assert valued(second).voa == pytest.approx(certain, abs=0.02)


def test_a_scan_that_does_not_show_the_object_changes_nothing() -> None:
    apart = PoseSet.from_arrays(["A", "B"], [(0.0, 0.0, 0.0), (0.0, 0.9, 0.0)], [(1.0, 0.0, 0.0, 0.0)] * 2)
    model = model_of(replace(LIDAR, grid=BeamGrid(360, 0.0, math.radians(1.0))), apart)
    look = SimulatedWeights.of(model, NEAR, Sampling("seed", 8))
    sure = Belief.of([1.0, 0.0])
    judged = look.seen_with(sure, UpdatePolicy())
    assert judged.refused[0].tolist() == [False] * 8 + [True] * 8
    np.testing.assert_array_equal(judged.weights(np.arange(8, 16), np.arange(2)), np.ones((8, 2)))
    np.testing.assert_array_equal(judged.log_rows(np.array([9])), np.zeros((1, 2)))
    assert judged.seen_with(sure, UpdatePolicy()) is judged
    assert look.seen_with(sure, UpdatePolicy(on_nothing_seen="evidence")) is look
    two = SimulatedWeights.of(model, NEAR, Sampling("seed", 8), looks=2).seen_with(sure, UpdatePolicy())
    np.testing.assert_array_equal(two.weights(np.arange(8, 16), np.arange(2)), np.ones((8, 2)))


def test_data_without_a_mesh_have_noise_but_no_displacements() -> None:
    lidar = lidar_of(2)
    ranges = np.array([[0.5, 0.6], [1.0, np.inf], [1.5, 0.7]])
    model = ScanModel(data_predictor(ranges, lidar), rule_of("beam", lidar), UpdatePolicy(), "seed", None, None, STD)
    look = SimulatedWeights.of(model, HERE, Sampling("seed", 4), listed=True)
    seen = look.scans[0].ranges.reshape(3, 4, 2)
    assert 0.0 < np.abs(seen[0, :, 0] - 0.5).max() < 0.06
    assert np.isinf(seen[1, :, 1]).all()


# -------------------------------------------------------------------------------------------------------- truth


@pytest.mark.parametrize("samples", [16, 64])
@pytest.mark.parametrize("spread", [Spread(0.03, 0.4), Spread(0.02, 0.2), Spread(0.01, 0.08)])
def test_the_true_value_lies_within_two_standard_errors(spread: Spread, samples: int) -> None:
    # Scans often confuse the poses under the first spread, and hardly ever under the last: no sample may show it then.
    rng = np.random.default_rng(11)
    model = model_of(spread=spread)
    truths = [SimulatedWeights.of(model, sensor, Sampling("truth", 300)) for sensor in PLACES]
    within = []
    for seed in range(25):
        for sensor, truth in zip(PLACES, truths, strict=True):
            belief, scores = rng.dirichlet(np.ones(5)), rng.uniform(size=(3, 5))
            look = SimulatedWeights.of(model, sensor, Sampling(str(seed), samples))
            own, true = valued(look, belief, scores), valued(truth, belief, scores)
            assert own.standard_error is not None
            assert true.standard_error is not None
            within.append(abs(own.voa - true.voa) <= 2.0 * math.hypot(own.standard_error, true.standard_error))
    assert np.mean(within) >= 0.9


def test_one_scan_of_each_pose_has_a_standard_error_that_covers() -> None:
    model, belief = model_of(), BELIEF
    truth = valued(SimulatedWeights.of(model, NEAR, Sampling("truth", 300)), belief)
    singles = [valued(SimulatedWeights.of(model, NEAR, Sampling(str(seed), 1)), belief) for seed in range(30)]
    errors = [look.standard_error or 0.0 for look in singles]
    off = [abs(look.voa - truth.voa) for look in singles]
    assert np.mean(np.array(off) <= 2.0 * np.array(errors) + 2.0 * (truth.standard_error or 0.0)) >= 0.9


def test_the_error_of_measured_scores_is_that_of_drawing_them_again() -> None:
    look = SimulatedWeights.of(model_of(), NEAR, SAMPLING)
    counts = np.array([[13, 3, 2, 9, 5], [2, 12, 4, 3, 10], [6, 6, 13, 6, 6]])
    table = GraspTable.of_successes(["a", "b", "c"], counts, 15, 5)
    valuation = Valuation(Belief.of(BELIEF), table, UpdatePolicy(), "executed")
    worth = valuation.value(look)
    assert valued(look).score_standard_error is None
    # The grasps that are chosen after each scan, and their worth under scores drawn from the Beta distribution.
    kept, poses = int(np.argmax(table.scores @ BELIEF)), np.repeat(np.arange(5), SAMPLING.samples)
    chosen = (look.weights(np.arange(len(poses)), np.arange(5)) * BELIEF @ table.scores.T).argmax(axis=1)
    rng = np.random.default_rng(2)
    drawn = rng.beta(counts + 0.5, 15.5 - counts, (4000, 3, 5))
    gains = drawn[:, chosen, poses] - drawn[:, kept, poses]
    values = gains.reshape(4000, 5, -1).mean(axis=2) @ BELIEF
    assert worth.score_standard_error == pytest.approx(values.std(), rel=0.05)


def test_scans_without_a_beam_to_compare_change_nothing() -> None:
    lidar = lidar_of(1)  # shorter ranges than 0.1 m are missing
    model = ScanModel(
        data_predictor(np.array([[0.1], [1.0]]), lidar), rule_of("gaussian", lidar), UpdatePolicy(), "seed"
    )
    for looks in (1, 2):
        look = SimulatedWeights.of(model, HERE, Sampling("seed", 16), listed=True, looks=looks)
        lost = np.flatnonzero(np.logical_and.reduce(look.refused))
        assert 0 < len(lost) < 16
        np.testing.assert_array_equal(look.weights(lost, np.arange(2)), 1.0)
        before = Belief.of([0.5, 0.5])
        assert look.beliefs(np.arange(0), [], UpdatePolicy()) == []
        for after in look.beliefs(lost, [before] * len(lost), UpdatePolicy()):
            np.testing.assert_allclose(after.p, 0.5)


def test_a_look_that_weighs_all_copies_alike_leaves_a_place_as_new() -> None:
    model = model_of()
    fresh = SimulatedWeights.of(model, NEAR, SAMPLING)
    after_exact = SimulatedWeights.of(model, NEAR, SAMPLING, log_sums=np.zeros((5, 1)))
    assert after_exact.matrix is not None
    assert fresh.matrix is not None
    assert after_exact.matrix.tobytes() == fresh.matrix.tobytes()


def test_of_scans_in_a_row_that_no_pose_explains_together_those_count_that_can() -> None:
    lidar = lidar_of(1)
    ranges = np.array([[0.105], [0.114]])  # the second scan may fit another pose than the first, or be missing
    rule = rule_of("margin", lidar, margin_m=0.006)
    model = ScanModel(data_predictor(ranges, lidar), rule, UpdatePolicy(), "seed")
    look = SimulatedWeights.of(model, HERE, Sampling("seed", 64), listed=True, looks=2)
    one_by_one = [scan.ranges[:, 0] for scan in look.scans]
    before = Belief.of([0.5, 0.5])
    kinds = set()
    for row, (after, first, second) in enumerate(
        zip(look.beliefs(np.arange(128), [before] * 128, UpdatePolicy()), *one_by_one, strict=True)
    ):
        fits = np.abs(np.array([[first], [second]]) - ranges[:, 0]) <= 0.006 + 1e-9
        expected = np.ones(2, dtype=bool)
        for fit in fits:
            expected = expected & fit if (expected & fit).any() else expected
        np.testing.assert_allclose(after.p, expected / expected.sum(), err_msg=str(row))
        kinds.add((bool((fits[0] & fits[1]).any()), bool(fits[0].any())))
    assert {(True, True), (False, True), (False, False)} <= kinds
