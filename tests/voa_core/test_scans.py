import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import twin
from tests.voa_core.worlds import lidar_of
from voa_core.errors import InvalidInput
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.scans import Scan, classify, restrict_prediction, scan_of
from voa_core.workspace import Workspace

NAN, INF = math.nan, math.inf
LIDAR = lidar_of(8, range_max=2.0)  # range_min 0.1


def classified(values: list[float], *, zero: Literal["missing", "no_return"] = "missing", **limits: Any) -> list[float]:
    grid = BeamGrid(len(values), 0.0, 0.1)
    lidar = replace(LIDAR, zero=zero)
    return [float(beam) for beam in classify(Scan(np.array(values), grid, **limits), lidar, None)]


@pytest.mark.parametrize(
    ("value", "beam"),
    [
        (NAN, NAN),
        (-INF, NAN),
        (INF, INF),
        (0.0, NAN),
        (-0.0, NAN),
        (-0.5, NAN),
        (0.0999, NAN),
        (0.1, 0.1),
        (1.0, 1.0),
        (2.0, 2.0),
        (2.0001, INF),
    ],
)
def test_each_beam_is_what_the_lidars_limits_make_of_it(value: float, beam: float) -> None:
    np.testing.assert_equal(classified([value]), [beam])


def test_a_zero_says_what_the_lidar_says_it_says() -> None:
    np.testing.assert_equal(classified([0.0, -0.0, 0.5], zero="no_return"), [INF, INF, 0.5])


def test_what_stands_at_an_index_of_no_return_is_ignored() -> None:
    values = [0.5, NAN, -INF, 0.0, 0.01, 0.5]
    np.testing.assert_equal(classified(values, no_return=(0, 1, 2, 3, 4)), [INF] * 5 + [0.5])


def test_the_scans_own_limits_win_over_the_lidars() -> None:
    np.testing.assert_equal(classified([0.05, 0.2, 2.5, 3.5], range_min=0.0, range_max=3.0), [0.05, 0.2, 2.5, INF])
    np.testing.assert_equal(classified([0.05, 0.2], range_min=0.3), [NAN, NAN])


def test_a_zero_stays_a_zero_though_range_min_is_zero() -> None:
    np.testing.assert_equal(classified([0.0], range_min=0.0), [NAN])


def test_below_range_min_is_checked_before_above_range_max() -> None:
    np.testing.assert_equal(classified([0.07, 0.15], range_max=0.05), [NAN, INF])


def test_the_workspace_is_checked_last_and_only_for_returns() -> None:
    crossing = Workspace((-0.2, -0.2), (0.2, 0.2)).crossing(
        SensorConfiguration("a", -1.0, 0.0, 0.0), np.array([0.0] * 7 + [math.pi])
    )
    scan = Scan(np.array([0.5, 0.8, 1.0, 1.2, 1.5, NAN, INF, 0.5]), BeamGrid(8, 0.0, 0.1))
    np.testing.assert_equal(classify(scan, LIDAR, crossing), [NAN, 0.8, 1.0, 1.2, INF, NAN, INF, INF])


odd_ranges = st.one_of(
    st.sampled_from([NAN, INF, -INF, 0.0, -0.0, 0.1, 2.0, -1.0]), st.floats(0.0, 3.0), st.floats(0.0, 0.2)
)


@settings(max_examples=100, deadline=None)
@given(
    values=st.lists(odd_ranges, min_size=1, max_size=8),
    declared=st.sets(st.integers(0, 7)),
    zero=st.sampled_from(["missing", "no_return"]),
    range_min=st.sampled_from([None, 0.0, 0.05, 0.5]),
    range_max=st.sampled_from([None, 0.5, 3.0]),
    place=st.one_of(st.none(), st.tuples(*[st.floats(-1.0, 1.0).filter(lambda v: abs(abs(v) - 0.3) > 1e-6)] * 3)),
)
def test_classification_agrees_with_the_twin(
    values: list[float],
    declared: set[int],
    zero: Literal["missing", "no_return"],
    range_min: float | None,
    range_max: float | None,
    place: tuple[float, float, float] | None,
) -> None:
    grid = BeamGrid(len(values), 0.123, 0.71)
    named = tuple(index for index in sorted(declared) if index < len(values))
    scan = Scan(np.array(values), grid, named, range_min, range_max)
    box = ((-0.3, -0.3), (0.3, 0.3))
    workspace = None if place is None else Workspace(*box).crossing(SensorConfiguration("a", *place), grid.angles)
    expected = []
    for index, value in enumerate(values):
        within: Any = "everywhere"
        if place is not None:
            within = twin.crossing(place[0], place[1], place[2] + float(grid.angles[index]), box)
        expected.append(
            twin.classify_beam(
                value,
                index in named,
                zero=zero,
                range_min=0.1 if range_min is None else range_min,
                range_max=2.0 if range_max is None else range_max,
                within=within,
            )
        )
    np.testing.assert_equal(classify(scan, replace(LIDAR, zero=zero), workspace), expected)


def test_predicted_beams_are_never_missing() -> None:
    crossing = Workspace((-0.2, -0.2), (0.2, 0.2)).crossing(SensorConfiguration("a", -1.0, 0.0, 0.0), np.zeros(5))
    ranges = np.array([[0.05, 0.5, 1.0, 1.5, INF]])
    np.testing.assert_equal(restrict_prediction(ranges, 1.2, None), [[0.05, 0.5, 1.0, INF, INF]])
    np.testing.assert_equal(restrict_prediction(ranges, 1.0, None), [[0.05, 0.5, 1.0, INF, INF]])
    np.testing.assert_equal(restrict_prediction(ranges, 2.0, crossing), [[INF, INF, 1.0, INF, INF]])


def test_scan_of_puts_ranges_on_the_lidars_beams_and_none_is_missing() -> None:
    scan = scan_of(LIDAR, [0.5] * 7 + [None], [2])
    assert LIDAR.grid.agrees_with(scan.grid)
    np.testing.assert_equal(classify(scan, LIDAR, None), [0.5, 0.5, INF, 0.5, 0.5, 0.5, 0.5, NAN])


def test_scan_of_fewer_ranges_is_a_scan_on_another_grid() -> None:
    assert not LIDAR.grid.agrees_with(scan_of(LIDAR, [0.5] * 7).grid)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ranges": np.zeros(3)}, r"ranges: expected 4 beams, got shape \(3,\)"),
        ({"no_return": (0, 4)}, "no_return: expected indices from 0 to 3, got 4"),
        ({"no_return": (-1,)}, "no_return: expected indices from 0 to 3, got -1"),
        ({"range_min": -0.1}, "range_min: expected a finite number of at least 0, got -0.1"),
        ({"range_max": INF}, "range_max: expected a finite number of at least 0, got inf"),
        ({"range_min": 0.5, "range_max": 0.4}, r"range_max: expected at least range_min \(0.5\), got 0.4"),
    ],
)
def test_a_scan_that_cannot_be_is_refused(changes: dict[str, Any], message: str) -> None:
    given_: dict[str, Any] = {"ranges": np.ones(4), "grid": BeamGrid(4, 0.0, 0.1), **changes}
    with pytest.raises(InvalidInput, match=message):
        Scan(**given_)
