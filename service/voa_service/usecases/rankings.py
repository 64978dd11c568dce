"""Rankings: looks by their Value of Assistance, grasps by their expected score."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from voa_msgs.looks import AnnouncedLook
from voa_msgs.rankings import RankedGrasps, RankingRequest, VoaRequest
from voa_service.failures import TooLarge
from voa_service.mapping.beliefs import BeliefInput, belief_digest
from voa_service.mapping.estimates import absent_of
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.models import Model, Models
from voa_service.mapping.ranking_tasks import NO_LOOKS, RankingTask, SessionLooks, ranking_task
from voa_service.mapping.ranking_weights import Weighing
from voa_service.mapping.rankings import ParallelMap, ranked_grasps_message, ranking_message
from voa_service.mapping.under_way import announced_looks, stored_places
from voa_service.runtime.cache import Cache
from voa_service.runtime.queues import Check
from voa_service.settings import Limits
from voa_service.usecases.places import LookedFrom
from voa_service.usecases.sessions import Sessions, model_in_body
from voa_store.records import SessionState

_NUMBERS_OF_OUTCOME = 4
_MOST_RANGES = 2**23
"""Most ranges of the simulated scans of one place, of all beams: 64 MiB, and four times that for the first look."""


@dataclass(frozen=True)
class Question:
    """Request to rank looks under a belief.

    Attributes:
        scenario: id of the scenario.
        belief: over the scenario's poses; None: the scenario's prior.
        request: names candidate looks, grasps and options.
        version: of the session whose belief it is; None: the belief is that of no session.
        absent: probability that the object lies at none of the poses; None: it lies at one, or the scenario says.
        state: of the session; None: the belief is that of no session.
        under_way: announced looks of the session.
    """

    scenario: str
    belief: BeliefInput
    request: VoaRequest
    version: int | None
    absent: float | None = None
    state: SessionState | None = None
    under_way: tuple[AnnouncedLook, ...] = ()

    @cached_property
    def key(self) -> Hashable:
        """Key that is equal for questions with equal answers, in any session."""
        options = self.request.model_dump_json(exclude={"scenario", "belief"}, exclude_defaults=True)
        under_way = None if self.request.pending is not None else stored_places(self.under_way)
        return self.scenario, belief_digest(self.belief), options, self.absent, self._looks, under_way

    @property
    def record(self) -> LookRecord:
        """Record of the looks of the session."""
        return LookRecord() if self.state is None else record_of(self.state.looks)

    @property
    def _looks(self) -> Hashable:
        """Part of the key that names the looks of the session; looks that weigh all copies alike are equal anywhere."""
        record = self.record
        places = tuple((place.viewpoint, place.looks, place.copies) for place in record.places)
        own = self.state is not None and any(place.copies > 1 for place in record.places)
        session = (self.state.id, self.state.version) if self.state is not None and own else None
        return places, record.std, session


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
        places: use cases about the places that sessions were looked from.
        parallel_map: spreads the looks of a ranking over threads.
        kept: cache of answers by question.
        limits: of requests and responses.
        is_repeated: False where a process makes one ranking, for which no weights need to be kept.
    """

    sessions: Sessions
    models: Models
    places: LookedFrom
    parallel_map: ParallelMap
    kept: Cache
    limits: Limits
    is_repeated: bool = True

    def of_session(self, id_: str, request: VoaRequest) -> Question:
        """Build the question that ranks looks under a session's current belief.

        Raises:
            NotFound: there is no such session.
        """
        state = self.sessions.state(id_)
        under_way = tuple(announced_looks(state.under_way, self.sessions.now()))
        absent = absent_of(record_of(state.looks))
        return Question(state.scenario, state.belief, request, state.version, absent, state, under_way)

    def once(self, request: RankingRequest) -> Question:
        """Build the question that ranks looks under the belief in the request; null: under the scenario's prior."""
        return Question(request.scenario, request.belief, request, None, request.absent)

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
        absent = model.scenario.absent if question.state is None and question.absent is None else question.absent
        task = ranking_task(model, question.belief, question.request, absent, self._looks_of(question, model))
        self._check_predictions(task)
        if question.request.outcomes:
            self._check_outcomes(task)
        _check_scans(task)
        places = len(task.sensors)
        precision = self.models.precision(places * task.weights_of_place)
        is_used_again = self.is_repeated or task.may_rank_pairs
        keep = is_used_again and self.models.keeps_weights(
            places, task.scans_of_place, len(model.scenario.poses), precision
        )
        ranking = ranking_message(task, Weighing(precision, keep, check), self.parallel_map)
        return Answer(ranking.model_dump_json(exclude={"version"}, exclude_unset=True))

    def _looks_of(self, question: Question, model: Model) -> SessionLooks:
        state = question.state
        if state is None:
            return NO_LOOKS
        log_sums = partial(self.places.log_sums, state, model.scenario)
        return SessionLooks(state.id, question.record, question.under_way, log_sums)

    def _check_predictions(self, task: RankingTask) -> None:
        """Refuse to keep a worker for so many places and poses as a process of its own should have."""
        places, poses, most = len(task.sensors), len(task.scenario.poses), self.limits.predicted_scans
        if places * poses > most:
            raise TooLarge(
                f"the ranking would predict a scan of each of {poses} poses at each of {places} places, and may "
                f"predict at most {most} (VOA_LIMITS__PREDICTED_SCANS): rank at most {most // poses} places at a time, "
                "or rank the scenario file with `voa rank --local`, which has no such limit"
            )

    def _check_outcomes(self, task: RankingTask) -> None:
        """Refuse to list more outcomes than a response may hold."""
        sensors, poses = len(task.sensors), task.possible_poses
        most = self.limits.numbers // (_NUMBERS_OF_OUTCOME * max(1, poses))
        if sensors > most:
            raise TooLarge(
                f"the response would list {poses} outcomes for each of {sensors} sensors, and may hold at most "
                f"{self.limits.numbers} values: request at most {most} sensors at a time, or no outcomes",
            )


def _check_scans(task: RankingTask) -> None:
    """Refuse more simulated scans than those of one place may take memory for."""
    poses, beams = len(task.scenario.poses), task.scenario.lidar.grid.beams
    ranges = (task.samples or 0) * poses * beams
    if ranges > _MOST_RANGES:
        raise TooLarge(
            f"{task.samples} simulated scans of each of {poses} poses have {ranges} ranges of {beams} beams at one "
            f'place, and may have at most {_MOST_RANGES}: request fewer `samples`, or `scans` = "exact", or a scenario '
            "of fewer poses"
        )
