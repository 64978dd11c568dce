"""Ways of choosing a look without its value: by entropy, by beams, by distance, at random."""

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from voa_core.checks import Floats
from voa_core.choices import LookWeights
from voa_core.filtering import Belief
from voa_core.looks import Looks
from voa_core.updating import UpdatePolicy
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.truth import argmax

VOA, VOA_EXACT, ENTROPY, ENTROPY_EXACT = "voa", "voa exact", "entropy", "entropy exact"
BEAMS, NEAREST, RANDOM, ORACLE = "beams", "nearest", "random", "oracle"

WAYS: Mapping[str, str] = MappingProxyType(
    {
        VOA: "the look that the service recommends by its Value of Assistance over simulated scans; none if none pays",
        VOA_EXACT: "the look with the largest Value of Assistance over exact scans, the paper's; none if none pays",
        ENTROPY: "the look after which the least entropy is expected over simulated scans",
        ENTROPY_EXACT: "the look after which the least entropy is expected over exact scans",
        BEAMS: "the look from which most beams are expected to meet the object",
        NEAREST: "the look nearest to where the robot starts, 1 m from the middle of the table",
        RANDOM: "any look, each as likely: the mean over all places",
    }
)
"""Ways of choosing a look, with their descriptions."""


def expected_entropies(bench: Bench, looks: Looks, belief: Belief) -> Floats:
    """Entropy of the belief expected after a look from each place, (k,) nats."""
    return np.array(
        [_expected_entropy(looks.together(sensor), belief, bench.scenario.policy) for sensor in bench.sensors]
    )


def _expected_entropy(look: LookWeights, belief: Belief, policy: UpdatePolicy) -> float:
    rows, columns = np.arange(len(belief.p) * look.samples), np.arange(len(belief.p))
    joint = look.weights(rows, columns) * belief.p
    total = joint.sum(axis=1, keepdims=True)
    after = joint / np.where(total > 0.0, total, 1.0)
    impossible = np.flatnonzero(total[:, 0] == 0.0)
    for row, one in zip(impossible, look.beliefs(impossible, [belief] * len(impossible), policy), strict=True):
        after[row] = one.p
    entropies = -(after * np.log(np.where(after > 0.0, after, 1.0))).sum(axis=1)
    return float(entropies.reshape(len(belief.p), -1).mean(axis=1) @ belief.p)


def expected_beams(bench: Bench, belief: Belief) -> Floats:
    """Number of beams expected to meet the object from each place, (k,), by its exact poses."""
    counts = []
    for sensor in bench.sensors:
        prediction = bench.scenario.predictor.predict(sensor, listed=True)
        counts.append(float(np.isfinite(prediction.ranges).sum(axis=1) @ belief.p))
    return np.array(counts)


def distances_from(bench: Bench, start: tuple[float, float]) -> Floats:
    """Distance of each place from where the robot starts, (k,) metres."""
    return np.array([math.hypot(sensor.x - start[0], sensor.y - start[1]) for sensor in bench.sensors])


def chosen_without_value(bench: Bench, belief: Belief, start: tuple[float, float]) -> dict[str, int]:
    """Choose a place by every way that needs no value of looks, but `random`: index of the place by way."""
    return {
        ENTROPY: argmax(-expected_entropies(bench, bench.simulated, belief)),
        ENTROPY_EXACT: argmax(-expected_entropies(bench, bench.exact, belief)),
        BEAMS: argmax(expected_beams(bench, belief)),
        NEAREST: argmax(-distances_from(bench, start)),
    }
