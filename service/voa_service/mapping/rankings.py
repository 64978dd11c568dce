"""Rankings: from requests to the Value of Assistance of looks, and to messages that rank looks and grasps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, ranked
from voa_core.lidars import SensorConfiguration
from voa_core.ranking import RankedLook, Spread, rank
from voa_core.ranking import Ranking as CoreRanking
from voa_core.scenario import Scenario
from voa_msgs.rankings import (
    GraspNow,
    Look,
    Outcome,
    RankedGrasp,
    RankedGrasps,
    RankedSensor,
    Ranking,
    VoaRequest,
)
from voa_service.mapping.beliefs import BeliefInput, belief_of
from voa_service.mapping.models import Model, Precision
from voa_service.mapping.sensors import candidates
from voa_service.runtime.queues import Check

ParallelMap = Spread
"""A `map` that applies a function to items in several threads, and returns the results in the order of the items."""


@dataclass(frozen=True, eq=False)
class RankingTask:
    """A request to rank looks, checked against its scenario.

    Attributes:
        model: of the scenario.
        request: as received.
        sensors: candidate looks.
        table: of the grasps that are reachable.
        belief: of the arm, over n poses.
        sensor_belief: of the sensor agent, where the request states another one; None: the arm's.
    """

    model: Model
    request: VoaRequest
    sensors: tuple[SensorConfiguration, ...]
    table: GraspTable
    belief: Belief
    sensor_belief: Belief | None

    @property
    def outer(self) -> Belief:
        """Belief over which the expectation of a look's outcomes is taken."""
        return self.belief if self.sensor_belief is None else self.sensor_belief

    @property
    def possible_poses(self) -> int:
        """Number of poses that have a probability: each look has so many outcomes."""
        return int(np.count_nonzero(self.outer.p))


def ranking_task(model: Model, belief: BeliefInput, request: VoaRequest) -> RankingTask:
    """Check a request to rank looks against its scenario.

    Args:
        model: of the scenario.
        belief: of the arm.
        request: names candidate looks and grasps.

    Raises:
        VoaError: the request does not fit the scenario.
    """
    scenario = model.scenario
    stated = request.sensor_belief
    return RankingTask(
        model=model,
        request=request,
        belief=belief_of(belief, scenario),
        sensors=candidates(scenario, request.sensors),
        table=scenario.table.reachable(request.grasps),
        sensor_belief=None if stated is None else belief_of(stated, scenario, "sensor_belief"),
    )


def ranking_message(
    task: RankingTask, precision: Precision, keep_weights: bool, parallel_map: ParallelMap, check: Check
) -> Ranking:
    """Rank looks by their Value of Assistance (Definition 5), as a message without the session's version.

    Args:
        task: checked request.
        precision: of the weights.
        keep_weights: True to keep them for the next ranking.
        parallel_map: applies the computation of one look to all of them.
        check: called often; an exception that it raises ends the ranking.

    Raises:
        VoaError: a prediction cannot be made.
    """
    ranking = rank(
        task.sensors,
        lambda sensor: task.model.weigher(sensor, precision, keep_weights, check),
        task.belief,
        task.table,
        task.model.scenario.policy,
        definition=task.request.definition,
        sensor_belief=task.sensor_belief,
        spread=parallel_map,
        check=check,
    )
    return _message(task, ranking, precision)


def ranked_grasps_message(
    scenario: Scenario, belief: Belief, names: Sequence[str] | None, version: int
) -> RankedGrasps:
    """Rank grasps by their expected score under a belief, as a message.

    Args:
        scenario: with the grasp table.
        belief: over its poses.
        names: of the grasps that are reachable, each possibly several names separated by commas; None: all.
        version: of the session whose belief it is.

    Raises:
        UnknownName: there is no such grasp.
    """
    table = scenario.table
    table = table.reachable(None if names is None else _separated(names, table.names))
    expected = table.expected_scores(belief.p)
    return RankedGrasps(
        version=version,
        grasps=[
            RankedGrasp(name=table.names[index], expected_score=float(expected[index])) for index in ranked(expected)
        ],
    )


def _separated(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Split names at commas, except where a name that exists contains the comma."""
    parts = ([name] if name in known else name.split(",") for name in names)
    return [part for some in parts for part in some]


def _message(task: RankingTask, ranking: CoreRanking, precision: Precision) -> Ranking:
    request, before = task.request, ranking.before
    best = None if before.index is None else task.table.names[before.index]
    min_gain = task.model.scenario.min_gain if request.min_gain is None else request.min_gain
    recommendation: Look | GraspNow
    if ranking.worth_looking(min_gain):
        first = ranking.looks[0]
        recommendation = Look(action="look", sensor=first.sensor.name, net_value=first.net_value)
    else:
        recommendation = GraspNow(action="grasp", grasp=best, expected_score=before.expected_score)
    return Ranking(
        version=None,
        definition=request.definition,
        method="exact",
        precision=precision,
        expected_score_before=before.expected_score,
        best_grasp_before=best,
        ranking=[_ranked_sensor(task, look, ranking.ties_with_first(look)) for look in ranking.looks],
        recommendation=recommendation,
    )


def _ranked_sensor(task: RankingTask, look: RankedLook, ties_with_first: bool) -> RankedSensor:
    outcomes = {"outcomes": _outcomes(task, look)} if task.request.outcomes else {}
    return RankedSensor(
        sensor=look.sensor.name,
        voa=look.assistance.voa,
        standard_error=None,
        cost=look.sensor.cost,
        net_value=look.net_value,
        expected_score_after=look.assistance.expected_score_after,
        ties_with_first=ties_with_first,
        **outcomes,
    )


def _outcomes(task: RankingTask, look: RankedLook) -> list[Outcome]:
    assistance = look.assistance
    return [
        Outcome(
            pose=task.model.scenario.poses.names[pose],
            probability=float(task.outer.p[pose]),
            best_grasp=None if grasp < 0 else task.table.names[grasp],
            expected_score=float(score),
        )
        for pose, grasp, score in zip(assistance.outcomes, assistance.best_grasps, assistance.scores, strict=True)
    ]
