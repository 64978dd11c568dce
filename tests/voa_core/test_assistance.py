import math
from typing import Any

import numpy as np
import pytest

from tests.support import twin
from tests.voa_core.worlds import RULE_NAMES, as_lists, lidar_of, random_belief
from voa_core import choices
from voa_core.assistance import Assistance, Valuation, executed_value, value_of_assistance
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.pose_samples import PoseSample
from voa_core.prediction import Prediction
from voa_core.rules.registry import rule_of
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

LIDAR = lidar_of(1, range_max=2.0)
TABLE = GraspTable.of_probabilities(["left", "right"], [[0.9, 0.0, 0.4], [0.1, 0.8, 0.4]], 3)
APART = [0.5, 1.0, 1.5]
PAIR = [0.5, 0.5, 1.5]
"""Predicted ranges on the one beam: three scans that differ, or two that do not."""


def weigher_of(ranges: list[float], rule: str = "margin", **settings: Any) -> Weigher:
    prediction = Prediction.of_dense(LIDAR.grid, np.array(ranges)[:, None])
    dtype = settings.pop("dtype", np.float64)
    keep = settings.pop("keep", True)
    return Weigher.of(rule_of(rule, LIDAR, **settings), prediction, dtype, keep=keep)


def worth(weigher: Weigher, belief: list[float], policy: UpdatePolicy | None = None, **settings: Any) -> Assistance:
    table = settings.pop("table", TABLE)
    return value_of_assistance(weigher, Belief.of(belief), table, policy or UpdatePolicy(), **settings)


def test_a_look_that_distinguishes_all_poses_by_hand() -> None:
    look = worth(weigher_of(APART), [0.5, 0.25, 0.25])
    # Before: left 0.55, right 0.35. After: 0.9, 0.8, 0.4.
    assert look.expected_score_after == pytest.approx(0.75)
    assert look.voa == pytest.approx(0.2)
    assert look.outcomes.tolist() == [0, 1, 2]
    assert look.best_grasps.tolist() == [0, 1, 0]
    np.testing.assert_allclose(look.scores, [0.9, 0.8, 0.4])


def test_a_look_that_leaves_two_poses_together_by_hand() -> None:
    # P0 and P1 stay at odds of 2 to 1: left 0.6, right 1/3. Then 0.4 at P2. In all 0.55, as before.
    assert worth(weigher_of(PAIR), [0.5, 0.25, 0.25]).voa == pytest.approx(0.0, abs=1e-15)


def test_executed_scores_the_grasp_at_the_pose_that_gave_the_scan() -> None:
    table = GraspTable.of_probabilities(["left", "right"], [[0.9, 0.0, 0.2], [0.1, 0.8, 0.5]], 3)
    look = worth(weigher_of(PAIR), [0.5, 0.25, 0.25], table=table, definition="executed")
    # Left after the first two scans, right after the third; left without a look.
    assert look.best_grasps.tolist() == [0, 0, 1]
    assert look.expected_score_after == pytest.approx(0.5 * 0.9 + 0.25 * 0.0 + 0.25 * 0.5)
    assert look.voa == pytest.approx(0.25 * (0.5 - 0.2))


def test_a_look_may_be_worth_less_than_nothing_and_is_not_clamped() -> None:
    # The sensor agent knows that it is P1; the gripper agent all but rules P1 out and takes the scan for P0's.
    belief, sure = Belief.of([0.5, 0.05, 0.45]), Belief.of([0.0, 1.0, 0.0])
    table = GraspTable.of_probabilities(["left", "right"], [[0.9, 0.0, 0.0], [0.0, 0.8, 0.9]], 3)
    look = value_of_assistance(
        weigher_of(PAIR), belief, table, UpdatePolicy(), definition="executed", sensor_belief=sure
    )
    assert look.best_grasps.tolist() == [0]
    assert look.voa == pytest.approx(0.0)
    right_first = GraspTable.of_probabilities(["left", "right"], [[0.9, 0.0, 0.0], [0.0, 0.8, 1.0]], 3)
    keen = Belief.of([0.45, 0.05, 0.5])
    worse = value_of_assistance(
        weigher_of(PAIR), keen, right_first, UpdatePolicy(), definition="executed", sensor_belief=sure
    )
    assert worse.voa == pytest.approx(-0.8)


@pytest.mark.parametrize("keep", [True, False])
def test_a_scan_that_the_gripper_agent_holds_impossible_leaves_it_as_it_is_under_reject(keep: bool) -> None:
    look = worth(weigher_of(APART, keep=keep), [0.5, 0.5, 0.0], sensor_belief=Belief.of([0.0, 0.0, 1.0]))
    assert look.outcomes.tolist() == [2]
    assert look.best_grasps.tolist() == [0]
    assert look.voa == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("keep", [True, False])
