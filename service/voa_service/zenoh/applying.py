"""Application of a look of a mapped robot to its session, exactly once among all replicas."""

from dataclasses import dataclass

from voa_ros.looks import GatheredLook, look_name
from voa_service.access.audit import record_write
from voa_service.access.callers import MAPPING
from voa_service.failures import NotAccepted
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.usecases.robots import LookOutcome
from voa_service.usecases.updates import Updates
from voa_service.zenoh.ledger import LookLedger
from voa_store.errors import KeyReused, LookRepeated
from voa_store.records import RobotLook

_TRIES = 5


@dataclass(frozen=True)
class DueLook:
    """A look that is due to be applied to a session.

    Attributes:
        robot: name of the robot in the mapping.
        taken: the look.
        ledger: the looks of the robot in that session.
        since: version of the session when the robot's stop began.
    """

    robot: str
    taken: GatheredLook
    ledger: LookLedger
    since: int


def apply_look(updates: Updates, due: DueLook) -> LookOutcome | None:
    """Apply a look to its session, unless another replica has applied it.

    Another process may write a look of this robot after the ledger was read and before this one is written. The store
    then refuses the write, because the look's number is taken; the ledger is read again, up to five times in all.

    Returns:
        The outcome, accepted or not; None where the session already has this look.

    Raises:
        Failure, StoreError: the look could not be applied.
    """
    for _ in range(_TRIES):
        number = due.ledger.next_number(due.taken, due.since)
        if number is None:
            return None
        outcome = _applied(updates, due, number)
        if outcome is not None:
            session, version = due.ledger.session, outcome.version
            record_write(MAPPING, "look.apply", 200, session=session, robot=due.robot, version=version)
            if outcome.update.accepted:
                due.ledger.accepted(number, outcome.version)
            return outcome
    raise NotAccepted("the belief is unchanged: this look was applied before, and was not accepted")


def _applied(updates: Updates, due: DueLook, number: int) -> LookOutcome | None:
    """Apply a look under a number; None where another process has used the number, perhaps for another look."""
    request, session = due.taken.request, due.ledger.session
    named = look_name(due.robot, session, number, due.taken)
    key = idempotency_key(named, scope_of(session), "scan", request)
    body = request.model_dump_json(exclude_unset=True, exclude_none=True).encode()
    counted = RobotLook(due.robot, number, due.taken.digest)
    try:
        response = updates.apply_scan(session, request, write_of("scan", body, key, look=counted))
    except (LookRepeated, KeyReused):
        return None
    except Exception:
        due.ledger.doubt(due.taken)
        raise
    return LookOutcome.model_validate_json(response.body)
