"""Sight of the object by the beams of a scan, by hand; tests/voa_core/test_evidence.py compares with the twin."""

import math

import numpy as np
import pytest

from voa_core.displaced_scans import DisplacedScans
from voa_core.lidars import BeamGrid
from voa_core.prediction import Prediction
from voa_core.sight import Sight, joined, sight_of, sight_of_copies

INF, NAN = math.inf, math.nan
GRID = BeamGrid(6, 0.0, 0.1)
DENSE = np.array(
    [
        [INF, 0.50, 0.50, 0.50, INF, INF],
        [INF, 0.52, 0.60, INF, INF, INF],
        [INF, INF, 0.50, 0.70, 0.70, 0.70],
        [INF, INF, INF, 0.72, 0.70, 0.70],
    ]
)
"""Two copies of each of two poses."""
BOTH = np.array([True, True])


def sight(measured: list[float], behind_m: float = 0.1) -> Sight:
    copies = DisplacedScans.of(Prediction.of_dense(GRID, DENSE), 2)
    return sight_of_copies(np.array(measured), copies, behind_m)


def exact(measured: list[float], behind_m: float = 0.1) -> Sight:
    return sight_of(np.array(measured), Prediction.of_dense(GRID, DENSE[::2]), behind_m)


def test_hits_are_the_ranges_where_the_scan_and_a_copy_return() -> None:
    seen = sight([0.3, 0.5, NAN, 0.6, 0.7, INF])
    assert seen.hits(0).tolist() == [0.5, 0.6]
    assert seen.hits(1).tolist() == [0.6, 0.7]
    alone = exact([0.3, 0.5, NAN, 0.6, 0.7, INF])
    assert [alone.hits(pose).tolist() for pose in (0, 1)] == [[0.5, 0.6], [0.6, 0.7]]


def test_fewest_are_the_returns_of_the_copy_that_predicts_the_fewest_on_the_compared_beams() -> None:
    assert sight([0.5] * 6).fewest.tolist() == [2, 3]
    assert sight([0.5, NAN, 0.5, 0.5, 0.5, NAN]).fewest.tolist() == [1, 2]
    assert exact([0.5] * 6).fewest.tolist() == [3, 4]
    assert exact([0.5, NAN, 0.5, 0.5, 0.5, NAN]).fewest.tolist() == [2, 3]


@pytest.mark.parametrize(
    ("measured", "behind_m", "possible", "misses"),
    [
        # The second pose predicts at least three returns: one must be seen.
        ([INF, INF, INF, INF, 0.79, INF], 0.1, [False, True], False),
        ([INF, INF, INF, INF, 0.81, INF], 0.1, [False, True], True),
        ([INF, INF, INF, INF, 0.81, INF], INF, [False, True], False),
        # The farthest copy of a pose counts: 0.72 m on beam 3.
        ([INF, INF, INF, 0.81, INF, INF], 0.1, [False, True], False),
        # No copy of a possible pose returns on beam 1, however far the scan reaches.
        ([INF, 0.5, INF, INF, INF, INF], INF, [False, True], True),
        # Two predicted returns decide nothing.
        ([INF] * 6, 0.1, [True, True], False),
    ],
)
def test_a_scan_misses_the_object_where_too_few_beams_see_it(
    measured: list[float], behind_m: float, possible: list[bool], misses: bool
) -> None:
    assert sight(measured, behind_m).misses_object(np.array(possible)) is misses


def test_exact_poses_reach_as_far_as_their_predictions() -> None:
    possible = np.array([False, True])
    assert not exact([INF, INF, INF, 0.79, 0.79, INF]).misses_object(possible)
    assert exact([INF, INF, INF, 0.81, 0.79, INF]).misses_object(possible)
    assert not exact([INF, INF, INF, 2.0, 2.0, INF], INF).misses_object(possible)
    assert exact([INF] * 6).misses_object(BOTH)


def test_a_scan_is_blind_where_none_of_its_beams_can_meet_a_pose() -> None:
    for of in (sight, exact):
        assert of([0.5, NAN, NAN, NAN, NAN, NAN]).is_blind
        assert not of([INF] * 6).is_blind
    nothing = Prediction.of_dense(GRID, np.full((2, 6), INF))
    for seen in (
        sight_of(np.full(6, 0.5), nothing, 0.1),
        sight_of_copies(np.full(6, 0.5), DisplacedScans.of(nothing), 0.1),
    ):
        assert seen.is_blind
        assert seen.fewest.tolist() == [0, 0]
        assert seen.hits(1).tolist() == []
        assert not seen.misses_object(BOTH)


def test_joined_sights_are_that_of_all_poses() -> None:
    answers = set()
    for far in (0.55, 0.75, 0.81, 0.95):
        measured = [0.3, far - 0.2, INF, far, far, NAN]
        beams = np.array(measured)
        of_copies = [
            sight_of_copies(beams, DisplacedScans.of(Prediction.of_dense(GRID, own), 2), 0.1)
            for own in (DENSE[:2], DENSE[2:])
        ]
        of_poses = [sight_of(beams, Prediction.of_dense(GRID, own), 0.1) for own in (DENSE[:1], DENSE[2:3])]
        for parts, whole in ((of_copies, sight(measured)), (of_poses, exact(measured))):
            together = joined(parts)
            assert together.fewest.tolist() == whole.fewest.tolist()
            for pose in (0, 1):
                assert together.hits(pose).tolist() == whole.hits(pose).tolist()
            for possible in ([True, False], [False, True], [True, True]):
                misses = together.misses_object(np.array(possible))
                assert misses is whole.misses_object(np.array(possible))
                answers.add(misses)
    assert answers == {True, False}
    assert joined(of_poses[:1]) is of_poses[0]
