"""The benchmark of large scenarios ranks over samples of the poses, and refuses a value that is not the exact one."""

from dataclasses import replace

import pytest

from tests.benchmarks import huge
from tests.benchmarks.gates import gate_of, missed
from voa_core.assistance import Assistance
from voa_core.lidars import SensorConfiguration
from voa_core.ranking import RankedLook


def test_a_small_scene_is_ranked_and_measured() -> None:
    measured = huge.measure(300, 9)
    assert 0.0 < measured.cpu_min < 5.0
    assert 0.05 < measured.memory_gib < 8.0
    assert measured.best_error == 0.0, "the largest sample has all of so few poses"


def test_its_figures_have_gates(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(huge, "_measured", lambda: huge.Measured(9.0, 4.5, 0.001))
    results = huge.run()
    assert [gate_of(result.name) is not None for result in results] == [True, True, False]
    assert missed(results) == [results[1].name]


def test_a_value_beyond_four_standard_errors_stops_the_run() -> None:
    nothing = Assistance(0.5, 0.5, *[None] * 5)  # type: ignore[arg-type]
    look = RankedLook(SensorConfiguration("a", 0.0, 0.0, 0.0), replace(nothing, standard_error=0.01), 0.5, 0.0)
    huge._check(look, 0.535)
    with pytest.raises(AssertionError, match="off by"):
        huge._check(look, 0.545)
    with pytest.raises(AssertionError, match="off by"):
        huge._check(replace(look, assistance=nothing), 0.5)
