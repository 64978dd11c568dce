"""Single looks where driving costs."""

import pytest

from voa_evaluation.values.bench import Bench
from voa_evaluation.values.cases import cases_of
from voa_evaluation.values.driving import WITHOUT_COSTS, _drive, drives
from voa_evaluation.values.policies import NEAREST, RANDOM, VOA
from voa_evaluation.values.promises import simulated_promise
from voa_evaluation.values.truth import truth_of


def test_ways_differ_only_where_driving_costs(bench: Bench) -> None:
    cases = cases_of("block", 6, 3, 1)[1:]
    truths = [truth_of(bench, case.belief) for case in cases]
    promises = [simulated_promise(bench, case.belief) for case in cases]
    by_key = drives(bench, cases, truths, promises)
    assert by_key[0.0, VOA].net.mean == by_key[0.0, WITHOUT_COSTS].net.mean
    free, dear = by_key[0.0, NEAREST], by_key[0.2, NEAREST]
    assert free.net.mean - dear.net.mean == pytest.approx(0.2 * free.metres)
    assert by_key[0.2, VOA].metres <= by_key[0.0, VOA].metres
    assert by_key[0.2, RANDOM].promised is None
    nothing = _drive(bench, cases, truths, promises, 5.0, VOA)
    assert (nothing.grasped, nothing.metres, nothing.net.mean, nothing.promised) == (3, 0.0, 0.0, 0.0)
