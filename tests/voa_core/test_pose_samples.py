import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.grasps import GraspTable
from voa_core.pose_samples import PoseSample, order_by_best_score

N = 400
LISTED = np.arange(N)


def uneven(seed: int = 0) -> Floats:
    """Belief in which some poses have far more probability than others, and some none."""
    shares = np.random.default_rng(seed).gamma(0.3, size=N)
    shares[::7] = 0.0
    belief: Floats = shares / shares.sum()
    return belief


def samples(belief: Floats, size: int, count: int) -> list[PoseSample]:
    return [PoseSample.of(belief, LISTED, size, str(seed)) for seed in range(count)]


@pytest.mark.parametrize("size", [1, 2, 16, 64, 300])
def test_the_shares_of_each_sample_sum_to_1_and_those_of_many_samples_average_to_the_belief(size: int) -> None:
    belief, count = uneven(), 2000
    drawn = samples(belief, size, count)
    assert [float(sample.shares.sum()) for sample in drawn] == pytest.approx([1.0] * count, abs=1e-12)
    assert {len(sample) for sample in drawn} == {size}
    mean = sum(sample.over(N) for sample in drawn) / count
    # Each pose counts 0, 1 or 2 stretches, so the mean of so many has at most this error, five times over.
    assert np.abs(mean - belief).max() <= 5.0 * np.sqrt(2.0 * belief.max() / size / count)


def test_an_impossible_pose_is_never_drawn() -> None:
    belief = uneven()
    for sample in samples(belief, 64, 50):
        assert (belief[sample.poses] > 0.0).all()
        assert (sample.probabilities == belief[sample.poses]).all()


def test_a_pose_with_more_probability_than_a_stretch_is_in_every_sample_with_its_own() -> None:
    belief = np.full(N, 0.5 / (N - 2))
    belief[[3, 5]] = 0.4, 0.1
    for sample in samples(belief, 12, 20):
        assert sample.over(N)[[3, 5]] == pytest.approx([0.4, 0.1], abs=1e-12)
        assert (sample.spreads > 0.0).sum() == 10


@pytest.mark.parametrize("more", [0, 1, 1000])
def test_a_sample_with_room_for_all_possible_poses_has_all_of_them_and_no_error(more: int) -> None:
    belief = uneven()
    sample = PoseSample.of(belief, LISTED, int(np.count_nonzero(belief)) + more, "")
    assert sample.over(N) == pytest.approx(belief, abs=1e-12)
    assert sample.standard_error(np.arange(len(sample), dtype=float)) == 0.0


def test_equal_arguments_give_equal_samples_and_another_seed_or_size_gives_another() -> None:
    belief = uneven()
    sample, again, other = (PoseSample.of(belief, LISTED, 64, seed) for seed in ("a", "a", "b"))
    assert (sample.poses == again.poses).all()
    assert (sample.poses != other.poses).any()
    assert set(PoseSample.of(belief, LISTED, 65, "a").poses) != set(sample.poses)


def values_of(kind: str) -> Floats:
    noise = np.random.default_rng(1).normal(size=N)
    return {
        "noise": noise,
        "slope": np.linspace(0.0, 1.0, N),
        "waves": np.sin(np.linspace(0.0, 12.0, N)) + 0.1 * noise,
        "two kinds": (noise > 0.5).astype(float),
    }[kind]


@pytest.mark.parametrize("size", [32, 96])
@pytest.mark.parametrize("kind", ["noise", "two kinds"])
def test_the_standard_error_is_that_of_repeated_samples(kind: str, size: int) -> None:
    belief, values = uneven(), values_of(kind)
    truth = float(belief @ values)
    repeated = samples(belief, size, 1000)
    off = np.array([sample.shares @ values[sample.poses] - truth for sample in repeated])
    errors = np.array([sample.standard_error(values[sample.poses]) for sample in repeated])
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(np.sqrt(np.mean(off**2)), rel=0.15)
    assert 0.91 <= np.mean(np.abs(off) <= 2.0 * errors) <= 0.985


@pytest.mark.parametrize("kind", ["slope", "waves"])
def test_the_standard_error_counts_a_change_along_the_order_rather_too_high_than_too_low(kind: str) -> None:
    belief, values = uneven(), values_of(kind)
    repeated = samples(belief, 64, 1000)
    off = [sample.shares @ values[sample.poses] - belief @ values for sample in repeated]
    errors = [sample.standard_error(values[sample.poses]) for sample in repeated]
    assert 0.95 <= np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(off))) <= 2.0


def test_along_an_order_in_which_values_change_slowly_the_error_is_far_below_that_of_independent_draws() -> None:
    belief, values, size = np.full(N, 1.0 / N), values_of("slope"), 40
    off = [sample.shares @ values[sample.poses] - values.mean() for sample in samples(belief, size, 300)]
    independent = values.std() / np.sqrt(size)
    assert np.sqrt(np.mean(np.square(off))) < 0.1 * independent


def test_a_single_draw_has_the_error_of_its_own_value() -> None:
    sample = PoseSample.of(np.full(N, 1.0 / N), LISTED, 1, "")
    assert sample.standard_error(np.array([0.5])) == pytest.approx(0.5 * np.sqrt(1.0 - 1.0 / N))


def test_the_cell_weights_estimate_the_sum_of_squares_of_the_belief() -> None:
    belief = uneven()
    estimates = [np.sum(sample.cell_weights**2) for sample in samples(belief, 64, 1000)]
    assert np.mean(estimates) == pytest.approx(np.sum(belief**2), rel=0.01)


def test_poses_stand_in_the_order_of_the_score_of_their_best_grasp_and_then_of_their_probability() -> None:
    scores = [[0.9, 0.1, 0.52, 0.0, 0.92], [0.0, 0.5, 0.0, 0.2, 0.0]]
    table = GraspTable.of_probabilities(["a", "b"], scores, 5)
    assert list(order_by_best_score(table, np.array([0.2, 0.1, 0.3, 0.3, 0.1]))) == [3, 1, 2, 4, 0]


def test_a_sample_of_no_pose_is_refused() -> None:
    with pytest.raises(InvalidInput, match="size"):
        PoseSample.of(uneven(), LISTED, 0, "")
