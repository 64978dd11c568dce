"""Estimates over several looks and attempts: the axioms of places, and agreement with the brute-force twin."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import twin
from tests.voa_core.worlds import box, lidar_of, random_belief, sight_at_half_a_metre, standing
from voa_core.checks import Floats
from voa_core.displacements import Spread
from voa_core.errors import InvalidInput
from voa_core.estimates import Attempts, Estimate
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.places import Place, Viewpoint
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import defaults, rule_of
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.updating import (
    Update,
    UpdatePolicy,
    copies_needed,
    update,
    update_estimate,
    update_estimate_by_outcome,
)

few = settings(max_examples=25, deadline=None)
seeds = st.integers(0, 2**32 - 1)
POLICY = UpdatePolicy()
Q1, Q2, Q3 = (Viewpoint(name, 0.0, 0.0, 0.0, 0.1) for name in ("Q1", "Q2", "Q3"))


def look(
    log_copies: Any,
    viewpoint: Viewpoint | None = Q1,
    *,
    distances: Sequence[float] | None = None,
    log_absent: float = 0.0,
    missed: bool = False,
) -> Evidence:
    """Evidence with these log weights (n, J); `missed`: four returns are predicted, and none of them occurs."""
    array: Floats = np.array(log_copies, dtype=np.float64)
    n = len(array)
    beams = 4 if missed else 0
    sight = sight_at_half_a_metre(np.full(beams, np.inf), np.full(n, beams))
    far = np.array(distances if distances is not None else [0.1] * n)
    return Evidence(array, far, np.full(n, np.nan), 4, sight, log_absent, viewpoint)


def apply(estimate: Estimate, looks: Sequence[Evidence], policy: UpdatePolicy = POLICY) -> Estimate:
    for number, each in enumerate(looks):
        result = update_estimate(estimate, each, policy, number)
        assert result.accepted
        estimate = result.estimate
    return estimate


def random_looks(rng: np.random.Generator, n: int, copies: int, nats: float = 5.0) -> list[Evidence]:
    """Five looks from three places; some copies of some poses are impossible."""
    looks = []
    for viewpoint in (Q1, Q2, Q1, Q3, Q1):
        weights = rng.uniform(-nats, 0.0, (n, copies))
        weights[:, 1:][rng.random((n, copies - 1)) < 0.2] = -np.inf
        looks.append(look(weights, viewpoint))
    return looks


def twin_places(looks: Sequence[Evidence]) -> list[list[list[list[float]]]]:
    names = dict.fromkeys(each.viewpoint for each in looks)
    return [[each.log_copies.tolist() for each in looks if each.viewpoint == name] for name in names]


@few
@given(seed=seeds, n=st.integers(1, 5), copies=st.sampled_from([2, 4, 16]))
def test_looks_from_several_places_agree_with_the_twin(seed: int, n: int, copies: int) -> None:
    rng = np.random.default_rng(seed)
    base = random_belief(rng, n, int(rng.integers(1, n + 1)))
    looks, estimate, total = random_looks(rng, n, copies), Estimate.of(Belief.of(base)), 0.0
    for number, each in enumerate(looks):
        result = update_estimate(estimate, each, POLICY, number)
        estimate = result.estimate
        expected = twin.belief_of_places(list(base), twin_places(looks[: number + 1]))
        assert expected is not None
        assert result.log_evidence is not None
        total += result.log_evidence
        np.testing.assert_allclose(estimate.belief.p, expected[0], rtol=0, atol=1e-10)
        assert total == pytest.approx(expected[1], abs=1e-10)
    assert [place.looks for place in estimate.places] == [(0, 2, 4), (1,), (3,)]


@few
@given(seed=seeds, nats=st.sampled_from([1.0, 30.0, 1000.0]))
def test_looks_commute_given_their_places(seed: int, nats: float) -> None:
    rng = np.random.default_rng(seed)
    base = Estimate.of(Belief.of(random_belief(rng, 4, 3)))
    looks = random_looks(rng, 4, 8, nats)
    expected = apply(base, looks).belief.p
    for _ in range(4):
        order = rng.permutation(5)
        np.testing.assert_allclose(apply(base, [looks[i] for i in order]).belief.p, expected, rtol=0, atol=1e-12)


@few
@given(seed=seeds)
def test_with_one_copy_each_look_multiplies_the_belief_to_the_last_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    belief = Belief.of(random_belief(rng, 5, 4))
    looks = [look(rng.uniform(-9.0, 0.0, (5, 1)), viewpoint) for viewpoint in (Q1, Q1, Q2, Q1)]
    estimate = apply(Estimate.of(belief), looks)
    for each in looks:
        belief = update(belief, each, POLICY).belief
    assert estimate.belief.p.tobytes() == belief.p.tobytes()
    assert estimate.belief.log_p.tobytes() == belief.log_p.tobytes()


@few
@given(seed=seeds)
def test_permuting_the_poses_permutes_the_belief(seed: int) -> None:
    rng = np.random.default_rng(seed)
    base, order = random_belief(rng, 5, 5), rng.permutation(5)
    looks = random_looks(rng, 5, 4)
    permuted = [replace(each, log_copies=each.log_copies[order]) for each in looks]
    plain = apply(Estimate.of(Belief.of(base)), looks).belief.p
    again = apply(Estimate.of(Belief.of(base[order])), permuted).belief.p
    np.testing.assert_allclose(again, plain[order], rtol=0, atol=1e-12)


@few
@given(seed=seeds, log_constant=st.floats(-500.0, 500.0))
def test_a_constant_weight_changes_nothing_but_the_evidence(seed: int, log_constant: float) -> None:
    rng = np.random.default_rng(seed)
    start = Estimate.of(Belief.of(random_belief(rng, 4, 4)))
    first, second = look(rng.uniform(-5.0, 0.0, (4, 8))), look(rng.uniform(-5.0, 0.0, (4, 8)))
    before = apply(start, [first])
    plain = update_estimate(before, second, POLICY)
    shifted = update_estimate(before, replace(second, log_copies=second.log_copies + log_constant), POLICY)
    np.testing.assert_allclose(shifted.belief.p, plain.belief.p, rtol=0, atol=1e-12)
    assert plain.log_evidence is not None
    assert shifted.log_evidence == pytest.approx(plain.log_evidence + log_constant, abs=1e-9)


def test_a_repeated_look_from_one_place_says_less_than_one_from_another() -> None:
    # One of two copies of A fits, and both of B do, half as well.
    weights = np.log([[0.98, 0.02], [0.25, 0.25]])
    start = Estimate.of(Belief.uniform(2))
    once = apply(start, [look(weights)]).belief.p
    np.testing.assert_allclose(once, [0.5 / 0.75, 0.25 / 0.75])
    same = apply(start, [look(weights), look(weights)]).belief.p
    mean = (0.98**2 + 0.02**2) / 2.0
    np.testing.assert_allclose(same, [mean / (mean + 0.0625), 0.0625 / (mean + 0.0625)])
    other = apply(start, [look(weights), look(weights, Q2)]).belief.p
    np.testing.assert_allclose(other, [0.25 / 0.3125, 0.0625 / 0.3125])
    unknown = apply(start, [look(weights, None), look(weights, None)])
    np.testing.assert_allclose(unknown.belief.p, other)
    assert len(unknown.places) == 2


def test_a_single_copy_and_several_meet_at_one_place() -> None:
    exact, vague = look(np.log([[0.5], [0.2]])), look(np.log([[0.9, 0.1], [0.3, 0.5]]))
    for order in ([exact, vague], [vague, exact]):
        estimate = apply(Estimate.of(Belief.uniform(2)), order)
        np.testing.assert_allclose(estimate.belief.p, [0.25 / 0.33, 0.08 / 0.33])
        assert [place.copies for place in estimate.places] == [2]
    assert copies_needed(apply(Estimate.of(Belief.uniform(2)), [exact]), vague) == 2
    assert copies_needed(apply(Estimate.of(Belief.uniform(2)), [vague]), exact) == 2
    assert copies_needed(Estimate.of(Belief.uniform(2)), vague) == 2


def place_of(log_copies: Sequence[Floats]) -> Place:
    """A place at Q1 with looks of these log weights, numbered 0, 2, ..."""
    place = Place(Q1, (), np.zeros((len(log_copies[0]), 1)))
    for number, each in enumerate(log_copies):
        place = place.with_look(2 * number, each)
    return place


def test_a_place_is_computed_again_with_more_copies() -> None:
    rng = np.random.default_rng(4)
    many = [look(rng.uniform(-3.0, 0.0, (3, 8)), viewpoint, log_absent=-1.5) for viewpoint in (Q1, Q2, Q1, Q1)]
    fewer = [replace(each, log_copies=each.log_copies[:, :4]) for each in many]
    start = Estimate.of(Belief.of([0.2, 0.3, 0.5]), absent=0.4)
    expected = apply(start, [many[0], fewer[1], *many[2:]])
    with_four = apply(start, fewer[:3])
    assert copies_needed(with_four, many[3]) == 8
    with pytest.raises(ValueError, match="8 copies"):
        update_estimate(with_four, many[3], POLICY)
    rebuilt = with_four.with_more_copies(0, place_of([many[0].log_copies, many[2].log_copies]))
    actual = update_estimate(rebuilt, many[3], POLICY, 3).estimate
    assert [place.looks for place in actual.places] == [place.looks for place in expected.places]
    by_hand = twin.belief_of_places([0.2, 0.3, 0.5], twin_places([*(many[i] for i in (0, 2, 3)), fewer[1]]))
    assert by_hand is not None
    np.testing.assert_allclose(actual.belief.p, by_hand[0], rtol=0, atol=1e-12)
    assert actual.log_odds_absent == pytest.approx(expected.log_odds_absent)
    with pytest.raises(ValueError, match="place 0 has 2 looks, and 1 were compared again"):
        with_four.with_more_copies(0, place_of([many[0].log_copies]))


def test_a_pose_that_a_place_has_ruled_out_stays_ruled_out_with_more_copies() -> None:
    first = np.zeros((2, 8))
    first[0, :4] = -np.inf
    ruled_out = apply(Estimate.of(Belief.uniform(2)), [look(first[:, :4])])
    assert ruled_out.belief.p.tolist() == [0.0, 1.0]
    rebuilt = ruled_out.with_more_copies(0, place_of([first]))
    assert rebuilt.belief.p.tolist() == [0.0, 1.0]
    assert rebuilt.places[0].copies == 8
    assert ruled_out.with_more_copies(0, place_of([np.full((2, 8), -np.inf)])).belief is ruled_out.belief


def test_a_scan_that_is_not_accepted_leaves_the_estimate_as_it_is() -> None:
    before = apply(Estimate.of(Belief.uniform(2)), [look(np.zeros((2, 4)))])
    impossible = look(np.full((2, 4), -np.inf))
    for evidence, policy, reason in (
        (replace(impossible, beams_compared=0), POLICY, "no_beams"),
        (look(np.zeros((2, 4)), missed=True), POLICY, "nothing_seen"),
        (look(np.zeros((2, 4))), UpdatePolicy(reject_above_rmsd_mm=49.0), "bad_fit"),
        (impossible, POLICY, "no_match"),
    ):
        result = update_estimate(before, evidence, policy)
        assert (result.accepted, result.reason, result.log_evidence) == (False, reason, None)
        assert result.estimate is before
    assert update_estimate(before, look(np.zeros((2, 4))), UpdatePolicy(reject_above_rmsd_mm=51.0)).accepted


def test_looks_that_no_one_displacement_explains_do_not_match() -> None:
    first = look([[0.0, -np.inf]] * 2)
    second = look([[-np.inf, 0.0]] * 2, distances=[0.1, 0.5])
    before = apply(Estimate.of(Belief.uniform(2)), [first])
    assert update_estimate(before, second, POLICY).reason == "no_match"
    result = update_estimate(before, second, UpdatePolicy("nearest"))
    assert (result.accepted, result.reason) == (True, "nearest")
    assert result.belief.p.tolist() == [1.0, 0.0]


def test_nearest_begins_again() -> None:
    before = apply(Estimate.of(Belief.uniform(2), absent=0.3), [look(np.log([[0.5, 0.1], [0.1, 0.9]]))])
    before = replace(before, attempts=(Attempts(0, 1, 0),))
    after = update_estimate(before, look(np.full((2, 2), -np.inf)), UpdatePolicy("nearest")).estimate
    assert (after.places, after.attempts) == ((), ())
    assert after.log_odds_absent == before.log_odds_absent


# ------------------------------------------------------------------------------------------------------ absence


def test_absence_agrees_with_the_twin() -> None:
    rng = np.random.default_rng(5)
    estimate, absent = Estimate.of(Belief.uniform(3), absent=0.2), 0.2
    for evidence in random_looks(rng, 3, 4):
        result = update_estimate(estimate, replace(evidence, log_absent=-2.5), POLICY)
        assert result.log_evidence is not None
        absent = twin.absent_after(absent, -2.5, result.log_evidence)
        estimate = result.estimate
        assert estimate.absent == pytest.approx(absent, abs=1e-12)
    stated, plain = (
        apply(Estimate.of(Belief.uniform(3), absent=value), random_looks(np.random.default_rng(5), 3, 4))
        for value in (0.9, None)
    )
    assert stated.belief.p.tobytes() == plain.belief.p.tobytes()
    assert plain.absent is None


def test_a_scan_without_the_object_moves_absence_alone() -> None:
    before = apply(Estimate.of(Belief.uniform(2), absent=0.5), [look(np.zeros((2, 2)))])
    weights = np.log([[0.2, 0.2], [0.1, 0.1]])
    result = update_estimate(before, look(weights, log_absent=math.log(0.45), missed=True), POLICY)
    assert (result.accepted, result.reason, result.log_evidence) == (True, "nothing_seen", None)
    assert result.estimate.absent == pytest.approx(0.45 / 0.6)
    assert (result.belief, result.estimate.places) == (before.belief, before.places)


def test_a_scan_that_only_absence_explains_is_certain() -> None:
    before = Estimate.of(Belief.uniform(2), absent=0.01)
    impossible = look(np.full((2, 1), -np.inf), log_absent=-3.0)
    result = update_estimate(before, impossible, POLICY)
    assert (result.accepted, result.reason, result.estimate.absent) == (True, "no_match", 1.0)
    assert result.belief is before.belief
    neither = update_estimate(before, replace(impossible, log_absent=-math.inf), POLICY)
    assert (neither.accepted, neither.reason) == (False, "no_match")
    assert neither.estimate is before


def test_where_scans_without_the_object_are_evidence_they_move_both() -> None:
    before = Estimate.of(Belief.uniform(2), absent=0.5)
    weights = np.log([[0.2], [0.1]])
    policy = UpdatePolicy(on_nothing_seen="evidence")
    result = update_estimate(before, look(weights, log_absent=math.log(0.45), missed=True), policy)
    assert result.reason is None
    np.testing.assert_allclose(result.belief.p, [2.0 / 3.0, 1.0 / 3.0])
    assert result.estimate.absent == pytest.approx(0.45 / 0.6)


# ----------------------------------------------------------------------------------------------------- outcomes

TABLE = GraspTable.of_successes(["G", "H"], [[13, 0, 15], [2, 7, 11]], 15, 3)


def attempt(estimate: Estimate, grasp: int, success: bool, **more: Any) -> Update:
    return update_estimate_by_outcome(estimate, TABLE, grasp, success, POLICY, **more)


@few
@given(seed=seeds)
def test_repeated_attempts_follow_the_beta_binomial_distribution(seed: int) -> None:
    rng = np.random.default_rng(seed)
    outcomes = [(int(rng.integers(2)), bool(rng.integers(2))) for _ in range(6)]
    evidence = look(rng.uniform(-3.0, 0.0, (3, 4)))
    estimate = Estimate.of(Belief.uniform(3))
    for index, (grasp, success) in enumerate(outcomes):
        estimate = attempt(estimate, grasp, success).estimate
        if index == 2:
            estimate = update_estimate(estimate, evidence, POLICY).estimate
    counts = [[13, 0, 15], [2, 7, 11]]
    logs = [
        math.fsum(
            twin.log_attempts(counts[grasp][p], 15, outcomes.count((grasp, True)), outcomes.count((grasp, False)))
            for grasp in range(2)
        )
        for p in range(3)
    ]
    base = twin.bayes([1 / 3] * 3, logs)
    assert base is not None
    expected = twin.belief_of_places(base[0], twin_places([evidence]))
    assert expected is not None
    np.testing.assert_allclose(estimate.belief.p, expected[0], rtol=0, atol=1e-10)


def test_the_failure_of_a_grasp_that_never_failed_rules_no_pose_out() -> None:
    certain = Estimate.of(Belief.of([0.0, 0.05, 0.95]))
    ratios = []
    for _ in range(3):
        certain = attempt(certain, 0, False).estimate
        assert certain.belief.p[2] > 0.0
        ratios.append(certain.belief.p[2])
    # From 0.95, against a pose at which the grasp has failed 15 of 15 times.
    np.testing.assert_allclose(ratios, [0.380, 0.053, 0.008], atol=0.001)
    assert certain.attempts == (Attempts(0, 0, 3),)


def test_given_probabilities_weigh_as_they_are() -> None:
    table = GraspTable.of_probabilities(["G"], [[1.0, 0.25]], 2)
    once = update_estimate_by_outcome(Estimate.of(Belief.uniform(2)), table, 0, True, POLICY)
    twice = update_estimate_by_outcome(once.estimate, table, 0, True, POLICY)
    np.testing.assert_allclose(twice.belief.p, [16.0 / 17.0, 1.0 / 17.0])
    assert once.log_evidence == pytest.approx(math.log(0.625))
    sure = Estimate.of(Belief.of([1.0, 0.0]))
    failed = update_estimate_by_outcome(sure, table, 0, False, POLICY)
    assert (failed.accepted, failed.reason, failed.estimate is sure) == (False, "no_match", True)
    floored = update_estimate_by_outcome(sure, table, 0, False, UpdatePolicy(score_floor=0.02))
    assert floored.accepted


def test_an_object_that_may_have_moved_is_where_the_prior_says() -> None:
    start = Estimate.of(Belief.of([0.5, 0.3, 0.2]), absent=0.1)
    before = apply(start, [look(np.log([[0.1, 0.2], [0.5, 0.6], [0.9, 0.8]]), log_absent=-4.0)])
    still = attempt(before, 1, False)
    result = attempt(before, 1, False, object_moved=0.25, start=start)
    assert result.log_evidence == still.log_evidence
    np.testing.assert_allclose(result.belief.p, 0.75 * still.belief.p + 0.25 * start.belief.p)
    np.testing.assert_allclose(np.exp(result.belief.log_p), result.belief.p)
    assert (result.estimate.places, result.estimate.attempts) == ((), ())
    assert result.estimate.absent == pytest.approx(0.1)
    gone = attempt(before, 1, False, object_moved=1.0, start=start)
    np.testing.assert_allclose(gone.belief.p, start.belief.p)
    with pytest.raises(InvalidInput, match="object_moved: expected a number from 0 to 1"):
        attempt(before, 1, False, object_moved=1.5, start=start)
    with pytest.raises(InvalidInput, match="start: expected the estimate before the first observation"):
        attempt(before, 1, False, object_moved=0.5)


# ------------------------------------------------------------------------------------------------- whole scans


def test_scans_replay_to_the_same_bits_and_one_place_is_less_certain_than_many() -> None:
    lidar = lidar_of(120)
    poses = standing((0.0, 0.0, 0.0), (0.02, -0.03, 0.0), (0.05, 0.05, 0.0))
    sensors = tuple(SensorConfiguration(f"Q{i}", -0.4, 0.1 * i, 0.02) for i in range(2))
    predictor = predictor_of_mesh(box(0.2, 0.15, 0.2), poses, lidar)
    scenario = Scenario(
        poses,
        GraspTable.of_probabilities(["G"], [[0.5] * 3], 3),
        sensors,
        predictor,
        rule_of("beam", lidar, **defaults("beam", lidar, spread=True)),
        POLICY,
        Belief.uniform(3),
        spread=Spread(0.01, 0.05),
        seed="scenario",
    )
    rng = np.random.default_rng(1)
    off = predictor.predict_displaced(sensors[0], np.full((3, 1, 3), 0.01)).dense()[1]
    scan = Scan(off + 0.003 * rng.standard_normal(120), lidar.grid)

    def estimate(viewpoints: Sequence[SensorConfiguration], std: SensorUncertainty | None = None) -> Estimate:
        return apply(scenario.start, [scenario.evidence(scan, viewpoint, std) for viewpoint in viewpoints])

    again, other = sensors[0], replace(sensors[0], x=-0.43)
    same = estimate([sensors[0]] * 3)
    assert same.belief.p.tobytes() == estimate([sensors[0]] * 3).belief.p.tobytes()
    assert len(same.places) == 1
    near = replace(again, x=again.x + 0.01)
    assert [len(place.looks) for place in estimate([near, replace(near, y=near.y + 0.015), other]).places] == [2, 1]
    assert len(estimate([again, near]).places) == 2  # a listed sensor and a sensor pose never share one
    assert same.belief.entropy_nats > 0.0
    for first, second in itertools.pairwise([estimate([again] * count) for count in (1, 2, 3)]):
        assert not np.allclose(first.belief.p, second.belief.p)
