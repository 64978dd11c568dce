"""Rankings: looks by their Value of Assistance, grasps by their expected score."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_core.errors import VoaError
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, ranked
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
    RankingRequest,
    VoaRequest,
)
from voa_service.failures import UNKNOWN, Failure, of_core
from voa_service.mapping import candidates
from voa_service.models import Model, Models, Precision
from voa_service.usecases.sessions import Sessions, belief_in_body


@dataclass(frozen=True)
class Rankings:
    """Everything about where to look and what to grasp."""

    sessions: Sessions
    models: Models
    spread: Spread

    def of_session(self, id_: str, request: VoaRequest) -> Ranking:
        """Rank looks under a session's belief."""
        state = self.sessions.state(id_)
        return self._rank(self._model(state.scenario), state.belief, request, state.version)

    def once(self, request: RankingRequest) -> Ranking:
        """Rank looks under the belief in the request, or the scenario's prior where that is null; stores nothing."""
        model = self._model(request.scenario)
        return self._rank(model, belief_in_body(model.scenario, request.belief), request, None)

    def grasps(self, id_: str, names: Sequence[str] | None) -> RankedGrasps:
        """Grasps under a session's belief, those that are reachable now."""
        state = self.sessions.state(id_)
        table = self.sessions.scenario_of(state).table
        try:
            table = table.reachable(None if names is None else _separated(names, table.names))
        except VoaError as error:
            raise of_core(error) from error
        expected = table.expected_scores(state.belief.p)
        return RankedGrasps(
            version=state.version,
            grasps=[
                RankedGrasp(name=table.names[index], expected_score=float(expected[index]))
                for index in ranked(expected)
            ],
        )

    def _model(self, id_: str) -> Model:
        model = self.models.get(id_)
        if model is None:
            raise Failure(UNKNOWN, f"there is no scenario {id_!r}: create it with POST /v1/scenarios")
        return model

    def _rank(self, model: Model, belief: Belief, request: VoaRequest, version: int | None) -> Ranking:
        scenario = model.scenario
        try:
            sensors = candidates(scenario, request.sensors)
            table = scenario.table.reachable(request.grasps)
            sensor_belief = None
            if request.sensor_belief is not None:
                sensor_belief = Belief.of(request.sensor_belief, "sensor_belief", len(scenario.poses))
            precision, keep = self.models.precision(len(sensors), len(scenario.poses))
            ranking = rank(
                sensors,
                lambda sensor: model.weigher(sensor, precision, keep),
                belief,
                table,
                scenario.policy,
                definition=request.definition,
                sensor_belief=sensor_belief,
                spread=self.spread,
            )
        except VoaError as error:
            raise of_core(error) from error
        outer = belief if sensor_belief is None else sensor_belief
        return _message(ranking, table, scenario, outer, request, version, precision)


def _separated(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Names as they come in a query: repeated, or separated by commas where that is no name itself."""
    parts = ([name] if name in known else name.split(",") for name in names)
    return [part for found in parts for part in found]


def _message(
    ranking: CoreRanking,
    table: GraspTable,
    scenario: Scenario,
    outer: Belief,
    request: VoaRequest,
    version: int | None,
    precision: Precision,
) -> Ranking:
    first, before = ranking.looks[0], ranking.before
    best = None if before.index is None else table.names[before.index]
    recommendation: Look | GraspNow
    if ranking.worth_looking(scenario.min_gain if request.min_gain is None else request.min_gain):
        recommendation = Look(action="look", sensor=first.sensor.name, net_value=first.net_value)
    else:
        recommendation = GraspNow(action="grasp", grasp=best, expected_score=before.expected_score)
    return Ranking(
        version=version,
        definition=request.definition,
        method="exact",
        precision=precision,
        expected_score_before=before.expected_score,
        best_grasp_before=best,
        ranking=[
            _ranked(
                look,
                ranking.ties_with_first(look),
                _outcomes(look, table, scenario, outer) if request.outcomes else None,
            )
            for look in ranking.looks
        ],
        recommendation=recommendation,
    )


def _ranked(look: RankedLook, ties_with_first: bool, outcomes: list[Outcome] | None) -> RankedSensor:
    asked = {} if outcomes is None else {"outcomes": outcomes}
    return RankedSensor(
        sensor=look.sensor.name,
        voa=look.assistance.voa,
        standard_error=None,
        cost=look.sensor.cost,
        net_value=look.net_value,
        expected_score_after=look.assistance.expected_score_after,
        ties_with_first=ties_with_first,
        **asked,
    )


def _outcomes(look: RankedLook, table: GraspTable, scenario: Scenario, outer: Belief) -> list[Outcome]:
    found = look.assistance
    return [
        Outcome(
            pose=scenario.poses.names[pose],
            probability=float(outer.p[pose]),
            best_grasp=None if grasp < 0 else table.names[grasp],
            expected_score=float(score),
        )
        for pose, grasp, score in zip(found.outcomes, found.best_grasps, found.scores, strict=True)
    ]
