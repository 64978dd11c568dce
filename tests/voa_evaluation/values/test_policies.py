"""Ways of choosing a look without its value."""

import math

import numpy as np
import pytest

from voa_core.filtering import Belief
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.policies import (
    BEAMS,
    NEAREST,
    chosen_without_value,
    distances_from,
    expected_beams,
    expected_entropies,
)

BELIEF = Belief.of([0.3, 0.1, 0.2, 0.15, 0.05, 0.2])


@pytest.mark.parametrize("fixture", ["bench", "margin_bench"])
def test_entropies_are_those_of_the_beliefs_after_each_scan(fixture: str, request: pytest.FixtureRequest) -> None:
    own: Bench = request.getfixturevalue(fixture)
    for looks in (own.taken, own.exact):
        look = looks.together(own.sensors[1])
        rows = np.arange(6 * look.samples)
        after = look.beliefs(rows, [BELIEF] * len(rows), own.scenario.policy)
        entropies = np.array([belief.entropy_nats for belief in after]).reshape(6, -1).mean(axis=1)
        assert expected_entropies(own, looks, BELIEF)[1] == pytest.approx(float(entropies @ BELIEF.p), abs=1e-9)


def test_beams_are_counted_by_the_belief(bench: Bench) -> None:
    sensor = bench.sensors[2]
    returned = np.isfinite(bench.scenario.predictor.predict(sensor, listed=True).dense()).sum(axis=1)
    assert expected_beams(bench, BELIEF)[2] == pytest.approx(float(returned @ BELIEF.p))


def test_each_way_takes_its_own_extreme(bench: Bench) -> None:
    sensor = bench.sensors[5]
    away = math.hypot(sensor.x, sensor.y)
    start = sensor.x / away, sensor.y / away
    chosen = chosen_without_value(bench, BELIEF, start)
    assert chosen[NEAREST] == 5
    assert distances_from(bench, start).argmin() == 5
    assert chosen[BEAMS] == expected_beams(bench, BELIEF).argmax()
