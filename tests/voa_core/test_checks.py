import math
from typing import Any

import numpy as np
import pytest

from voa_core.checks import finite_array, frozen, indices, number, unique_names
from voa_core.errors import InvalidInput, UnknownName


def test_finite_array_is_a_read_only_float64_copy() -> None:
    given = np.array([1, 2, 3])
    array = finite_array("belief", given, (None,))
    given[0] = 9
    assert array.dtype == np.float64
    assert array.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 5.0


@pytest.mark.parametrize(
    ("values", "shape", "message"),
    [
        ([1.0, 2.0], (3,), "belief: expected shape 3, got shape 2"),
        ([1.0, 2.0], (None, 3), "belief: expected shape nx3, got shape 2"),
        ([[1.0, 2.0]], (None, 3), "belief: expected shape nx3, got shape 1x2"),
        (1.0, (None,), "belief: expected shape n, got shape ()"),
        ([1.0], (), "belief: expected shape a number, got shape 1"),
        (["a"], (None,), "belief: expected numbers of shape n, got list"),
        ([[1.0], [1.0, 2.0]], (None,), "belief: expected numbers of shape n, got list"),
        ({}, (None,), "belief: expected numbers of shape n, got dict"),
        ([0.0, math.nan], (None,), "belief: expected finite numbers, got nan at [1]"),
        ([[0.0, 1.0], [math.inf, 0.0]], (2, 2), "belief: expected finite numbers, got inf at [1, 0]"),
    ],
)
def test_finite_array_says_what_it_expected(values: Any, shape: tuple[int | None, ...], message: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        finite_array("belief", values, shape)
    assert str(caught.value) == message


def test_number_accepts_its_limits() -> None:
    assert number("cost", 0.0, at_least=0.0) == 0.0
    assert number("cost", 3, above=2.0, below=4.0) == 3.0


@pytest.mark.parametrize(
    ("value", "limits", "expected"),
    [
        (2.0, {"above": 2.0}, "a number above 2.0, got 2.0"),
        (-0.1, {"at_least": 0.0}, "a number of at least 0.0, got -0.1"),
        (1.0, {"below": 1.0}, "a number below 1.0, got 1.0"),
        (math.nan, {}, "a finite number, got nan"),
        (math.nan, {"above": 0.0}, "a number above 0.0, got nan"),
        (math.inf, {"at_least": 0.0}, "a finite number, got inf"),
    ],
)
def test_number_says_which_limit_does_not_hold(value: float, limits: dict[str, float], expected: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        number("cost", value, **limits)
    assert str(caught.value) == f"cost: expected {expected}"


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ([], "pose: expected at least one, got none"),
        (["A", ""], "pose: expected names that are not empty, got an empty name"),
        (["A", "B", "A"], "pose: expected names that differ, got 'A' twice"),
    ],
)
def test_names_are_there_and_differ(names: list[str], message: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        unique_names("pose", names)
    assert str(caught.value) == message


def test_indices_follow_the_order_of_the_requested_names() -> None:
    assert indices("pose", ["C", "A"], ["A", "B", "C"]).tolist() == [2, 0]


def test_indices_list_what_exists_when_a_name_does_not() -> None:
    with pytest.raises(UnknownName, match="there is no pose 'D'; there are: 'A', 'B'"):
        indices("pose", ["A", "D"], ["A", "B"])


def test_indices_refuse_a_name_requested_twice() -> None:
    with pytest.raises(InvalidInput, match="'A' twice"):
        indices("pose", ["A", "A"], ["A", "B"])


def test_frozen_makes_the_array_itself_read_only() -> None:
    array = np.zeros(2)
    assert frozen(array) is array
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1.0
