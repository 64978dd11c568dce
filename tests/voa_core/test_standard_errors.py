import numpy as np
import pytest

from voa_core.grasps import GraspTable
from voa_core.standard_errors import score_standard_error, standard_error


def test_variances_of_scores_are_those_of_a_beta_distribution() -> None:
    rng = np.random.default_rng(3)
    counts = np.array([[0, 7, 15]])
    drawn = rng.beta(counts + 0.5, 15 - counts + 0.5, (200_000, 1, 3))
    variances = GraspTable.of_successes(["a"], counts, 15, 3).score_variances
    assert variances is not None
    np.testing.assert_allclose(variances, drawn.var(axis=0), rtol=0.02)
    assert GraspTable.of_probabilities(["a"], [[0.5]], 1).score_variances is None


def test_standard_errors_by_hand() -> None:
    shares = np.array([0.75, 0.25])
    # Of one scan more, after which nothing is gained, 3/4 is at the first pose and 1/4 at the second.
    mean = 1.0 / 2.75
    first = ((1.0 - mean) ** 2 + mean**2 + 0.75 * mean**2) / 1.75
    mean = 1.0 / 2.25
    second = (2.0 * (0.5 - mean) ** 2 + 0.25 * mean**2) / 1.25
    by_hand = np.sqrt(0.75**2 * first / 2 + 0.25**2 * second / 2)
    assert standard_error(shares, np.array([[1.0, 0.0], [0.5, 0.5]])) == pytest.approx(by_hand)
    # One scan of each pose: the mean is 0.75.
    of_one = np.sqrt((0.75 * 0.25) ** 2 + (0.25 * 0.75) ** 2)
    assert standard_error(shares, np.array([[1.0], [0.0]])) == pytest.approx(of_one)
    assert standard_error(np.zeros(0), np.zeros((0, 1))) == 0.0


def test_scans_that_agree_leave_an_error_of_the_order_of_one_scan() -> None:
    shares = np.full(8, 1 / 8)
    error = standard_error(shares, np.full((8, 32), 0.5))
    assert 0.5 / 256 < error < 2 * 0.5 / 256
    assert standard_error(shares, np.full((8, 32), 0.1)) == pytest.approx(error / 5)
    assert standard_error(shares, np.zeros((8, 32))) == 0.0


@pytest.mark.parametrize("samples", [1, 4])
def test_errors_from_attempts_are_those_of_the_difference_in_each_cell(samples: int) -> None:
    """Each grasp and pose counts by how much oftener the grasp is chosen there with the look, or after no look."""
    random = np.random.default_rng(samples)
    table = GraspTable.of_successes(["a", "b", "c"], random.integers(0, 11, (3, 6)), 10, 6)
    assert table.score_variances is not None
    for _ in range(20):
        poses = np.repeat(random.permutation(6)[:5], samples)
        chosen, kept = random.integers(-1, 3, (2, len(poses)))  # -1: no grasp
        shares = random.random(len(poses))
        difference = np.zeros((3, 6))
        for grasps, sign in ((chosen, 1.0), (kept, -1.0)):
            for grasp, pose, share in zip(grasps, poses, shares, strict=True):
                difference[grasp, pose] += sign * share if grasp >= 0 else 0.0
        expected = np.sqrt(np.sum(difference**2 * table.score_variances))
        assert score_standard_error(table, chosen, kept, poses, shares) == pytest.approx(expected, rel=1e-12)


def test_given_probabilities_have_no_error_from_attempts() -> None:
    none = np.zeros(0, dtype=np.intp)
    assert score_standard_error(GraspTable.of_probabilities(["a"], [[0.5]], 1), none, none, none, np.zeros(0)) is None
