"""Sessions of several looks: the robot looks, the belief is updated, and the next look is chosen."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from voa_core.checks import Floats
from voa_core.choices import LookWeights
from voa_core.estimates import Estimate
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Looks
from voa_core.places import Viewpoint, index_of_place
from voa_core.ranking import rank_looks
from voa_core.recommendation import recommend
from voa_core.scans import NO_RETURN, Scan
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling, samples_per_pose
from voa_core.updating import update_estimate
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.policies import (
    ENTROPY,
    NEAREST,
    RANDOM,
    VOA,
    VOA_EXACT,
    distances_from,
    expected_entropies,
)
from voa_evaluation.values.scans import random_source
from voa_evaluation.values.truth import argmax

LOOKS = 3
"""Number of looks of a session."""
SESSION_WAYS = (VOA, VOA_EXACT, ENTROPY, NEAREST, RANDOM)
"""Ways of choosing the looks of a session.

`voa` and `voa exact` follow the recommendation: they stop when no look surely pays, and take both looks of a pair. The
others take all looks, from each place once.
"""


@dataclass(frozen=True)
class SessionStep:
    """State of a session after so many looks.

    Attributes:
        looks: number of looks that could have been taken until now.
        taken: number of looks that were taken.
        promised: expected score of the best grasp.
        achieved: score of that grasp at the true pose.
        repeated: True if the session has looked from some place more than once.
        again: True if the last look was taken from a place that had been looked from.
        gain: promised gain of the last look, where the way promises one for a single look.
    """

    looks: int
    taken: int
    promised: float
    achieved: float
    repeated: bool
    again: bool
    gain: float | None


@dataclass(frozen=True)
class NextLook:
    """Choice of the next look: index of its place, that of the look after it in a pair, and the promised gain."""

    place: int
    then: int | None = None
    gain: float | None = None


@dataclass(eq=False)
class SessionBench:
    """Scans for sessions at a bench: the object lies still in a session, and so does the robot's error at a place.

    Attributes:
        bench: the object, rule and robot error.
        sessions: their number; the true poses take turns.
        seed: of the random choices.
    """

    bench: Bench
    sessions: int
    seed: int
    _ranges: dict[str, list[Floats]] = field(default_factory=dict)
    _evidence: dict[tuple[str, int, int], Evidence] = field(default_factory=dict)

    @property
    def samples(self) -> int:
        """Number of sessions of each pose."""
        return math.ceil(self.sessions / len(self.bench.scenario.poses))

    def row(self, session: int) -> tuple[int, int]:
        """Index of the true pose of a session, and of its scans."""
        pose, sample = session % len(self.bench.scenario.poses), session // len(self.bench.scenario.poses)
        return pose, pose * self.samples + sample

    def evidence(self, session: int, sensor: SensorConfiguration, look: int) -> Evidence:
        """Weigh the scan that a session takes from a place for the `look`-th time, from 0."""
        key = sensor.name, self.row(session)[1], look
        if key not in self._evidence:
            scenario = self.bench.scenario
            scan = Scan(self._scans_of(sensor)[look][key[1]], scenario.lidar.grid)
            self._evidence[key] = scenario.evidence(scan, sensor, self.bench.model.std)
        return self._evidence[key]

    def _scans_of(self, sensor: SensorConfiguration) -> list[Floats]:
        """Scans (N, beams) from a place, one array for each look in a row."""
        if sensor.name not in self._ranges:
            world = self.bench.world
            drawn = world.scans(sensor, Sampling("sessions", self.samples), listed=True, looks=LOOKS)
            beams = world.lidar.grid.beams
            dense = [np.full((len(scans.ranges), beams), NO_RETURN) for scans in drawn]
            for ranges, scans in zip(dense, drawn, strict=True):
                ranges[:, scans.columns] = scans.ranges
            self._ranges[sensor.name] = dense
        return self._ranges[sensor.name]


def run_sessions(scene: SessionBench) -> Mapping[str, Sequence[Sequence[SessionStep]]]:
    """Run all sessions with every way of choosing: the steps of each session, by way."""
    return {way: [_session(scene, way, index) for index in range(scene.sessions)] for way in SESSION_WAYS}


def _session(scene: SessionBench, way: str, session: int) -> list[SessionStep]:
    bench = scene.bench
    rng = random_source(scene.seed, "session", bench.object, session)
    start = rng.uniform(0.0, 2.0 * math.pi)
    shuffled = [int(index) for index in rng.permutation(len(bench.sensors))]
    estimate = Estimate.of(Belief.uniform(len(bench.scenario.poses)))
    visited: list[int] = []
    robot = math.cos(start), math.sin(start)
    steps = [_step(scene, session, estimate, visited, 0, None)]
    then: int | None = None
    for number in range(LOOKS):
        choice = _next(bench, way, estimate, visited, robot, shuffled) if then is None else NextLook(then)
        if choice is None:
            steps.append(replace(steps[-1], looks=number + 1, again=False, gain=None))
            continue
        then = choice.then
        sensor = bench.sensors[choice.place]
        evidence = scene.evidence(session, sensor, visited.count(choice.place))
        estimate = update_estimate(estimate, evidence, bench.scenario.policy, number).estimate
        visited.append(choice.place)
        robot = sensor.x, sensor.y
        steps.append(_step(scene, session, estimate, visited, number + 1, choice.gain))
    return steps


def _step(
    scene: SessionBench, session: int, estimate: Estimate, visited: Sequence[int], looks: int, gain: float | None
) -> SessionStep:
    table = scene.bench.scenario.table
    choice = best_grasp(table, estimate.belief.p)
    achieved = 0.0 if choice.index is None else float(table.scores[choice.index, scene.row(session)[0]])
    return SessionStep(
        looks=looks,
        taken=len(visited),
        promised=choice.expected_score,
        achieved=achieved,
        repeated=len(set(visited)) < len(visited),
        again=bool(visited) and visited.count(visited[-1]) > 1,
        gain=gain,
    )


def _next(
    bench: Bench,
    way: str,
    estimate: Estimate,
    visited: Sequence[int],
    robot: tuple[float, float],
    shuffled: Sequence[int],
) -> NextLook | None:
    """Choose the next look; None: grasp."""
    belief = estimate.belief
    if way in (VOA, VOA_EXACT):
        return _recommended(bench, way, estimate)
    if way == RANDOM:
        values = -np.argsort(np.array(shuffled)).astype(np.float64)
    elif way == NEAREST:
        values = -distances_from(bench, robot)
    else:
        values = -expected_entropies(bench, bench.simulated, belief)
    values[list(visited)] = -np.inf
    return NextLook(argmax(values))


def _recommended(bench: Bench, way: str, estimate: Estimate) -> NextLook | None:
    """Follow the recommendation of a ranking over simulated or exact scans, as the service makes it."""
    min_gain = bench.scenario.min_gain
    if way == VOA_EXACT:
        valuation = bench.exact_valuation(estimate.belief)
        ranking = rank_looks(bench.sensors, bench.exact, valuation)
        advice = recommend(ranking, bench.exact, valuation, min_gain=min_gain)
    else:
        valuation = bench.valuation(estimate.belief)
        sampling = Sampling(bench.scenario.seed, samples_per_pose(len(bench.scenario.poses)))
        looks = _looks_of_session(bench, estimate, bench.simulated, sampling)
        fresh = _looks_of_session(bench, estimate, bench.fresh, sampling.fresh())
        advice = recommend(
            rank_looks(bench.sensors, looks, valuation), looks, valuation, fresh=fresh, min_gain=min_gain
        )
    if advice.look is None:
        return None
    names = [sensor.name for sensor in bench.sensors]
    if advice.then is None:
        return NextLook(names.index(advice.look.sensor.name), gain=advice.look.assistance.voa)
    return NextLook(names.index(advice.look.sensor.name), names.index(advice.then.sensor.name))


def _looks_of_session(bench: Bench, estimate: Estimate, unvisited: Looks, sampling: Sampling) -> Looks:
    """Looks over simulated scans that know the session's earlier looks, as the service ranks them.

    Args:
        bench: the object, rule and robot error.
        estimate: of the session.
        unvisited: kept weights of the places that the session has not looked from.
        sampling: the samples of `unvisited`.
    """

    def of(sensor: SensorConfiguration, scans: int) -> LookWeights:
        viewpoint = Viewpoint.of(sensor, bench.scenario.lidar, listed=True)
        index = index_of_place(estimate.places, viewpoint)
        if index is None:
            return unvisited.of(sensor, scans)
        return SimulatedWeights.of(
            bench.model,
            sensor,
            sampling,
            np.float64,
            listed=True,
            looks=scans,
            log_sums=estimate.places[index].log_sums,
        )

    return Looks(of)