def test_a_scan_that_the_gripper_agent_holds_impossible_is_believed_under_nearest(keep: bool) -> None:
    policy, sure = UpdatePolicy("nearest"), Belief.of([0.0, 0.0, 1.0])
    look = worth(weigher_of(APART, keep=keep), [0.5, 0.5, 0.0], policy, sensor_belief=sure)
    np.testing.assert_allclose(look.scores, [0.4])
    assert look.voa == pytest.approx(0.4 - 0.45)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("keep", [True, False])
def test_weights_that_underflow_still_distinguish_poses(dtype: type[np.floating], keep: bool) -> None:
    # Seen from P2, the possible poses are 100 and 50 standard deviations off: e^-5000 and e^-1250.
    weigher = weigher_of(APART, "gaussian", sigma_m=0.01, dtype=dtype, keep=keep)
    look = worth(weigher, [0.5, 0.5, 0.0], sensor_belief=Belief.of([0.0, 0.0, 1.0]))
    assert look.best_grasps.tolist() == [1]
    np.testing.assert_allclose(look.scores, [0.8], atol=1e-12)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_score_that_underflows_is_still_a_reason_to_grasp_when_executed(dtype: type[np.floating]) -> None:
    # After P2's scan the belief is all on P0, where the grasp fails, but for e^-200 on P1: 0 in float32.
    table = GraspTable.of_probabilities(["only"], [[0.0, 0.8, 0.7]], 3)
    weigher = weigher_of([1.5, 0.5, 1.5], "gaussian", sigma_m=0.05, dtype=dtype)
    sure = Belief.of([0.0, 0.0, 1.0])
    look = worth(weigher, [0.5, 0.5, 0.0], table=table, definition="executed", sensor_belief=sure)
    assert look.best_grasps.tolist() == [0]
    assert look.expected_score_after == pytest.approx(0.7)


def test_float32_does_not_decide_between_grasps_that_it_cannot_distinguish_when_executed() -> None:
    # At P0 the second grasp is better by 1e-8: less than a float32 sees, and worth 0.6 at the pose itself.
    table = GraspTable.of_probabilities(["first", "second"], [[0.5, 0.5, 0.2], [0.5 + 1e-8, 0.4, 0.8]], 3)
    weigher = weigher_of([0.5, 1.0, 0.5], dtype=np.float32)
    sure = Belief.of([0.0, 0.0, 1.0])
    look = worth(weigher, [0.5, 0.5, 0.0], table=table, definition="executed", sensor_belief=sure)
    assert look.best_grasps.tolist() == [1]
    assert look.voa == pytest.approx(0.6)


def test_float32_does_not_decide_by_its_own_rounding_when_executed() -> None:
    # The second grasp is better by 2e-9, but its two shares are rounded down in float32 and the first's one is rounded
    # up: there the first is better by 3e-8, a whole last place.
    place = 2.0**-24  # between float32s at twice these shares
    first, second = [0.75 + 0.6 * place, 0.0, 0.2], [0.5 + 0.45 * place, 0.25 + 0.2 * place, 0.8]
    table = GraspTable.of_probabilities(["first", "second"], [first, second], 3)
    halves = (0.5 * table.scores[:, :2]).astype(np.float32).sum(axis=1)
    assert halves[0] > halves[1]
    look = worth(
        weigher_of([0.5, 0.5, 0.5], dtype=np.float32),
        [0.5, 0.5, 0.0],
        table=table,
        definition="executed",
        sensor_belief=Belief.of([0.0, 0.0, 1.0]),
    )
    assert look.best_grasps.tolist() == [1]
    assert look.voa == 0.0


@pytest.mark.parametrize(
    ("dtype", "worse_by", "chosen"),
    [(np.float64, 5e-13, 0), (np.float64, 2e-12, 1), (np.float32, 5e-7, 0), (np.float32, 2e-6, 1)],
)
def test_the_first_grasp_is_chosen_if_it_is_as_good_within_the_precision(
    dtype: type[np.floating], worse_by: float, chosen: int
) -> None:
    table = GraspTable.of_probabilities(["first", "second"], [[0.5 - worse_by] * 3, [0.5] * 3], 3)
    assert worth(weigher_of(PAIR, dtype=dtype), [1.0, 0.0, 0.0], table=table).best_grasps.tolist() == [chosen]


@pytest.mark.parametrize("definition", ["posterior", "executed"])
def test_where_every_grasp_fails_a_look_is_worth_nothing(definition: Any) -> None:
    nothing = GraspTable.of_probabilities(["left", "right"], np.zeros((2, 3)), 3)
    look = worth(weigher_of(APART), [0.5, 0.25, 0.25], table=nothing, definition=definition)
    assert (look.voa, look.expected_score_after) == (0.0, 0.0)
    assert look.best_grasps.tolist() == [-1, -1, -1]
    assert look.scores.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("definition", ["posterior", "executed"])
def test_no_grasp_scores_0_where_only_some_looks_leave_none(definition: Any) -> None:
    table = GraspTable.of_probabilities(["left"], [[0.9, 0.0, 0.0]], 3)
    look = worth(weigher_of(APART), [0.5, 0.25, 0.25], table=table, definition=definition)
    assert look.best_grasps.tolist() == [0, -1, -1]
    assert look.voa == pytest.approx(0.0, abs=1e-15)


