"""End-to-end drops in MuJoCo."""

from dataclasses import replace

import pytest

from voa_evaluation.values.confirmation import DropResult, confirmations, drop_results
from voa_evaluation.values.setting import QUICK
from voa_fleet.world.objects import FleetObject


def drop(lifted: str, promised: float = 0.8) -> DropResult:
    """Result of a drop in which the object was lifted as letters say: c(hosen look), n(o look), r(andom look)."""
    return DropResult(promised, "c" in lifted, "n" in lifted, "r" in lifted, "x" not in lifted, 0.9)


def test_rows_count_what_was_lifted() -> None:
    rows = confirmations([("a", [drop("cn"), drop("c"), drop("x")]), ("b", [drop("cr", 0.6)])], 0)
    assert [row.object for row in rows] == ["all", "a", "b"]
    total, first = rows[:2]
    assert (total.drops, total.with_look, total.without_look, total.random_look, total.refused) == (4, 3, 1, 1, 1)
    assert total.success.value == pytest.approx(0.75)
    assert total.gain.value == pytest.approx(0.5)
    assert total.promised == pytest.approx(0.75)
    assert first.over_random.value == pytest.approx(2 / 3)
    assert first.measured_scores == pytest.approx(0.9)


def test_a_single_object_has_no_row_for_all() -> None:
    assert [row.object for row in confirmations([("a", [drop("c")])], 0)] == ["a"]


def test_drops_of_the_mallet_come_out_as_promised(targets: dict[str, FleetObject]) -> None:
    results = drop_results(targets["mallet"], replace(QUICK, drops=3))
    assert len(results) == 3
    assert all(0.8 < result.promised <= 1.0 and result.accepted for result in results)
    assert sum(result.with_look for result in results) >= 2
    assert results == drop_results(targets["mallet"], replace(QUICK, drops=3))
