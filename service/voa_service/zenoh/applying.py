"""Applying a look of a mapped robot to its session, once, whichever of the replicas does it."""

from dataclasses import dataclass

from voa_ros.looks import GatheredLook, look_name
from voa_service.failures import Failure, IdempotencyKeyReused, LookCounted, NotAccepted
from voa_service.ports import RobotLook
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.usecases.robots import LookOutcome
from voa_service.usecases.sessions import Sessions
from voa_service.zenoh.ledger import LookLedger

_TRIES = 5


@dataclass(frozen=True)
class DueLook:
    """A look to be applied to a session.

    Attributes:
        robot: name in the mapping.
        taken: the look.
        ledger: of the robot in that session.
        since: version of the session when the look's stop began.
    """

    robot: str
    taken: GatheredLook
    ledger: LookLedger
    since: int


def apply_look(sessions: Sessions, due: DueLook) -> LookOutcome | None:
    """Apply a look unless its session has it.

    Another process may count a look between the reading and the writing here; it is then looked for once more.

    Returns:
        What was answered, accepted or not; None: the session has this look.

    Raises:
        Failure: it could not be applied.
    """
    for _ in range(_TRIES):
        number = due.ledger.next_number(due.taken, due.since)
        if number is None:
            return None
        answer = _applied(sessions, due, number)
        if answer is not None:
            if answer.update.accepted:
                due.ledger.accepted(number, answer.version)
            return answer
    raise NotAccepted("the belief is unchanged: a look of this name was applied before, and not accepted")


def _applied(sessions: Sessions, due: DueLook, number: int) -> LookOutcome | None:
    """Apply a look under a number; None: another process was first, perhaps with a pose that differs by a hair."""
    request, session = due.taken.request, due.ledger.session
    named = look_name(due.robot, session, number, due.taken)
    key = idempotency_key(named, scope_of(session), "scan", request)
    body = request.model_dump_json(exclude_unset=True, exclude_none=True).encode()
    counted = RobotLook(due.robot, number, due.taken.digest)
    try:
        answered = sessions.apply_scan(session, request, write_of("scan", body, key, look=counted))
    except Failure as failure:
        if failure.kind in (LookCounted.kind, IdempotencyKeyReused.kind):
            return None
        due.ledger.doubt(due.taken)
        raise
    return LookOutcome.model_validate_json(answered.body)