def test_equal_grasps_go_to_the_first_listed() -> None:
    table = GraspTable.of_probabilities(["a", "b", "c"], [[0.2, 0.5, 0.7], [0.9, 0.5, 0.7], [0.9, 0.1, 0.7]], 3)
    for dtype in (np.float64, np.float32):
        assert worth(weigher_of(APART, dtype=dtype), [0.5, 0.25, 0.25], table=table).best_grasps.tolist() == [1, 0, 0]


@pytest.mark.parametrize("rule", RULE_NAMES)
@pytest.mark.parametrize("keep", [True, False])
@pytest.mark.parametrize("support", [1, 3, 6, 10])
@pytest.mark.parametrize("block_bytes", [1, 2**26])
def test_neither_the_share_of_possible_poses_nor_blocks_matter(
    rule: str, keep: bool, support: int, block_bytes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(choices, "_BLOCK_BYTES", block_bytes)
    rng = np.random.default_rng(support)
    ranges = [float(value) for value in rng.choice([0.3, 0.5, 0.9, 1.4], 10)]
    table = GraspTable.of_probabilities(["a", "b", "c"], rng.uniform(size=(3, 10)), 10)
    belief = random_belief(rng, 10, support)
    weigher = weigher_of(ranges, rule, keep=keep)
    parameters = {**vars(weigher.rule)}
    logs = [[twin.log_weight(rule, parameters, [seen], [expected]) for expected in ranges] for seen in ranges]
    distances = [[twin.distance([seen], [expected], 2.0) for expected in ranges] for seen in ranges]
    for definition in ("posterior", "executed"):
        value = worth(weigher, list(belief), table=table, definition=definition)
        expected = twin.value_of_assistance(
            as_lists(table.scores), list(belief), logs, distances, definition=definition
        )
        assert value.voa == pytest.approx(expected, abs=1e-12)
        assert value.outcomes.tolist() == np.flatnonzero(belief).tolist()


def test_other_definitions_are_refused() -> None:
    with pytest.raises(InvalidInput, match="definition: expected 'posterior' or 'executed', got 'prior'"):
        worth(weigher_of(APART), [0.5, 0.25, 0.25], definition="prior")


def test_executed_value_by_hand() -> None:
    after = [Belief.of([1.0, 0.0, 0.0]), Belief.of([0.5, 0.5, 0.0]), Belief.of([0.0, 0.0, 1.0])]
    # 0.5 * 0.9 + 0.25 * max(0.45, 0.45) + 0.25 * 0.4, less 0.55.
    value = executed_value(Belief.of([0.5, 0.25, 0.25]), after, TABLE)
    assert value == pytest.approx(0.45 + 0.1125 + 0.1 - 0.55)
    assert math.isfinite(value)


@pytest.mark.parametrize("definition", ["posterior", "executed"])
@pytest.mark.parametrize("excluded", [0, 5, 10])
def test_values_by_weights_that_are_kept_are_those_by_weights_that_are_computed(definition: Any, excluded: int) -> None:
    """Five poses of 15 that are excluded take part in the products all the same, ten do not."""
    random = np.random.default_rng(9)
    prediction = Prediction.of_dense(LIDAR.grid, random.uniform(0.3, 1.9, (15, 1)))
    table = GraspTable.of_probabilities([f"g{each}" for each in range(20)], random.random((20, 15)), 15)
    masses = np.where(np.arange(15) < excluded, 0.0, random.random(15))
    belief = Belief.of(masses / masses.sum())
    rule, policy = rule_of("exponential", LIDAR), UpdatePolicy()
    both = (Weigher.of(rule, prediction, np.float64, keep=keep) for keep in (True, False))
    values = [value_of_assistance(each, belief, table, policy, definition=definition).voa for each in both]
    if excluded == 0:
        assert values[0] == values[1], "all weights are computed at once, in the same way"
    assert values[0] == pytest.approx(values[1], abs=1e-14)


@pytest.mark.parametrize("definition", ["posterior", "executed"])
@pytest.mark.parametrize("keep", [True, False])
def test_a_sample_of_all_poses_in_any_order_gives_the_value_over_all_poses(keep: bool, definition: Any) -> None:
    random = np.random.default_rng(0)
    prediction = Prediction.of_dense(LIDAR.grid, random.uniform(0.3, 1.9, (15, 6)))
    table = GraspTable.of_probabilities([f"g{each}" for each in range(5)], random.random((5, 15)), 15)
    belief = Belief.of(random.dirichlet(np.ones(15)))
    look = Weigher.of(rule_of("gaussian", LIDAR), prediction, np.float64, keep=keep)
    every = PoseSample.of(belief.p, random.permutation(15), 20, "any")
    assert every.poses.tolist() != sorted(every.poses)
    values = [
        Valuation(belief, table, UpdatePolicy(), definition, sample=sample).value(look).voa for sample in (None, every)
    ]
    assert values[0] > 0.01
    assert values[1] == pytest.approx(values[0], abs=1e-14)
