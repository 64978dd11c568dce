"""Kept weights: beliefs are those of weights that keep nothing."""

import numpy as np
import pytest

from voa_core.filtering import Belief
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.kept_weights import KeptWeights


@pytest.mark.parametrize("fixture", ["bench", "margin_bench"])
def test_beliefs_are_those_of_weights_that_keep_nothing(fixture: str, request: pytest.FixtureRequest) -> None:
    own: Bench = request.getfixturevalue(fixture)
    sampling, policy = Sampling("any", 3), own.scenario.policy
    kept = KeptWeights.of(own.world, own.sensors[0], sampling, listed=True)
    plain = SimulatedWeights.of(own.world, own.sensors[0], sampling, listed=True)
    assert plain.matrix is not None
    rows = np.arange(len(plain.matrix))
    if fixture == "margin_bench":
        assert (plain.matrix == 0.0).all(axis=1).any(), "expected a scan that matches no pose"
    for belief in (Belief.uniform(6), Belief.of([0.5, 0.1, 0.1, 0.1, 0.1, 0.1])):
        before = [belief] * len(rows)
        for one, other in zip(kept.beliefs(rows, before, policy), plain.beliefs(rows, before, policy), strict=True):
            assert one.p == pytest.approx(other.p, abs=1e-12)
