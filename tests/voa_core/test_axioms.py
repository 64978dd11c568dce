"""The axioms of deploy/docs/mathematics.md, for every update rule, and agreement with the brute-force twin."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from tests.support import twin
from tests.voa_core.worlds import (
    BOX_FACES,
    HERE,
    RULE_NAMES,
    World,
    as_lists,
    box,
    data_predictor,
    diagonal,
    lidar_of,
    parameters_of,
    random_belief,
    worlds,
)
from voa_core.assistance import Definition, executed_value, value_of_assistance
from voa_core.checks import Floats
from voa_core.evidence import Evidence, evidence_of_scan
from voa_core.filtering import Belief, condition
from voa_core.grasps import GraspTable, log_outcome_weights
from voa_core.kernels import Array
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.ranking import rank
from voa_core.scans import Scan
from voa_core.updating import UpdatePolicy, update, update_by_outcome

every_rule = pytest.mark.parametrize("rule_name", RULE_NAMES)
few = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
more = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])

DEFINITIONS: tuple[Definition, Definition] = ("posterior", "executed")


@st.composite
def measured(draw: st.DrawFn, world: World) -> Floats:
    """A scan near one of the world's predictions, with missing beams, false returns and no-returns."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    scan: Floats = world.ranges[rng.integers(len(world.ranges))].copy()
    scan += rng.integers(-2, 3, scan.shape) / 512.0
    kind = rng.uniform(size=scan.shape)
    scan[kind < 0.1] = np.nan
    scan[(kind >= 0.1) & (kind < 0.2)] = np.inf
    odd = (kind >= 0.2) & (kind < 0.3)
    scan[odd] = rng.uniform(0.1, 1.9, odd.sum())
    return scan


def evidence_in(world: World, ranges: Floats) -> Evidence:
    predictor = data_predictor(world.ranges, world.lidar)
    return evidence_of_scan(Scan(ranges, world.lidar.grid), HERE, predictor, world.rule, listed=True)


def twin_log_weights(world: World, scans: Floats) -> list[list[float]]:
    return [
        [twin.log_weight(world.rule_name, world.parameters, scan, predicted) for predicted in as_lists(world.ranges)]
        for scan in as_lists(scans)
    ]


def twin_distances(world: World, scans: Floats) -> list[list[float]]:
    no_return_m = world.parameters["no_return_m"]
    return [[twin.distance(scan, predicted, no_return_m) for predicted in as_lists(world.ranges)] for scan in scans]


def twin_voa(world: World, definition: str) -> float:
    return twin.value_of_assistance(
        as_lists(world.scores),
        list(world.belief),
        twin_log_weights(world, world.ranges),
        twin_distances(world, world.ranges),
        on_no_match=world.on_no_match,
        definition=definition,
        sensor_belief=None if world.sensor_belief is None else list(world.sensor_belief),
    )


def voa_of(world: World, definition: Definition, dtype: type[np.floating] = np.float64, *, keep: bool = True) -> float:
    return value_of_assistance(
        world.weigher(dtype, keep=keep),
        Belief.of(world.belief),
        world.table,
        world.policy,
        definition=definition,
        sensor_belief=world.sensor,
    ).voa


def assert_is_belief(belief: Belief) -> None:
    assert np.isfinite(belief.p).all()
    assert (belief.p >= 0.0).all()
    assert belief.p.sum() == pytest.approx(1.0, abs=1e-12)


# ------------------------------------------------------------------------------------------------------ beliefs


