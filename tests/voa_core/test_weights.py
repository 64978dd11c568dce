import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support import twin
from tests.voa_core.worlds import RULE_NAMES, as_lists, lidar_of, parameters_of
from voa_core import weights
from voa_core.kernels import Array
from voa_core.prediction import Prediction
from voa_core.rules.registry import rule_of
from voa_core.weights import Weigher, wanted

INF = math.inf
LIDAR = lidar_of(6, range_max=2.0)
# Beam 2 sees nothing at any pose: it is compared, and only the number of beams knows.
RANGES = np.array(
    [[0.5, 0.6, INF, INF, 0.7, 0.9], [0.5, INF, INF, 0.8, 0.7, INF], [1.5, 1.6, INF, 0.8, INF, 0.2]], dtype=np.float64
)
PREDICTION = Prediction.of_dense(LIDAR.grid, RANGES)
ALL = np.arange(3)


def weigher(name: str, dtype: type[np.floating] = np.float64, *, keep: bool) -> Weigher:
    return Weigher.of(rule_of(name, LIDAR), PREDICTION, dtype, keep=keep)


def expected(name: str) -> list[list[float]]:
    """Rows scaled so that their largest is 1."""
    parameters, scans = parameters_of(name, LIDAR), as_lists(RANGES)
    rows = [[twin.log_weight(name, parameters, seen, predicted) for predicted in scans] for seen in scans]
    return [[math.exp(value - max(row)) for value in row] for row in rows]


def normalised(weights: Array) -> Array:
    """Rows without any weight stay."""
    highest = weights.max(axis=1, keepdims=True)
    scaled: Array = weights / np.where(highest > 0.0, highest, 1.0)
    return scaled


@pytest.mark.parametrize("name", RULE_NAMES)
@pytest.mark.parametrize("keep", [True, False])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_weights_are_the_rules_up_to_a_factor_per_row(
    name: str, keep: bool, dtype: type[np.floating], tolerance: float
) -> None:
    weights = weigher(name, dtype, keep=keep).weights(ALL, ALL)
    assert weights.dtype == dtype
    np.testing.assert_allclose(weights, expected(name), rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", RULE_NAMES)
@pytest.mark.parametrize("keep", [True, False])
@pytest.mark.parametrize(("rows", "columns"), [([2, 0], [0, 1, 2]), ([1], [1, 2]), ([0, 1, 2], [1]), ([0, 1], [2, 0])])
def test_parts_of_the_matrix_are_those_parts(name: str, keep: bool, rows: list[int], columns: list[int]) -> None:
    weights = weigher(name, keep=keep).weights(np.array(rows), np.array(columns))
    whole = np.array(expected(name))[np.ix_(rows, columns)]
    np.testing.assert_allclose(normalised(weights), normalised(whole), rtol=0, atol=1e-12)


def test_kept_weights_are_not_computed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, streamed = weigher("exponential", keep=True), weigher("exponential", keep=False)
    assert streamed.panels is None
    assert kept.matrix is None
    monkeypatch.setattr(weights, "scale_rows", None)
    kept.weights(ALL, ALL)
    with pytest.raises(TypeError):
        streamed.weights(ALL, ALL)


def test_all_weights_are_computed_at_once_unless_they_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    streamed = weigher("exponential", keep=False)
    panels = streamed.all_weights(wanted)
    assert panels is not None
    np.testing.assert_array_equal(panels.read(ALL, ALL), weigher("exponential", keep=True).weights(ALL, ALL))
    assert streamed.panels is None
    monkeypatch.setattr(weights, "_POSES_AT_ONCE", 2)
    assert streamed.all_weights(wanted) is None


def test_a_row_without_any_weight_stays_0() -> None:
    streamed = weigher("margin", keep=False).weights(np.array([0]), np.array([1, 2]))
    assert streamed.tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("name", RULE_NAMES)
def test_logarithms_of_a_row_are_exact_up_to_a_constant(name: str) -> None:
    row = weigher(name, np.float32, keep=True).log_row(1)
    parameters, scans = parameters_of(name, LIDAR), as_lists(RANGES)
    exact = np.array([twin.log_weight(name, parameters, scans[1], predicted) for predicted in scans])
    np.testing.assert_allclose(row - row.max(), exact - exact.max(), rtol=0, atol=1e-12)


def test_distances_are_between_predicted_scans() -> None:
    no_return_m = rule_of("exponential", LIDAR).no_return_m
    scans = as_lists(RANGES)
    np.testing.assert_allclose(
        weigher("exponential", keep=False).distances(2),
        [twin.distance(scans[2], predicted, no_return_m) for predicted in scans],
        rtol=0,
        atol=1e-12,
    )


def test_memory_is_counted() -> None:
    ranges = 3 * 5 * 8
    assert weigher("gaussian", keep=False).nbytes == ranges
    for dtype in (np.float32, np.float64):
        assert weigher("gaussian", dtype, keep=True).nbytes == ranges + 3 * 256, "a panel of three poses"


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-14), (np.float32, 2e-6)])
@pytest.mark.parametrize(("n", "pairs_at_once"), [(1, 2**14), (2, 2**14), (3, 2**14), (4, 3), (18, 2**14), (18, 40)])
@pytest.mark.parametrize("name", RULE_NAMES)
def test_weights_of_all_pairs_are_those_of_each(
    name: str,
    n: int,
    pairs_at_once: int,
    dtype: type[np.floating],
    tolerance: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(weights, "_PAIRS_AT_ONCE", pairs_at_once)
    ranges = np.random.default_rng(n).uniform(0.1, 1.9, (n, 6))
    ranges[n // 2 :] = ranges[: n - n // 2] + 1e-4  # so near that `inverse_rmsd` and `margin` weigh them as equal
    own = Weigher.of(rule_of(name, LIDAR), Prediction.of_dense(LIDAR.grid, ranges), dtype, keep=True)
    rows = np.arange(n)
    expected = replace(own, panels=None).weights(rows, rows)
    np.testing.assert_allclose(own.weights(rows, rows), expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", RULE_NAMES)
@pytest.mark.parametrize("keep", [True, False])
def test_a_place_from_which_nothing_is_ever_seen_distinguishes_no_poses(name: str, keep: bool) -> None:
    nothing = Prediction.of_dense(LIDAR.grid, np.full((3, 6), INF))
    weights = Weigher.of(rule_of(name, LIDAR), nothing, np.float64, keep=keep).weights(ALL, ALL)
    assert weights.tolist() == [[1.0] * 3] * 3


@pytest.mark.parametrize("name", RULE_NAMES)
@pytest.mark.parametrize("numbers", [1, 2, 3])
def test_a_large_matrix_is_computed_in_parts_and_a_check_before_each_can_end_it(
    monkeypatch: pytest.MonkeyPatch, name: str, numbers: int
) -> None:
    whole = weigher(name, keep=True).weights(ALL, ALL)
    monkeypatch.setattr("voa_core.weights._POSES_AT_ONCE", numbers)
    checks: list[None] = []
    rule = rule_of(name, LIDAR)
    parts = Weigher.of(rule, PREDICTION, np.float64, keep=True, check=lambda: checks.append(None))
    assert len(checks) == {1: 3, 2: 3, 3: 1}[numbers]
    np.testing.assert_allclose(parts.weights(ALL, ALL), whole, rtol=0, atol=1e-12)

    def unwanted() -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        Weigher.of(rule, PREDICTION, np.float64, keep=True, check=unwanted)
