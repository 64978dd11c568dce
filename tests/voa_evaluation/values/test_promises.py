"""Promises: those of the paper over exact scans, and those of the service over simulated ones."""

import pytest

from voa_core.filtering import Belief
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.promises import exact_promise, simulated_promise


def test_exact_promises_are_the_papers_value_of_assistance(bench: Bench) -> None:
    belief = Belief.of([0.4, 0.1, 0.1, 0.2, 0.1, 0.1])
    by_name = {look.sensor.name: look.net_value for look in bench.scenario.rank(belief).looks}
    promise = exact_promise(bench, belief)
    assert promise.net == pytest.approx([by_name[sensor.name] for sensor in bench.sensors], abs=1e-9)
    assert promise.best_net == pytest.approx(promise.net.max(), abs=1e-9)
    assert promise.recommended


def test_a_known_pose_needs_no_look(bench: Bench) -> None:
    certain = Belief.of([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    for promise in (simulated_promise(bench, certain), exact_promise(bench, certain)):
        assert not promise.recommended
        assert promise.best_net == pytest.approx(0.0, abs=1e-12)


def test_simulated_promises_are_near_the_truth_and_the_best_is_valued_again(bench: Bench) -> None:
    promise = simulated_promise(bench, Belief.uniform(6))
    assert promise.recommended
    assert 0.1 < promise.best_net < 0.6
    assert promise.best_net != promise.net[promise.best]
