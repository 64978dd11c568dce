import math
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import sight_at_half_a_metre
from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.sight import Sight
from voa_core.updating import UpdatePolicy, nearest, update, update_by_outcome

BELIEF = Belief.of([0.25, 0.25, 0.5])
IMPOSSIBLE = np.full(3, -np.inf)


def evidence_of(
    log_weights: Any, distances: Any = (0.1, 0.2, 0.3), beams: int = 4, sight: Sight | None = None
) -> Evidence:
    array: Floats = np.array(log_weights, dtype=np.float64)[:, None]
    blind = sight_at_half_a_metre(np.zeros(0), np.zeros(3, dtype=np.intp))
    return Evidence(array, np.array(distances, dtype=np.float64), np.full(3, np.nan), beams, sight or blind)


def sight_of(seen: int, fewest: Any = (6, 9, 3)) -> Sight:
    """Nine beams on which every pose returns at 0.5 m, `seen` of which return there."""
    measured = np.where(np.arange(9) < seen, 0.5, np.inf)
    return sight_at_half_a_metre(measured, np.array(fewest))


@pytest.mark.parametrize(
    ("belief", "seen", "missed"),
    [
        ([0.5, 0.5, 0.0], 1, True),  # 6 are predicted at least: 2 must be seen
        ([0.5, 0.5, 0.0], 2, False),
        ([0.0, 1.0, 0.0], 2, True),  # 9 are predicted: 3 must be seen
        ([0.0, 1.0, 0.0], 3, False),
        ([0.4, 0.3, 0.3], 0, True),  # 3 are predicted at least: 1 must be seen
        ([0.4, 0.3, 0.3], 1, False),
    ],
)
def test_a_scan_without_the_object_is_not_accepted(belief: list[float], seen: int, missed: bool) -> None:
    before = Belief.of(belief)
    evidence = evidence_of(np.log([1.0, 0.5, 0.25]), sight=sight_of(seen))
    done = update(before, evidence, UpdatePolicy("nearest", 1e-3 if missed else None))
    assert done.reason == ("nothing_seen" if missed else None)
    assert done.accepted is not missed
    if missed:
        assert done.belief is before
        assert done.log_evidence is None
    assert update(before, evidence, UpdatePolicy(on_nothing_seen="evidence")).accepted


def test_two_predicted_returns_show_nothing_either_way() -> None:
    evidence = evidence_of(np.zeros(3), sight=sight_of(0, (2, 9, 9)))
    assert update(BELIEF, evidence, UpdatePolicy()).accepted


def test_an_accepted_scan_conditions_the_belief() -> None:
    done = update(BELIEF, evidence_of(np.log([1.0, 0.5, 0.25])), UpdatePolicy())
    assert (done.accepted, done.reason) == (True, None)
    np.testing.assert_allclose(done.belief.p, [0.5, 0.25, 0.25])
    assert done.log_evidence == pytest.approx(math.log(0.5))


@pytest.mark.parametrize("policy", [UpdatePolicy("reject", 0.001), UpdatePolicy("nearest", 0.001)])
def test_a_scan_without_beams_is_not_accepted_under_either_policy(policy: UpdatePolicy) -> None:
    done = update(BELIEF, evidence_of(np.zeros(3), np.zeros(3), 0), policy)
    assert (done.accepted, done.reason, done.log_evidence) == (False, "no_beams", None)
    assert done.belief is BELIEF


@pytest.mark.parametrize("on_no_match", ["reject", "nearest"])
def test_a_scan_that_fits_badly_is_not_accepted(on_no_match: Any) -> None:
    # The best RMSD is 0.1 m / sqrt(4) = 50 mm.
    evidence = evidence_of(IMPOSSIBLE)
    assert update(BELIEF, evidence, UpdatePolicy(on_no_match, 49.0)).reason == "bad_fit"
    assert update(BELIEF, evidence, UpdatePolicy(on_no_match, 49.0)).belief is BELIEF
    assert update(BELIEF, evidence, UpdatePolicy(on_no_match, 51.0)).reason != "bad_fit"


def test_a_fit_as_bad_as_the_limit_is_accepted() -> None:
    assert update(BELIEF, evidence_of(np.zeros(3), (0.5, 0.5, 0.5), 1), UpdatePolicy("reject", 500.0)).accepted


def test_reject_leaves_the_belief_as_it_was_where_nothing_matches() -> None:
    done = update(BELIEF, evidence_of(IMPOSSIBLE), UpdatePolicy("reject"))
    assert (done.accepted, done.reason, done.log_evidence) == (False, "no_match", None)
    assert done.belief is BELIEF


def test_nearest_shares_the_belief_among_the_poses_that_fit_about_as_well_as_the_best() -> None:
    done = update(BELIEF, evidence_of(IMPOSSIBLE, (0.1, 0.115, 0.3)), UpdatePolicy("nearest"))
    assert (done.accepted, done.reason, done.log_evidence) == (True, "nearest", None)
    assert done.belief.p.tolist() == [0.5, 0.5, 0.0]


def test_nearest_is_for_scans_that_no_possible_pose_explains() -> None:
    done = update(Belief.of([0.0, 0.5, 0.5]), evidence_of([0.0, -np.inf, -np.inf]), UpdatePolicy("nearest"))
    assert done.reason == "nearest"
    assert done.belief.p.tolist() == [1.0, 0.0, 0.0]


def test_nearest_compares_likenesses_with_0_015() -> None:
    likeness = np.array([0.9, 0.9 - 0.0149, 0.9 - 0.0151])
    assert nearest(-np.log(likeness)).p.tolist() == [0.5, 0.5, 0.0]


def test_an_outcome_that_no_possible_pose_allows_is_not_accepted() -> None:
    done = update_by_outcome(Belief.of([1.0, 0.0]), np.array([-np.inf, 0.0]))
    assert (done.accepted, done.reason, done.log_evidence) == (False, "no_match", None)
    assert done.belief.p.tolist() == [1.0, 0.0]


def test_an_outcome_conditions_the_belief() -> None:
    done = update_by_outcome(Belief.uniform(2), np.log([0.9, 0.3]))
    np.testing.assert_allclose(done.belief.p, [0.75, 0.25])
    assert done.log_evidence == pytest.approx(math.log(0.6))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"on_no_match": "ignore"}, "on_no_match: expected 'reject' or 'nearest', got 'ignore'"),
        ({"reject_above_rmsd_mm": 0.0}, "reject_above_rmsd_mm: expected a number above 0.0"),
        ({"score_floor": 0.6}, "score_floor: expected a number from 0 to 0.5, got 0.6"),
    ],
)
def test_a_policy_that_is_none_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        UpdatePolicy(**arguments)
