"""Rankings: looks by their Value of Assistance, grasps by their expected score."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property

from voa_msgs.rankings import RankedGrasps, RankingRequest, VoaRequest
from voa_service.failures import TooLarge
from voa_service.mapping.beliefs import BeliefInput, belief_digest
from voa_service.mapping.models import Models
from voa_service.mapping.rankings import ParallelMap, RankingTask, ranked_grasps_message, ranking_message, ranking_task
from voa_service.runtime.cache import Cache
from voa_service.runtime.queues import Check
from voa_service.settings import Limits
from voa_service.usecases.sessions import Sessions, model_in_body

_NUMBERS_OF_OUTCOME = 4


@dataclass(frozen=True)
class Question:
    """Request to rank looks under a belief.

    Attributes:
        scenario: id of the scenario.
        belief: over the scenario's poses; None: the scenario's prior.
        request: names candidate looks, grasps and options.
        version: of the session whose belief it is; None: the belief is that of no session.
    """

    scenario: str
    belief: BeliefInput
    request: VoaRequest
    version: int | None

    @cached_property
    def key(self) -> Hashable:
        """Key that is equal for questions with equal answers, in any session."""
        options = self.request.model_dump_json(exclude={"scenario", "belief"}, exclude_defaults=True)
        return self.scenario, belief_digest(self.belief), options


@dataclass(frozen=True)
class Answer:
    """A ranking as JSON, without the version of a session, so that it serves equal questions of several sessions."""

    body: str

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return len(self.body)

    def to(self, question: Question) -> bytes:
        """Return the response to one question as JSON, with the version of its session."""
        version = "null" if question.version is None else str(question.version)
        return f'{{"version":{version},{self.body[1:]}'.encode()


@dataclass(frozen=True)
class Rankings:
    """Use cases that rank looks and grasps.

    Attributes:
        sessions: use cases about sessions.
        models: of the scenarios.
        parallel_map: spreads the looks of a ranking over threads.
        kept: cache of answers by question.
        limits: of requests and responses.
    """

    sessions: Sessions
    models: Models
    parallel_map: ParallelMap
    kept: Cache
    limits: Limits

    def of_session(self, id_: str, request: VoaRequest) -> Question:
        """Build the question that ranks looks under a session's current belief.

        Raises:
            NotFound: there is no such session.
        """
        state = self.sessions.state(id_)
        return Question(state.scenario, state.belief, request, state.version)

    def once(self, request: RankingRequest) -> Question:
        """Build the question that ranks looks under the belief in the request; null: under the scenario's prior."""
        return Question(request.scenario, request.belief, request, None)

    def answer(self, question: Question, check: Check) -> Answer:
        """Rank looks; equal questions have one answer, which is kept for a while.

        Raises:
            Failure: there is no such scenario, or the response would be too large.
            VoaError: the question does not fit the scenario.
            Cancelled: raised by `check`, because nobody waits for the answer any more.
        """
        return self.kept.get(question.key, lambda: self._answer(question, check), check)

    def grasps(self, id_: str, names: Sequence[str] | None) -> RankedGrasps:
        """Rank grasps by their expected score under a session's belief.

        Args:
            id_: of the session.
            names: of the grasps that are reachable; None: all grasps.

        Raises:
            NotFound: there is no such session.
            UnknownName: there is no such grasp.
        """
        state = self.sessions.state(id_)
        return ranked_grasps_message(self.sessions.model_of(state).scenario, state.belief, names, state.version)

    def _answer(self, question: Question, check: Check) -> Answer:
        model = model_in_body(self.models, question.scenario)
        check()
        task = ranking_task(model, question.belief, question.request)
        if question.request.outcomes:
            self._check_outcomes(task)
        precision, keep = self.models.precision(len(task.sensors), len(model.scenario.poses))
        ranking = ranking_message(task, precision, keep, self.parallel_map, check)
        return Answer(ranking.model_dump_json(exclude={"version"}, exclude_unset=True))

    def _check_outcomes(self, task: RankingTask) -> None:
        """Refuse to list more outcomes than a response may hold."""
        sensors, poses = len(task.sensors), task.possible_poses
        most = self.limits.numbers // (_NUMBERS_OF_OUTCOME * max(1, poses))
        if sensors > most:
            raise TooLarge(
                f"the response would list {poses} outcomes for each of {sensors} sensors, and may hold at most "
                f"{self.limits.numbers} values: request at most {most} sensors at a time, or no outcomes",
            )