@every_rule
@more
@given(data=st.data())
def test_a_belief_is_finite_non_negative_and_sums_to_1_after_anything(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    belief = Belief.of(world.belief)
    for _ in range(data.draw(st.integers(1, 4))):
        if data.draw(st.booleans()):
            belief = update(belief, evidence_in(world, data.draw(measured(world))), world.policy).belief
        else:
            scores = world.scores[data.draw(st.integers(0, len(world.scores) - 1))]
            floor = data.draw(st.sampled_from([0.0, 0.02]))
            belief = update_by_outcome(belief, log_outcome_weights(scores, data.draw(st.booleans()), floor)).belief
        assert_is_belief(belief)


@every_rule
@few
@given(data=st.data())
def test_a_scan_that_all_poses_explain_alike_changes_nothing(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    same = np.repeat(world.ranges[:1], len(world.ranges), axis=0)
    done = update(Belief.of(world.belief), evidence_in(replaced(world, same), same[0]), world.policy)
    assert done.accepted
    np.testing.assert_allclose(done.belief.p, world.belief, rtol=0, atol=1e-12)


@more
@given(seed=st.integers(0, 2**32 - 1), log_constant=st.floats(-5000.0, 5000.0))
def test_a_positive_constant_weight_changes_nothing_but_the_evidence(seed: int, log_constant: float) -> None:
    rng = np.random.default_rng(seed)
    belief = Belief.of(random_belief(rng, 6, int(rng.integers(1, 7))))
    weights = rng.uniform(-5.0, 0.0, 6)
    plain, shifted = condition(belief, weights), condition(belief, weights + log_constant)
    assert plain is not None
    assert shifted is not None
    np.testing.assert_allclose(shifted.belief.p, plain.belief.p, rtol=0, atol=1e-12)
    assert shifted.log_evidence == pytest.approx(plain.log_evidence + log_constant, abs=1e-9)


@st.composite
def explained(draw: st.DrawFn, world: World) -> Floats:
    """A scan within the margin of a pose that the belief holds possible; its first beam is not missing."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    pose = int(np.argmax(world.belief))
    scan: Floats = world.ranges[pose] + rng.integers(-4, 5, world.ranges.shape[1]) / 512.0
    scan[1:][rng.uniform(size=len(scan) - 1) < 0.3] = np.nan
    return scan


@every_rule
@few
@given(data=st.data())
def test_scans_commute(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    scans = explained(world) if rule_name == "margin" else st.one_of(explained(world), measured(world))
    evidence = [evidence_in(world, data.draw(scans)) for _ in range(3)]
    assume(all(each.beams_compared for each in evidence))
    results = []
    for order in ([0, 1, 2], [2, 0, 1], [2, 1, 0]):
        belief = Belief.of(world.belief)
        for index in order:
            done = update(belief, evidence[index], world.policy)
            assert done.reason in (None, "nothing_seen")
            belief = done.belief
        results.append(belief.p)
    for result in results[1:]:
        np.testing.assert_allclose(result, results[0], rtol=0, atol=1e-12)


@more
@given(seed=st.integers(0, 2**32 - 1), nats=st.sampled_from([1.0, 100.0, 1000.0, 4000.0]))
def test_observations_commute_though_they_contradict_each_other_by_thousands_of_nats(seed: int, nats: float) -> None:
    rng = np.random.default_rng(seed)
    first = np.round(rng.uniform(-nats, 0.0, 5))
    # The second all but takes back what the first said, so that the answer hangs on what underflowed between.
    looks = [first, -nats - first + rng.uniform(-2.0, 0.0, 5), rng.uniform(-1.0, 0.0, 5)]
    results = []
    for order in ([0, 1, 2], [1, 2, 0], [2, 1, 0]):
        belief = Belief.of(random_belief(np.random.default_rng(seed), 5, 4))
        for index in order:
            posterior = condition(belief, looks[index])
            assert posterior is not None
            belief = posterior.belief
            assert_is_belief(belief)
        results.append(belief.p)
    for result in results[1:]:
        np.testing.assert_allclose(result, results[0], rtol=0, atol=1e-12)


def test_a_pose_whose_probability_underflows_comes_back() -> None:
    belief = Belief.uniform(2)
    for weights in ([0.0, -3000.0], [-3000.0, 0.0]):
        posterior = condition(belief, np.array(weights))
        assert posterior is not None
        belief = posterior.belief
    np.testing.assert_allclose(belief.p, [0.5, 0.5], rtol=0, atol=1e-12)


# ---------------------------------------------------------------------------------------------------------- VOA


@few
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 7), m=st.integers(1, 4))
def test_a_look_that_distinguishes_all_poses_is_worth_the_best_grasp_of_each(seed: int, n: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    world = world_of(rng, "margin", diagonal(rng, n), rng.uniform(size=(m, n)))
    before = max(twin.expected_score(row, list(world.belief)) for row in as_lists(world.scores))
    expected = sum(world.belief[p] * world.scores[:, p].max() for p in range(n)) - before
    for definition in DEFINITIONS:
        assert voa_of(world, definition) == pytest.approx(expected, abs=1e-12)


@every_rule
@few
@given(data=st.data())
def test_a_look_that_distinguishes_no_poses_is_worth_nothing(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    world = replaced(world, np.repeat(world.ranges[:1], len(world.ranges), axis=0))
    assert voa_of(world, "posterior") == pytest.approx(0.0, abs=1e-12)
    assert voa_of(world, "executed") == pytest.approx(0.0, abs=1e-12)


@every_rule
@few
@given(data=st.data())
def test_permuting_the_poses_permutes_posteriors_and_keeps_voa(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    scan = data.draw(measured(world))
    order = np.array(data.draw(st.permutations(range(len(world.belief)))))
    permuted = World(
        world.rule_name,
        world.parameters,
        world.lidar,
        world.ranges[order],
        world.scores[:, order],
        world.belief[order],
        None if world.sensor_belief is None else world.sensor_belief[order],
        world.on_no_match,
    )
    done = update(Belief.of(world.belief), evidence_in(world, scan), world.policy)
    again = update(Belief.of(permuted.belief), evidence_in(permuted, scan), world.policy)
    np.testing.assert_allclose(again.belief.p, done.belief.p[order], rtol=0, atol=1e-12)
    for definition in DEFINITIONS:
        assert voa_of(permuted, definition) == pytest.approx(voa_of(world, definition), abs=1e-12)


@every_rule
@few
@given(data=st.data())
def test_permuting_the_grasps_permutes_the_choice_and_keeps_voa(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    order = np.array(data.draw(st.permutations(range(len(world.scores)))))
    belief = Belief.of(world.belief)
    table = GraspTable.of_probabilities([f"G{x}" for x in order], world.scores[order], len(world.belief))
    for definition in DEFINITIONS:
        plain = value_of_assistance(world.weigher(), belief, world.table, world.policy, definition=definition)
        permuted = value_of_assistance(world.weigher(), belief, table, world.policy, definition=definition)
        assert permuted.voa == pytest.approx(plain.voa, abs=1e-12)
        chosen = [None if x < 0 else table.names[x] for x in permuted.best_grasps]
        assert chosen == [None if x < 0 else world.table.names[x] for x in plain.best_grasps]


@every_rule
@few
@given(data=st.data())
def test_permuting_the_sensors_permutes_the_looks(rule_name: str, data: Any) -> None:
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    base = data.draw(worlds(rule_name))
    weighers = {f"A{a}": replaced(base, rng.uniform(0.2, 1.9, base.ranges.shape)).weigher() for a in range(4)}
    sensors = [SensorConfiguration(name, 0.0, 0.0, 0.0, cost=0.01 * a) for a, name in enumerate(weighers)]

    def worth(listed: list[SensorConfiguration]) -> dict[str, float]:
        ranking = rank(listed, lambda s: weighers[s.name], Belief.of(base.belief), base.table, base.policy)
        values = [look.net_value for look in ranking.looks]
        assert values == sorted(values, reverse=True)
        return {look.sensor.name: look.net_value for look in ranking.looks}

    shuffled = worth(data.draw(st.permutations(sensors)))
    assert shuffled == worth(sensors)


# --------------------------------------------------------------------------------------------------- the twin


@every_rule
@more
@given(data=st.data())
def test_updates_agree_with_the_twin(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    scan = data.draw(measured(world))
    limit = data.draw(st.sampled_from([None, 1.0, 50.0]))
    evidence = evidence_in(world, scan)
    lists, no_return_m = as_lists(world.ranges), world.parameters["no_return_m"]
    limits: Any = {"zero": "missing", "range_min": world.lidar.range_min, "range_max": world.lidar.range_max}
    beams = [twin.classify_beam(value, False, **limits) for value in scan]
    used = len(twin.compared(beams))
    assert evidence.beams_compared == used
    if used:
        np.testing.assert_allclose(evidence.log_weights, twin_log_weights(world, np.array([beams]))[0], atol=1e-11)
        np.testing.assert_allclose(evidence.distances, twin_distances(world, np.array([beams]))[0], atol=1e-12)
    log_weights = twin_log_weights(world, np.array([beams]))[0] if used else [0.0] * len(lists)
    distances = twin_distances(world, np.array([beams]))[0]
    assert distances[evidence.best_fit] == pytest.approx(distances[twin.best_fit(log_weights, distances)], abs=1e-9)
    best = lists[evidence.best_fit]
    for ours, theirs in (
        (evidence.fit_rmsd_mm, twin.fit_rmsd_mm(beams, best, no_return_m)),
        (evidence.fit_hit_rmsd_mm, twin.fit_hit_rmsd_mm(beams, best, no_return_m)),
    ):
        assert ours == (None if theirs is None else pytest.approx(theirs, abs=1e-9))
    nothing_seen = twin.misses_object(beams, [[scan] for scan in lists], list(world.belief), has_workspace=False)
    policy = UpdatePolicy(world.on_no_match, reject_above_rmsd_mm=limit)
    done = update(Belief.of(world.belief), evidence, policy)
    expected = twin.update(
        list(world.belief),
        log_weights,
        distances,
        used,
        on_no_match=world.on_no_match,
        reject_above_rmsd_mm=limit,
        nothing_seen=nothing_seen,
    )
    assert (done.accepted, done.reason) == (expected.accepted, expected.reason)
    np.testing.assert_allclose(done.belief.p, expected.belief, rtol=0, atol=1e-12)
    if expected.log_evidence is None:
        assert done.log_evidence is None
    else:
        assert done.log_evidence == pytest.approx(expected.log_evidence, abs=1e-11)


@few
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 6),
    success=st.booleans(),
    score_floor=st.sampled_from([0.0, 0.02, 0.5]),
)
def test_grasp_outcomes_agree_with_the_twin(seed: int, n: int, success: bool, score_floor: float) -> None:
    rng = np.random.default_rng(seed)
    belief = random_belief(rng, n, int(rng.integers(1, n + 1)))
    scores = rng.integers(0, 4, n) / 3.0
    done = update_by_outcome(Belief.of(belief), log_outcome_weights(scores, success, score_floor))
    expected = twin.update_by_outcome(list(belief), list(scores), success, score_floor)
    assert (done.accepted, done.reason) == (expected.accepted, expected.reason)
    np.testing.assert_allclose(done.belief.p, expected.belief, rtol=0, atol=1e-12)
    if expected.log_evidence is None:
        assert done.log_evidence is None
    else:
        assert done.log_evidence == pytest.approx(expected.log_evidence, abs=1e-12)


@every_rule
@more
@given(data=st.data())
def test_voa_agrees_with_the_twin_to_1e_12_in_float64(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    for definition in DEFINITIONS:
        expected = twin_voa(world, definition)
        assert voa_of(world, definition, keep=True) == pytest.approx(expected, abs=1e-12)
        assert voa_of(world, definition, keep=False) == pytest.approx(expected, abs=1e-12)


@every_rule
@more
@given(data=st.data())
def test_voa_agrees_with_the_twin_to_1e_5_in_float32(rule_name: str, data: Any) -> None:
    world = data.draw(worlds(rule_name))
    for definition in DEFINITIONS:
        expected = twin_voa(world, definition)
        assert voa_of(world, definition, np.float32, keep=True) == pytest.approx(expected, abs=1e-5)
        assert voa_of(world, definition, np.float32, keep=False) == pytest.approx(expected, abs=1e-5)


@few
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), m=st.integers(1, 4))
def test_executed_values_agree_with_the_twin(seed: int, n: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    belief, scores = random_belief(rng, n, int(rng.integers(1, n + 1))), rng.uniform(size=(m, n))
    after = [random_belief(rng, n, int(rng.integers(1, n + 1))) for _ in range(n)]
    table = GraspTable.of_probabilities([f"G{x}" for x in range(m)], scores, n)
    value = executed_value(Belief.of(belief), [Belief.of(each) for each in after], table)
    expected = twin.executed_value(as_lists(scores), list(belief), [list(each) for each in after])
    assert value == pytest.approx(expected, abs=1e-12)


@every_rule
@few
@given(data=st.data())
def test_rankings_with_costs_agree_with_the_twin(rule_name: str, data: Any) -> None:
    base = data.draw(worlds(rule_name))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    # Every second look repeats the one before it, so there are ties for the order of listing to decide.
    ranges = [rng.uniform(0.2, 1.9, base.ranges.shape) for _ in range(3)]
    each = [replaced(base, ranges[a // 2]) for a in range(6)]
    costs = [float(cost) for cost in rng.integers(0, 2, 3) / 64.0 for _ in range(2)]
    sensors = [SensorConfiguration(str(a), 0.0, 0.0, 0.0, cost=cost) for a, cost in enumerate(costs)]
    ranking = rank(
        sensors,
        lambda sensor: each[int(sensor.name)].weigher(),
        Belief.of(base.belief),
        base.table,
        base.policy,
        sensor_belief=base.sensor,
    )
    values = [twin_voa(world, "posterior") for world in each]
    assert [int(look.sensor.name) for look in ranking.looks] == twin.ranking(values, costs)
    index, score = twin.best_grasp(as_lists(base.scores), list(base.belief))
    assert ranking.before.index == index
    assert ranking.before.expected_score == pytest.approx(score, abs=1e-12)


@st.composite
def grids(draw: st.DrawFn) -> BeamGrid:
    """Whole turns, partial fields of view, more than a turn, either way round, from one beam on."""
    beams = draw(st.sampled_from([1, 4, 9, 24]))
    spacing = draw(st.sampled_from([2.0 * math.pi / beams, 0.05, 0.37])) * draw(st.sampled_from([1.0, -1.0]))
    return BeamGrid(beams, draw(st.sampled_from([0.0, -math.pi, 1.0])), spacing)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(seed=st.integers(0, 2**32 - 1), grid=grids())
def test_predictions_agree_with_the_twins_ray_caster(seed: int, grid: BeamGrid) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = random_mesh(rng)
    height = float(rng.uniform(-0.2, 0.2))
    quaternions = rng.normal(size=(2, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    poses = PoseSet.from_arrays(["A", "B"], rng.uniform(-0.2, 0.2, (2, 3)), quaternions)
    x, y, yaw = (float(v) for v in rng.uniform([-1.0, -1.0, -4.0], [1.0, 1.0, 4.0]) * rng.choice([0.1, 1.0]))
    lidar = LidarModel(grid, 0.0, 1.2, height, "missing", 0.01, 0.02, 0.05)
    predictor = predictor_of_mesh(Object.from_arrays(vertices, faces), poses, lidar)
    predicted = predictor.predict(SensorConfiguration("s", x, y, yaw)).dense()
    assert poses.positions is not None
    for pose, ours in enumerate(predicted):
        around = [
            twin.cast(
                vertices, faces, poses.positions[pose], quaternions[pose], (x, y, yaw), height, grid.angles + off, 1.2
            )
            for off in (-1e-9, 0.0, 1e-9)
        ]
        before, at, after = np.minimum(around, 1e3)
        same = np.abs(np.minimum(ours, 1e3) - at) <= 1e-8
        # On the brink of an edge, or of the range limit, a rounding decides which side of it is seen; so it does for
        # any ray caster.
        brink = np.maximum(np.abs(before - at), np.abs(after - at)) > 1e-8
        either = np.abs(np.minimum(ours, 1e3) - np.minimum(around, 1e3)).min(axis=0) <= 1e-6
        assert (same | (brink & either)).all()


def random_mesh(rng: np.random.Generator) -> tuple[Floats, list[list[int]]]:
    """A few triangles anywhere, and a box with skewed sides: neither closed as a whole nor convex."""
    corners: Floats = rng.uniform(-0.3, 0.3, (3 * int(rng.integers(0, 6)), 3))
    loose = np.arange(len(corners)).reshape(-1, 3)
    skewed = box(1.0, 1.0, 1.0).vertices @ rng.uniform(-0.4, 0.4, (3, 3))
    return np.concatenate([corners, skewed]), [*loose.tolist(), *(np.array(BOX_FACES) + len(corners)).tolist()]


def replaced(world: World, ranges: Array) -> World:
    return World(
        world.rule_name,
        world.parameters,
        world.lidar,
        ranges,
        world.scores,
        world.belief,
        world.sensor_belief,
        world.on_no_match,
    )


def world_of(rng: np.random.Generator, rule_name: str, ranges: Floats, scores: Floats) -> World:
    lidar = lidar_of(ranges.shape[1])
    n = len(ranges)
    belief = random_belief(rng, n, int(rng.integers(1, n + 1)))
    return World(rule_name, parameters_of(rule_name, lidar), lidar, ranges, scores, belief, None, "reject")
