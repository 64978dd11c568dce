"""Chains of contour points: every segment of a cut, each once, and no point that is not needed."""

import math

import numpy as np
import pytest

from voa_core.chains import Chains, chains_of
from voa_core.checks import Floats

SQUARE = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2)]


def chained(*cuts: tuple[list[tuple[float, float]], list[tuple[int, int]]]) -> Chains:
    """Chains of cuts, each of points and segments."""
    points = np.array([point for cut in cuts for point in cut[0]]).reshape(-1, 2)
    segments = np.array([segment for cut in cuts for segment in cut[1]], dtype=np.int32).reshape(-1, 2)
    starts = [np.cumsum([0, *(len(cut[part]) for cut in cuts)]) for part in (0, 1)]
    return chains_of(points, segments, starts[0], starts[1])


def segments_of(chains: Chains, cut: int = 0) -> set[frozenset[tuple[float, float]]]:
    """The segments of a cut, each as the set of its ends."""
    own = np.arange(chains.start[cut], chains.start[cut + 1])
    places = list(zip(chains.x.tolist(), chains.y.tolist(), strict=True))
    return {frozenset((places[i], places[i + 1])) for i in own if chains.joined[i]}


def around(*corners: tuple[float, float]) -> set[frozenset[tuple[float, float]]]:
    """The segments of the closed contour of these corners."""
    return {frozenset((a, b)) for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)}


def test_a_closed_contour_in_any_order_is_one_chain_that_ends_where_it_begins() -> None:
    chains = chained((SQUARE, [(2, 1), (3, 2), (0, 1), (0, 3)]))
    assert chains.joined.tolist() == [True, True, True, True, False]
    assert (chains.x[0], chains.y[0]) == (chains.x[4], chains.y[4])
    assert segments_of(chains) == around(*SQUARE)


def test_points_on_a_straight_line_are_dropped() -> None:
    points = [(0.0, 0.0), (0.1, 0.0), (0.15, 0.0), (0.2, 0.0), (0.2, 0.2), (0.1, 0.2), (0.0, 0.2)]
    chains = chained((points, [(i, (i + 1) % 7) for i in range(7)]))
    assert segments_of(chains) == around(*SQUARE)


def test_a_point_where_the_contour_turns_back_stays() -> None:
    points = [(0.0, 0.0), (0.2, 0.0), (0.1, 0.0)]
    chains = chained((points, [(0, 1), (1, 2)]))
    assert segments_of(chains) == {frozenset(points[:2]), frozenset(points[1:])}


def test_a_chain_with_ends_begins_at_one_of_them() -> None:
    chains = chained((SQUARE, [(3, 0), (0, 1), (1, 2)]))
    assert chains.joined.tolist() == [True, True, True, False]
    assert segments_of(chains) == around(*SQUARE) - {frozenset(SQUARE[2:])}


def test_two_segments_between_the_same_points_are_closed() -> None:
    chains = chained((SQUARE[:2], [(0, 1), (1, 0)]))
    assert chains.x.tolist() == [0.0, 0.2, 0.0]
    assert chains.joined.tolist() == [True, True, False]


def test_segments_are_chains_of_their_own_where_three_meet() -> None:
    chains = chained((SQUARE, [(0, 1), (0, 2), (0, 3)]))
    assert chains.joined.tolist() == [True, False] * 3
    assert segments_of(chains) == {frozenset((SQUARE[0], corner)) for corner in SQUARE[1:]}


def test_a_point_without_a_segment_is_in_no_chain() -> None:
    assert chained((SQUARE, [(0, 1)])).x.tolist() == [0.0, 0.2]


def test_several_cuts_have_several_contours() -> None:
    far = [(x + 1.0, y) for x, y in SQUARE]
    both = [(i + at, (i + 1) % 4 + at) for at in (0, 4) for i in range(4)]
    chains = chained((SQUARE, both[:4]), ([], []), (SQUARE + far, both))
    assert chains.start.tolist() == [0, 5, 5, 15]
    assert [segments_of(chains, cut) for cut in range(3)] == [around(*SQUARE), set(), around(*SQUARE) | around(*far)]


def test_the_circle_holds_every_point_and_the_points_are_given_from_its_middle() -> None:
    rng = np.random.default_rng(1)
    points: Floats = rng.uniform([2.9, -2.1], [3.1, -1.9], (50, 2))
    ring = [(i, (i + 1) % 50) for i in range(50)]
    chains = chained(([(float(x), float(y)) for x, y in points], ring), ([], []))
    x, y, radius = chains.circles[0]
    apart = np.hypot(chains.x - x, chains.y - y)
    assert apart.max() == pytest.approx(radius)
    assert radius < 0.1 * math.sqrt(2.0) + 1e-9
    np.testing.assert_allclose(chains.near_x, chains.x - x, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(chains.near_y, chains.y - y, rtol=1e-6, atol=1e-9)
    assert chains.circles[1].tolist() == [0.0, 0.0, 0.0]


def test_memory_is_counted() -> None:
    assert chained((SQUARE, [(0, 1), (1, 2), (2, 3), (3, 0)])).nbytes == 5 * (16 + 8 + 1)
