"""Requests of the simulated clients, made as the entrypoints make them, and what their responses say."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from tests.simulation.plan import Operation
from tests.simulation.replica import UseCases
from tests.simulation.robot import ROBOT_NAME
from tests.support.histories import Kind, Outcome
from tests.support.serving import SCORES
from voa_msgs.looks import LookAnnouncement
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, SessionRequest
from voa_ros.looks import GatheredLook
from voa_service.failures import Failure
from voa_service.guard import EXPECTED_ERRORS, failure_of
from voa_service.requests.idempotency import idempotency_key, scope_of, scope_of_caller, write_of
from voa_store.records import StoredResponse

CALLER = "simulation"
_PAGE = 1_000


@dataclass(frozen=True)
class Request:
    """A request to the service.

    Attributes:
        kind: for the checker of histories.
        name: of the call.
        session: id of the session that it is about; empty: it makes one.
        key: idempotency key; None: it has none.
        body: as it is received, in UTF-8.
        if_match: version that the client accepts; None: any.
        act: does the work in a process.
    """

    kind: Kind
    name: str
    session: str
    key: str | None
    body: str
    if_match: int | None
    act: Callable[[UseCases], StoredResponse | None]


@dataclass(frozen=True)
class Reply:
    """Response of a process: one of the two, or neither where the call has no body.

    Attributes:
        response: of success.
        failure: of a refusal.
        clock: of the process before and after the work, seconds since 1970.
    """

    response: StoredResponse | None
    failure: Failure | None
    clock: tuple[float, float]

    @property
    def facts(self) -> dict[str, Any]:
        """The response's JSON; empty where it has no body."""
        body = "" if self.response is None else self.response.body
        parsed: dict[str, Any] = json.loads(body) if body else {}
        return parsed


def reply_of(request: Request, inside: UseCases, now: Callable[[], float]) -> Reply:
    """Do the work of a request in a process; an unexpected error of the service passes."""
    began = now()
    try:
        response = request.act(inside)
    except EXPECTED_ERRORS as error:
        return Reply(None, failure_of(error), (began, now()))
    return Reply(response, None, (began, now()))


def outcome_of(request: Request, reply: Reply) -> tuple[Outcome, int | None]:
    """Return the outcome of a call, and the version that it made or read."""
    if reply.failure is not None:
        if reply.failure.status in (500, 503):
            return "unknown", None
        absent = reply.failure.kind == "not-found" and request.name != "cancel"  # which misses the look
        return ("gone" if absent and request.kind != "delete" else "refused"), None
    if request.kind in ("create", "delete"):
        return "made", 0 if request.kind == "create" else None
    if reply.response is None:
        raise RuntimeError("a write was answered without a response")
    if request.kind == "read":
        return "read", reply.response.version
    update = reply.facts.get("update", {"accepted": "belief" in reply.facts})
    return ("made" if update["accepted"] else "kept"), reply.response.version


def creation(number: int, scenario: str) -> Request:
    """Make the request that opens a session, with a prior that no other one has."""
    share = (1.0 + 1e-4 * number) / (3.0 + 1e-4 * number)
    body = SessionRequest(scenario=scenario, prior=[share, (1.0 - share) / 2, (1.0 - share) / 2])
    key, text = f"create {number}", body.model_dump_json()
    named = idempotency_key(key, scope_of_caller(CALLER), "create session", body)
    return Request(
        "create",
        "create",
        "",
        key,
        text,
        None,
        lambda inside: inside.sessions.create(body, write_of("prior", text.encode(), named)),
    )


def deletion(number: int, session: str) -> Request:
    """Make the request that deletes a session."""
    key = f"delete {number}"
    named = idempotency_key(key, scope_of(session), "delete", None)

    def act(inside: UseCases) -> None:
        inside.sessions.delete(session, named, None)

    return Request("delete", "delete", session, key, "", None, act)


def reading(session: str) -> Request:
    """Make the request that reads a session."""
    return Request("read", "read", session, None, "", None, lambda inside: inside.sessions.response(session))


def observation(operation: Operation, session: str, known: int | None) -> Request:
    """Make the request of a scan, an outcome or a belief; each scan and belief is unlike all others."""
    body = _observation(operation)
    if_match = known if operation.conditional else None
    versions = None if if_match is None else frozenset({if_match})
    text, key, kind = body.model_dump_json(exclude_unset=True), _key(operation), operation.kind
    named = idempotency_key(key, scope_of(session), kind, body)

    def act(inside: UseCases) -> StoredResponse:
        received = text.encode()
        match body:
            case ScanRequest():
                return inside.updates.apply_scan(session, body, write_of("scan", received, named, versions))
            case OutcomeRequest():
                return inside.updates.report_outcome(session, body, write_of("outcome", received, named, versions))
            case BeliefRequest():
                return inside.updates.put_belief(session, body, write_of("belief", received, named, versions))
        raise TypeError(type(body))

    return Request("write", operation.kind, session, key, text, if_match, act)


def announcement(operation: Operation, session: str) -> Request:
    """Make the request that announces a look."""
    body = LookAnnouncement(sensor=operation.sensor, robot=f"robot{operation.number}")
    key, text = _key(operation), body.model_dump_json()
    named = idempotency_key(key, scope_of(session), "look", body)
    return Request(
        "write",
        "announce",
        session,
        key,
        text,
        None,
        lambda inside: inside.looks.announce(session, body, write_of("look", text.encode(), named)),
    )


def withdrawal(operation: Operation, session: str, look: str) -> Request:
    """Make the request that withdraws an announced look."""
    key = _key(operation)
    named = idempotency_key(key, scope_of(session), f"cancel look {look}", None)
    return Request(
        "write",
        "cancel",
        session,
        key,
        "",
        None,
        lambda inside: inside.looks.cancel(session, look, write_of("look", b"", named)),
    )


def gathered(operation: Operation) -> GatheredLook:
    """Make a look of the mapped robot: equal wherever the revolutions of this operation were received."""
    request = _scan(operation, stamp={"robot": ROBOT_NAME, "number": operation.number})
    return GatheredLook(f"{operation.number:032x}", request)


def _observation(operation: Operation) -> BaseModel:
    number = operation.number
    if operation.kind == "scan":
        return _scan(operation, stamp=number)
    if operation.kind == "outcome":
        moved = 1e-6 * number if number % 5 == 0 else 0.0
        return OutcomeRequest(grasp=f"G{1 + number % len(SCORES)}", success=number % 3 > 0, object_moved=moved)
    share = 0.2 + 1e-4 * number % 0.5
    return BeliefRequest(belief=None if number % 7 == 0 else [share, 0.9 - share, 0.1])


def _scan(operation: Operation, stamp: Any) -> ScanRequest:
    far = 1e-4 * (operation.number % 500)
    scan = Scan(ranges=[0.5 + far, 0.5, None, 1.0 - far], stamp=stamp)
    return ScanRequest(sensor=operation.sensor, scan=scan)


def _key(operation: Operation) -> str | None:
    return f"{operation.kind} {operation.number}" if operation.keyed else None
