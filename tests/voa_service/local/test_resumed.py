"""A map that keeps its results in a folder."""

import pickle
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from voa_service.local.resumed import ResumedMap, folder_of


class Counted:
    """A function that notes for what it was called, and fails at one item."""

    def __init__(self, fails_at: int | None = None) -> None:
        self.calls: list[int] = []
        self.fails_at = fails_at

    def __call__(self, item: int) -> int:
        self.calls.append(item)
        if item == self.fails_at:
            raise ValueError(item)
        return 10 * item


def test_finished_results_are_not_computed_again(tmp_path: Path) -> None:
    first, second = Counted(fails_at=2), Counted()
    with pytest.raises(ValueError, match="2"):
        list(ResumedMap(map, tmp_path)(first, [0, 1, 2, 3]))
    assert first.calls == [0, 1, 2]
    assert list(ResumedMap(map, tmp_path)(second, [0, 1, 2, 3])) == [0, 10, 20, 30]
    assert second.calls == [2, 3]


def test_each_time_over_the_parts_has_results_of_its_own(tmp_path: Path) -> None:
    for _ in range(2):
        resumed = ResumedMap(map, tmp_path)
        assert list(resumed(lambda item: item + 1, [1, 2])) == [2, 3]
        assert list(resumed(lambda item: item - 1, [1, 2])) == [0, 1]


def test_where_all_is_kept_nothing_is_mapped(tmp_path: Path) -> None:
    assert list(ResumedMap(map, tmp_path)(str, [1])) == ["1"]

    def refused(function: Any, items: Iterable[Any], /) -> Iterable[Any]:
        raise AssertionError

    assert list(ResumedMap(refused, tmp_path)(str, [1])) == ["1"]


def test_a_result_that_was_not_written_in_full_is_computed_again(tmp_path: Path) -> None:
    assert list(ResumedMap(map, tmp_path)(str, [1, 2])) == ["1", "2"]
    (kept,) = [file for file in (tmp_path / "0").iterdir() if pickle.loads(file.read_bytes()) == "2"]  # noqa: S301
    kept.rename(kept.with_suffix(".part"))  # as a process leaves it that ends within the write
    assert list(ResumedMap(map, tmp_path)(str, [1, 2])) == ["1", "2"]
    assert kept.is_file()


def test_rankings_that_may_differ_have_folders_of_their_own(tmp_path: Path) -> None:
    one, other = {"request": "a", "numpy": "2.4"}, {"request": "a", "numpy": "2.5"}
    assert folder_of(tmp_path, one) == folder_of(tmp_path, dict(reversed(one.items())))
    assert folder_of(tmp_path, one) != folder_of(tmp_path, other)
    assert folder_of(tmp_path, one).parent == tmp_path
