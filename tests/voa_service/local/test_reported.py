"""A map that reports its results."""

from collections.abc import Iterable
from typing import Any

import pytest

from voa_service.local.reported import ReportedMap


def test_results_come_in_order_and_each_is_reported() -> None:
    reports: list[tuple[int, int]] = []
    reported = ReportedMap(map, lambda done, total: reports.append((done, total)))
    assert list(reported(lambda item: 2 * item, iter([3, 1, 2]))) == [6, 2, 4]
    assert reports == [(1, 3), (2, 3), (3, 3)]


def test_a_result_is_reported_only_once_it_is_there() -> None:
    reports: list[int] = []

    def failing(function: Any, items: Iterable[Any], /) -> Iterable[Any]:
        yield from [1, 2]
        raise ValueError("the third")

    results = iter(ReportedMap(failing, lambda done, total: reports.append(done))(int, ["1", "2", "3"]))
    assert (next(results), next(results)) == (1, 2)
    with pytest.raises(ValueError, match="the third"):
        next(results)
    assert reports == [1, 2]
