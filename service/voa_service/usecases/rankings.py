"""Rankings: looks by their Value of Assistance, grasps by their expected score."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256

import numpy as np

from voa_core.errors import VoaError
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, ranked
from voa_core.ranking import OrderedMap, RankedLook, rank
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
from voa_service.failures import TooLarge, UnknownReference, of_core
from voa_service.mapping.models import Model, Models, Precision
from voa_service.mapping.scenarios import candidates
from voa_service.runtime.cache import Cache
from voa_service.runtime.queues import Check
from voa_service.settings import Limits
from voa_service.usecases.sessions import Sessions, belief_in_body

_NUMBERS_OF_OUTCOME = 4


@dataclass(frozen=True)
class Question:
    """Question that a ranking answers.

    Attributes:
        scenario: its id.
        belief: over its poses; None: the scenario's prior.
        request: which looks, and how.
        version: of the session whose belief it is; None: of none.
    """

    scenario: str
    belief: Belief | Sequence[float] | None
    request: VoaRequest
    version: int | None

    @cached_property
    def key(self) -> Hashable:
        """Equal for questions with equal answers, whatever the session."""
        rest = self.request.model_dump_json(exclude={"scenario", "belief"}, exclude_defaults=True)
        return self.scenario, _digest(self.belief), rest


@dataclass(frozen=True)
class Answer:
    """A ranking as JSON, which lacks the version of the session that asked."""

    body: str

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return len(self.body)

    def to(self, question: Question) -> bytes:
        """The answer to whoever asked, as JSON."""
        version = "null" if question.version is None else str(question.version)
        return f'{{"version":{version},{self.body[1:]}'.encode()


@dataclass(frozen=True)
class Rankings:
    """Everything about where to look and what to grasp."""

    sessions: Sessions
    models: Models
    ordered_map: OrderedMap
    kept: Cache
    """Answers, by question."""
    limits: Limits

    def of_session(self, id_: str, request: VoaRequest) -> Question:
        """Ask to rank looks under a session's belief as it is now."""
        state = self.sessions.state(id_)
        return Question(state.scenario, state.belief, request, state.version)

    def once(self, request: RankingRequest) -> Question:
        """Ask to rank looks under the belief in the request, or the scenario's prior where that is null."""
        return Question(request.scenario, request.belief, request, None)

    def answer(self, question: Question, check: Check) -> Answer:
        """Rank looks; equal questions have one answer, which is kept for a while.

        Raises:
            Failure: the question does not fit the scenario, or there is no such scenario.
            Cancelled: `check` found that nobody waits any more.
        """
        return self.kept.get(question.key, lambda: self._answer(question, check), check)

    def _answer(self, question: Question, check: Check) -> Answer:
        model = self._model(question.scenario)
        check()
        belief = question.belief
        if not isinstance(belief, Belief):
            belief = belief_in_body(model.scenario, belief)
        ranking = self._rank(model, belief, question.request, check)
        return Answer(ranking.model_dump_json(exclude={"version"}, exclude_unset=True))

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
            raise UnknownReference(f"there is no scenario {id_!r}: create it with POST /v1/scenarios")
        return model

    def _check_outcomes(self, sensors: int, poses: int) -> None:
        """Refuse to list more outcomes than an answer may hold."""
        most = self.limits.numbers // (_NUMBERS_OF_OUTCOME * max(1, poses))
        if sensors > most:
            raise TooLarge(
                f"the answer would list {poses} outcomes of each of {sensors} sensors, at most {self.limits.numbers} "
                f"values fit: ask for at most {most} sensors at a time, or without outcomes",
            )

    def _rank(self, model: Model, belief: Belief, request: VoaRequest, check: Check) -> Ranking:
        scenario = model.scenario
        try:
            sensors = candidates(scenario, request.sensors)
            table = scenario.table.reachable(request.grasps)
            sensor_belief = None
            if request.sensor_belief is not None:
                sensor_belief = Belief.of(request.sensor_belief, "sensor_belief", len(scenario.poses))
            outer = belief if sensor_belief is None else sensor_belief
            if request.outcomes:
                self._check_outcomes(len(sensors), int(np.count_nonzero(outer.p)))
            precision, keep = self.models.precision(len(sensors), len(scenario.poses))
            ranking = rank(
                sensors,
                lambda sensor: model.weigher(sensor, precision, keep, check),
                belief,
                table,
                scenario.policy,
                definition=request.definition,
                sensor_belief=sensor_belief,
                ordered_map=self.ordered_map,
                check=check,
            )
        except VoaError as error:
            raise of_core(error) from error
        return _message(ranking, table, scenario, outer, request, precision)


def _digest(belief: Belief | Sequence[float] | None) -> bytes | None:
    """Equal for equal beliefs; one that is given and one that a session has are never equal."""
    if belief is None:
        return None
    if isinstance(belief, Belief):
        return sha256(b"session" + belief.p.tobytes() + belief.log_p.tobytes()).digest()
    return sha256(b"given" + np.asarray(belief, dtype=np.float64).tobytes()).digest()


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
        version=None,
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
